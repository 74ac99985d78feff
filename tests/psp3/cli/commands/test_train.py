"""``psp3 train`` on measured forces; on recorded M, C and G it is beside ``psp3 simulate``."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

import psp3
from psp3.cli import options
from psp3.control.default_gains import default_gains
from psp3.trajectories.fourier_series import FourierSeries
from tests.psp3.cli.answers import Run


def test_a_controller_is_trained_on_measured_forces(psp3_command: Run) -> None:
    """The forces of a run of exact computed torque, in the file that ``simulate`` writes.

    The same controller as from Python. What its forces miss on the way, 2 % at most, is what they
    change within a control period, for which each is held: 2 ms of a motion with 5 harmonics of 3 s
    turn by 2 % of a radian.
    """
    robot, rng = psp3.load("five_bar"), np.random.default_rng(1)
    sway = psp3.trajectories.Sway(robot=robot)
    shares = 0.35 * sway.amplitudes / np.arange(1, 6)[:, np.newaxis]
    sines, cosines = rng.normal(size=(2, *shares.shape)) * shares
    path = FourierSeries(sway.center, sines, cosines, 3.0, robot)
    t = np.arange(0.0, 3.01, 0.01)
    np.savetxt(
        "path.csv",
        np.column_stack([t, path.joints(t)[0]]),
        delimiter=",",
        header=",".join(("t", *robot.actuated)),
        comments="",
        fmt="%.17g",
    )
    run = ("--trajectory", "csv:path.csv", "--initial-speed", "path", "--csv", "run.csv")
    assert psp3_command("simulate", "five_bar", *run).status == 0
    options = ("--kind", "t1", "--coriolis", "mass", "--record", "run.csv")
    answer = psp3_command("train", "t1.json", "five_bar", *options)
    assert answer.status == 0, answer.err
    measured = psp3.trajectories.measured_motion("run.csv", robot)
    gains = default_gains(robot, "ctc")
    expected = psp3.FuzzyComputedTorque("t1", robot, coriolis="mass", **gains)
    expected.learn_from_motion(*measured[1:])
    found = psp3.FuzzyComputedTorque.load("t1.json", robot)
    assert found.coriolis == "mass"
    for ours, theirs in zip(found.systems_, expected.systems_, strict=True):
        np.testing.assert_array_equal(ours.consequents, theirs.consequents)
    missed = [
        float(share)
        for name in robot.actuated
        for share in re.findall(rf"{name}\s+([0-9.]+)%", answer.out)
    ]
    assert len(missed) == 2
    assert max(missed) < 2.0


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("five_bar", "--record", "none.csv"), "none.csv: no such file"),
        (("--record", "none.csv", "--radius", "0.01"), "--radius does not apply to --record"),
        (("--record", "none.csv", "--snr", "20"), "--snr does not apply to --record"),
        (("--terms", "5"), "use fewer terms, or take --learner strict"),
        (("delta", "--learner", "strict"), "needs a grid: give --terms"),
        (("--coriolis", "mass"), "'rules' for a robot whose M is learned from speeds"),
    ],
)
def test_a_record_that_cannot_be_learned_from_is_refused(
    psp3_command: Run, arguments: tuple[str, ...], words: str
) -> None:
    answer = psp3_command("train", "a.json", *arguments)
    assert answer.status == options.USAGE
    assert words in answer.err
    assert not Path("a.json").exists()


def test_no_zero_has_a_sign(psp3_command: Run) -> None:
    """A range from -0.00004 on, of a robot that sways by so little."""
    options = ("--trajectory", "sway", "--amplitude", "0.00004", "--duration", "1")
    answer = psp3_command("train", "t1.json", "five_bar", "--kind", "t1", *options)
    assert answer.status == 0, answer.err
    assert "0.0000" in answer.out
    assert "-0.0000" not in answer.out
