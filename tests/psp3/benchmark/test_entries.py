"""Files of entries: which classes can enter, what they are given, what is refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from psp3.benchmark.entries import BOTH, MODEL, NEITHER, SAMPLES, Course, load_entry
from psp3.benchmark.learned import LearnedComputedTorque
from psp3.benchmark.readings import NONE, lesson
from psp3.benchmark.tasks import task
from psp3.errors import InvalidEntry

REGRESSOR = """
import numpy as np
class Mean:
    def __init__(self{arguments}):
        pass
    def fit(self, X, Y):
        self.mean = Y.mean(axis=0)
    def predict(self, X):
        return np.tile(self.mean, (len(X), 1))
"""
CONTROLLER = """
class Nothing:
    def __init__(self, robot, kp):
        self.robot, self.kp = robot, kp
    def reset(self):
        pass
    def torque(self, t, positions, speeds, desired):
        return 0.0 * positions
"""
LEARNS = """
    def fit(self, X, Y):
        self.shapes = X.shape, Y.shape
"""


def file_of(directory: Path, text: str, name: str = "mine.py") -> Path:
    path = directory / name
    path.write_text(text, encoding="utf-8")
    return path


def course() -> Course:
    of_robot = task("psp3")
    rng = np.random.default_rng(0)
    return Course(
        of_robot, lesson(of_robot, NONE, np.inf, rng, 20), NONE, np.inf, (0, 0), rng, 0.004
    )


@pytest.mark.parametrize(
    ("text", "knows", "draws"),
    [
        (REGRESSOR.format(arguments=""), SAMPLES, False),
        (REGRESSOR.format(arguments=", rng, kp=3.0"), SAMPLES, True),
        (REGRESSOR.format(arguments=", robot"), BOTH, False),
        (CONTROLLER, MODEL, False),
        (CONTROLLER + LEARNS, BOTH, False),
        (CONTROLLER.replace("robot, kp", "kp, robot=None"), MODEL, False),
        (CONTROLLER.replace("robot, kp", "kp").replace("robot, self.kp", "kp"), NEITHER, False),
    ],
)
def test_what_an_entry_knows_is_told_from_its_class(
    tmp_path: Path, text: str, knows: str, draws: bool
) -> None:
    entry = load_entry(file_of(tmp_path, text.replace("self.kp = kp, kp", "self.kp = None, kp")))
    assert (entry.name, entry.knows, entry.draws) == ("mine", knows, draws)
    assert entry.learns == (knows in (SAMPLES, BOTH))


def test_regressors_become_computed_torque_and_controllers_stay(tmp_path: Path) -> None:
    regressor = load_entry(file_of(tmp_path, REGRESSOR.format(arguments=""))).make(course())
    assert isinstance(regressor, LearnedComputedTorque)
    controller = load_entry(file_of(tmp_path, CONTROLLER + LEARNS, "other.py")).make(course())
    assert controller.shapes == ((20, 4), (20, 18))  # type: ignore[attr-defined]
    assert controller.kp == task("psp3").kp  # type: ignore[attr-defined]


def test_another_text_is_another_mark(tmp_path: Path) -> None:
    marks = {load_entry(file_of(tmp_path, CONTROLLER + end)).mark for end in ("", "\n", "")}
    assert len(marks) == 2


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("x = 1\n", "found none"),
        (CONTROLLER + CONTROLLER.replace("Nothing", "Other"), "found Nothing, Other"),
        ("raise SystemExit('no')", "raises SystemExit: no"),
        ("def (", "raises SyntaxError"),
        (CONTROLLER.replace("robot, kp", "robot, kp, gain"), "'gain'.*robot, kp, kv, rng"),
    ],
)
def test_files_that_are_no_entries_are_refused_with_the_reason(
    tmp_path: Path, text: str, message: str
) -> None:
    with pytest.raises(InvalidEntry, match=message):
        load_entry(file_of(tmp_path, text))


def test_missing_files_and_other_files_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InvalidEntry, match="no such file"):
        load_entry(tmp_path / "absent.py")
    with pytest.raises(InvalidEntry, match=r"must end in \.py"):
        load_entry(file_of(tmp_path, CONTROLLER, "entry.txt"))
