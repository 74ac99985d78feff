"""Sixty wrong calls: each is answered by the value that is wrong, and by what to do about it.

Of each a command line, the value as the message repeats it, and the remedy as it says it.
"""

from __future__ import annotations

from typing import NamedTuple


class WrongCall(NamedTuple):
    """A command line, and what the one line of its answer holds."""

    arguments: str
    value: str
    remedy: str


ROBOTS = "known are psp3, five_bar"
MOTIONS = "must be helix, circle, line, point-to-point, hold, sway or csv:FILE"
NUMBER = "should be a valid number"
WHOLE = "should be a valid integer"

WRONG_CALLS = tuple(
    WrongCall(*call)
    for call in (
        # Names of commands and options
        ("simulat", "'simulat'", "Did you mean 'simulate'?"),
        ("pose --hights 0,0,0", "--hights", "--height"),
        ("pose --heights", "'--heights'", "requires an argument"),
        ("pose", "psp3 pose", "give one of --heights, --tip, or --height with --tilt"),
        ("export", "psp3 export", "give a command: c or fmu (see psp3 export --help)"),
        ("check", "'FILE...'", "see psp3 check --help"),
        # Robots
        ("pose nosuch", "'nosuch'", ROBOTS),
        ("pose nosuch", "'nosuch'", "for your own robot give the file: my_robot.urdf, or an .xml"),
        ("info nosuch.urdf", "nosuch.urdf", "correct its name, or give its folder, too"),
        ("info five_bar --free maybe", "'maybe'", "'lock', 'keep', 'refuse'"),
        ("info five_bar --actuated nosuch", "'nosuch'", "its joints are leg1_shoulder"),
        ("simulate psp3 more.yaml", "LOOPS", "does not apply to the 3-PSP"),
        ("pose --parameters mine", "'mine'", "'default', 'table_3_1', 'table_5_1'"),
        ("pose delta --frame nosuch", "'nosuch'", "known are universe, base"),
        ("pose delta --tilt 3", "--tilt", "of which --positions are known"),
        ("pose psp3 --frame tip", "--frame", "is for other robots"),
        # Numbers
        ("pose --heights 1,2", "--heights 1,2 has 2 numbers", "3 are needed, separated by commas"),
        ("pose --heights a,b,c", "'a,b,c'", "a list of numbers separated by commas"),
        ("pose --heights 0,nan,0", "nan", "--heights must be finite numbers"),
        ("pose --heights -0.6,0,0.6", "[-0.6, 0. , 0.6]", "bring the heights closer together"),
        ("pose --tip 1,2", "'1,2' has 2 numbers", "three are needed, separated by commas"),
        ("pose --tip 5,5,5", "7071.1 mm", "reaches 34.1 mm: bring it nearer to the axis"),
        ("pose --tilt abc", "'abc'", NUMBER),
        ("pose --tilt 90", "got 90", "--tilt must be less than 90 degrees"),
        ("pose --tilt 75 --azimuth 30", "-0.585001", "any tilt below 70.53 degrees is safe"),
        ("pose delta --positions 0,0", "0,0 has 2", "leg1_shoulder, leg2_shoulder, leg3_shoulder"),
        ("dynamics --heights 0,0,0 --speeds 0,inf,0", "inf", "--speeds must be finite numbers"),
        ("dynamics five_bar --positions 9,9", "-8.63479", "a pose nearer to the reference pose"),
        ("simulate --kp abc", "'abc'", NUMBER),
        ("simulate --kp -1", "got -1.0", "--kp must be finite and not negative"),
        ("simulate --period 0", "got 0.0", "--period must be finite and positive"),
        ("simulate --duration -1", "got -1.0", "--duration must be finite and positive"),
        ("simulate --torque-limit 0", "'0'", "is not a list of positive numbers"),
        ("simulate --torque-limit 1,2", "1,2 has 2 numbers", "3 are needed"),
        ("torques --sampling-period 0", "got 0.0", "--sampling-period must be finite and positive"),
        ("torques --sampling-period 60", "got 60.0", "at most the duration, 10.4 s"),
        ("view --record new.html --trajectory=", "got ''", "must be helix, circle, line"),
        ("export c delta --out new --name=", "got ''", "--name must be letters, digits and _"),
        ("study new.sqlite --seeds 0", "got '0'", "should be greater than or equal to 1"),
        ("reproduce --seeds x", "'x'", WHOLE),
        # What is simulated
        ("simulate --controller fuzzy", "'fuzzy'", "is not one of 'pd'"),
        ("simulate --ki 3", "--ki", "--controller ctc, which takes --kp and --kv"),
        ("simulate --model nosuch", "'nosuch'", "'closed_form', 'core', 'pinocchio', 'noc'"),
        ("simulate --trajectory spiral", "'spiral'", MOTIONS),
        ("simulate --trajectory line", "--trajectory line", "needs --start and --end"),
        ("simulate --radius 0.03", "30.0 mm", "choose a smaller radius"),
        ("simulate --start-height 0.5", "asks for positions [", "move or shrink the path"),
        ("simulate --initial-speed fast", "'fast'", "'rest', 'path'"),
        # What is learned
        ("train out.json --kind t3", "'t3'", "known are t1, it2, gt2"),
        ("train out.json --terms 99", "got 99", "--terms must be at most 32"),
        ("train out.json --terms 0", "got 0", "--terms must be a whole number of at least 1"),
        ("train out.json --learner best", "'best'", "known are strongest, strict, average"),
        ("train out.json --mean-variation -1", "got -1.0", "--mean-variation must be finite"),
        ("train out.json --seed -1", "got '-1'", "should be greater than or equal to 0"),
        # Files
        ("simulate --out run.txt", "run.txt", "the name of a result must end in .npz"),
        ("simulate --csv run.json", "run.json", "the name of a table must end in .csv"),
        ("simulate --figure run.gif", "run.gif", "must end in .pdf, .png, .svg"),
        ("train out.txt", "out.txt", "the name of a controller must end in .json"),
        ("export fmu delta --out out.txt", "out.txt", "the name of an FMU must end in .fmu"),
        ("view --record page.txt", "page.txt", "the name of a page must end in .html"),
        ("simulate --out none/run.npz", "none/run.npz", "there is no directory none"),
        ("simulate --trained none.json", "none.json", "correct its name"),
        ("simulate --trajectory csv:none.csv", "none.csv", "correct its name"),
        ("train out.json --record here.csv", "here.csv", "the first line must name the columns"),
        ("reproduce --out here.csv", "here.csv", "name a directory"),
        ("simulate --json --csv -", "--csv -", "give --csv a file"),
    )
)
