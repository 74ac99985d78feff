"""Reading a file of any format runs nothing that is in it, starts nothing, and asks nobody.

Python tells a hook of all that it compiles, executes, imports, opens, connects to and starts. Each
file is read once, which imports what its reader needs, and once more with the hook listening. What
Pinocchio does in C++ is told to nobody: it is given texts that were read here.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import fuzzy2
import psp3
from psp3.description.parts import ROBOT_FILES

LISTEN = """
import json, sys
heard = []
listening = False

def hook(event, arguments):
    if listening and not event.startswith(("object.", "sys._getframe", "gc.")):
        heard.append((event, [str(one) for one in arguments[:2]]))

{before}

def read():
    {read}

read()
sys.addaudithook(hook)
listening = True
read()
listening = False
print(json.dumps(heard))
"""

# Python compiles the headers of NumPy's arrays to see what they say; nothing runs them.
RUN = ("exec", "os.system", "os.exec", "os.fork", "os.posix_spawn", "subprocess.Popen")
ASK = ("socket.connect", "socket.bind", "socket.getaddrinfo", "urllib.Request", "webbrowser.open")
LOAD = ("import", "pickle.find_class", "marshal.loads", "ctypes.dlopen")

FUZZY = fuzzy2.Type1System(
    [[fuzzy2.Gaussian(0.0, 1.0), fuzzy2.Gaussian(1.0, 1.0)]], [[0], [1]], [[0.0], [1.0]]
)

SDF = """<sdf version="1.9"><model name="m"><link name="a"><inertial><mass>1</mass></inertial>
</link><joint name="first" type="revolute"><parent>world</parent><child>a</child><axis>
<xyz>0 1 0</xyz></axis></joint></model></sdf>"""


def read_in(folder: Path, kind: str) -> tuple[str, str]:
    """Write a file of a kind, and return the modules and the line that read it."""
    path = str(folder / f"one.{kind}")
    if kind in ("json", "fis", "fml", "fll", "fcl"):
        fuzzy2.save(FUZZY.replace(output_ranges=[(0.0, 1.0)]), path)
        return "import fuzzy2", f"fuzzy2.load({path!r})"
    load = "import psp3\nfrom psp3.robots.closed_loop_robot import ClosedLoopRobot as Robot"
    if kind in ("urdf", "xml"):
        name = "five_bar" if kind == "urdf" else "gripper"
        for suffix in ("urdf", "yaml", "srdf", "xml"):
            source = ROBOT_FILES / f"{name}.{suffix}"
            if source.exists():
                (folder / f"one.{suffix}").write_bytes(source.read_bytes())
        files = [str(folder / f"one.{suffix}") for suffix in ("urdf", "yaml", "srdf")]
        return load, f"Robot.from_urdf(*{files!r})" if kind == "urdf" else (
            f"Robot.from_mjcf({path!r})"
        )
    if kind == "sdf":
        Path(path).write_text(SDF, encoding="utf-8")
        return load, f"Robot.from_sdf({path!r}, ['first'])"
    if kind == "csv":
        rows = "".join(f"{0.1 * k},{0.1},{0.1},{0.1}\n" for k in range(9))
        Path(path).write_text(f"t,a1,a2,a3\n{rows}", encoding="utf-8")
        read = f"psp3.trajectories.FromCSV({path!r}, robot)"
        return f"{load}\nrobot = psp3.load('psp3')", read
    robot = psp3.load("psp3")
    hold = psp3.trajectories.Hold(robot=robot)
    psp3.simulate(robot, psp3.PD(10.0, 1.0), hold, duration=0.01).save(path)
    return "import psp3", f"psp3.load_result({path!r})"


@pytest.mark.slow
@pytest.mark.parametrize(
    "kind", ["json", "fis", "fml", "fll", "fcl", "urdf", "xml", "sdf", "csv", "npz"]
)
def test_reading_opens_the_file_and_does_nothing_else(kind: str, tmp_path: Path) -> None:
    before, read = read_in(tmp_path, kind)
    script = LISTEN.format(before=before, read=read)
    spare = tmp_path / "spare"
    spare.mkdir()
    done = subprocess.run(
        [sys.executable, "-c", script],
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, "TMPDIR": str(spare)},
    )
    assert done.returncode == 0, done.stderr
    heard = json.loads(done.stdout)
    assert [one for one in heard if one[0].startswith((*RUN, *ASK, *LOAD))] == []
    opened = [one[1] for one in heard if one[0] == "open"]
    assert any(str(tmp_path) in path for path, _ in opened)
    assert [one for one in opened if not one[0].startswith(str(tmp_path))] == []
    # Shapes of an MJCF go to Pinocchio through a temporary folder, which is gone afterwards.
    written = [path for path, mode in opened if set(mode) & set("wax+") and mode != "None"]
    assert [path for path in written if not path.startswith(str(spare))] == []
    assert list(spare.iterdir()) == []


def test_the_hook_hears_what_runs(tmp_path: Path) -> None:
    script = LISTEN.format(before="", read="eval('1 + 1'); open('/dev/null').close()")
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True
    )
    assert {event for event, _ in json.loads(done.stdout)} >= {"compile", "exec", "open"}


def test_a_pickle_among_arrays_is_refused(tmp_path: Path) -> None:
    """It would be run."""
    path = tmp_path / "one.npz"
    np.savez(path, t=np.array([object()], dtype=object))
    with pytest.raises(psp3.errors.InvalidResultFile, match="holds object"):
        psp3.load_result(path)
