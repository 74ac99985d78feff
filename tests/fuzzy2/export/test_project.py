"""A folder around C code does what its README says, and its test tells right from wrong."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

import numpy as np
import pytest

import fuzzy2
from fuzzy2.errors import InvalidValue
from fuzzy2.export.c_code import Argument, CCode, CWriter, Known
from fuzzy2.export.project import CASES, drawn, export_project, write_project
from tests.project_folder import (
    SANITIZED,
    asked,
    check_statically,
    lines,
    make,
    needs_c,
    needs_clang,
    needs_cppcheck,
    numbers,
)

RNG = np.random.default_rng(3)
X = RNG.uniform(-3.0, 3.0, (50, 2))


SYSTEM = fuzzy2.IntervalType2System(
    [[fuzzy2.GaussianUncertainMean((m - 0.1, m + 0.1), 0.7) for m in (-1.0, 1.0)]] * 2,
    [[0, 0], [0, 1], [1, 0], [1, 1]],
    RNG.normal(size=(4, 3)),
    input_ranges=[(-2.0, 2.0)] * 2,
)


def begin(total):
    """Forget what was added."""
    for i in range(total.size):
        total[i] = 0.0


def add(gain, total, step, number, out):
    """Add a row and a number to what is remembered; return how many rows were added."""
    for i in range(step.size):
        total[i] += gain[i] * step[i] + number
        out[i] = total[i]
    total[step.size] += 1.0
    return int(total[step.size])


def read(total, out):
    """Write what is remembered."""
    for i in range(out.size):
        out[i] = total[i]


GAIN = np.array([2.0, -3.0])


def code_with_a_state(precision: str = "double") -> CCode:
    """Return functions of every form: state, number, array, and a result or none."""
    writer = CWriter("sums", precision, ["Sums."])
    total = Argument("total", "sums, and how many", 3, "state")
    rest = [Argument("step", "a row", 2), Argument("number", "a number")]
    out = Argument("out", "the sums", 2, "out")
    writer.add("begin", "Forget.", begin, [total])
    writer.add("add", "Add.", add, [Known("gain", GAIN), total, *rest, out], "how many")
    writer.add("read", "Read.", read, [total, out])
    return writer.code()


INPUTS = {"step": drawn([-1.0, 0.0], [1.0, 5.0]), "number": drawn(0.0, 1.0, seed=1)}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of the system, made."""
    where = tmp_path_factory.mktemp("system")
    export_project(SYSTEM, where, name="rules")
    make(where)
    return where


@needs_c
def test_test_passes_to_the_last_bit(folder: Path) -> None:
    """The C library is the one that Python's kernels call."""
    said = make(folder, "test")
    calls, numbers = 2 * CASES, CASES * (4 + 7)
    assert f"{CASES} cases, {calls} calls: {numbers} of {numbers} numbers are Python's" in said
    assert "passed: 0 differ" in said


@needs_c
def test_main_answers_lines_as_the_system_does(folder: Path) -> None:
    status, answers, errors = asked(folder, lines(X))
    assert (status, errors) == (0, "")
    found = numbers(answers)
    assert (found[:, 0] == 1.0).all()
    np.testing.assert_array_equal(found[:, 1:], [SYSTEM(x) for x in X])


@needs_c
def test_main_reads_commas_blank_lines_names_and_nan(folder: Path) -> None:
    status, answers, _ = asked(folder, "0.5,0.25\n\n  evaluate 0.5 0.25\r\nnan 0\n", "evaluate")
    found = numbers(answers)
    assert status == 0
    np.testing.assert_array_equal(found[0], found[1])
    np.testing.assert_array_equal(found[2], [0.0, np.nan, np.nan, np.nan])


@needs_c
@pytest.mark.parametrize(
    ("text", "words", "message"),
    [
        ("1\n", (), "evaluate reads 2 numbers, not: 1"),
        ("1 2 3\n", (), "evaluate reads 2 numbers, not: 1 2 3"),
        ("1 x\n", (), "evaluate reads 2 numbers, not: 1 x"),
        ("swim 1 2\n", (), "evaluate reads 2 numbers, not: swim 1 2"),
        ("1 2\n", ("swim",), "there is no function swim; there are: evaluate"),
        ("1 " * 500 + "\n", (), "a line has more than"),
    ],
)
def test_main_says_what_it_cannot_read(
    folder: Path, text: str, words: tuple[str, ...], message: str
) -> None:
    status, answers, errors = asked(folder, text, *words)
    assert (status, answers) == (2, "")
    assert message in errors


@needs_c
@pytest.mark.parametrize("file", ["cases.c", "rules.c"])
def test_test_fails_where_a_number_is_another(tmp_path: Path, file: str) -> None:
    """A width by 1e-9, or an output: the test's tolerance is 1e-12."""
    export_project(SYSTEM, tmp_path, name="rules")
    path = tmp_path / file
    text = path.read_text(encoding="utf-8")
    if file == "rules.c":
        text, count = re.subn(r"\b0\.7\b", "0.7000000007", text)
        assert count
    else:
        head, opening, rest = text.partition("cases_numbers[] = {")
        first = rest.split(",")[:4]
        more = f" {float(first[3]) * (1.0 + 1e-9)!r}"
        text = head + opening + ",".join([*first[:3], more, *rest.split(",")[4:]])
    path.write_text(text, encoding="utf-8")
    make(tmp_path, "runner")
    done = subprocess.run([str(tmp_path / "runner")], capture_output=True, encoding="utf-8")
    assert done.returncode == 1
    assert "FAILED" in done.stdout
    assert "in Python" in done.stdout


@needs_c
def test_what_is_remembered_is_remembered_from_line_to_line(tmp_path: Path) -> None:
    write_project(code_with_a_state(), tmp_path, INPUTS)
    make(tmp_path)
    rows = [[1.0, 2.0, 0.5], [3.0, -1.0, 0.25]]
    status, answers, _ = asked(tmp_path, lines(rows) + "begin\n" + lines(rows[1:]) + "read\n")
    first = GAIN * rows[0][:2] + 0.5
    second = GAIN * rows[1][:2] + 0.25
    found = [[float(one) for one in line.split()] for line in answers.splitlines()]
    assert status == 0
    assert found == [
        [1.0, *first],
        [2.0, *(first + second)],
        [],
        [1.0, *second],
        [*second],
    ]


@needs_c
def test_cases_begin_anew_after_each_run(tmp_path: Path) -> None:
    """So what NaN has spoilt is whole again, and a sum by hand is what Python wrote."""
    write_project(code_with_a_state(), tmp_path, INPUTS)
    assert "passed" in make(tmp_path, "test")
    cases = (tmp_path / "cases.c").read_text(encoding="utf-8")
    text = cases.partition("cases_numbers[] = {")[2].partition("};")[0]
    written = [float(one.replace("INFINITY", "inf")) for one in text.split(",") if one.strip()]
    rows = np.reshape(written, (CASES, 8))
    counts, sums = rows[:, 3], rows[:, 4:6]
    np.testing.assert_array_equal(counts, np.arange(CASES) % 20 + 1.0)
    with np.errstate(invalid="ignore"):
        steps = GAIN * INPUTS["step"] + INPUTS["number"]
        want = np.concatenate([np.cumsum(run, axis=0) for run in np.split(steps, CASES // 20)])
    np.testing.assert_allclose(sums, want, rtol=1e-12, atol=1e-12)
    np.testing.assert_array_equal(sums, rows[:, 6:])
    assert np.isnan(sums).any()
    assert np.isinf(sums).any()


@needs_c
def test_single_precision_reads_what_floats_hold(tmp_path: Path) -> None:
    """Inputs are rounded before Python is asked: errors are those of the arithmetic, 1e-6."""
    export_project(SYSTEM, tmp_path, precision="single", name="rules")
    said = make(tmp_path, "test")
    found = re.search(r"at most (\S+) of their size off", said)
    assert found is not None
    assert 0.0 < float(found[1]) < 2e-5


@pytest.mark.parametrize("precision", ["double", "single"])
@pytest.mark.parametrize("compiler", [pytest.param("clang", marks=needs_clang)])
def test_other_compilers_have_nothing_to_say(tmp_path: Path, precision: str, compiler: str) -> None:
    write_project(code_with_a_state(precision), tmp_path, INPUTS)
    make(tmp_path, f"CC={compiler}")
    assert "passed" in make(tmp_path, f"CC={compiler}", "test")


@needs_c
@pytest.mark.parametrize("precision", ["double", "single"])
def test_sanitizers_have_nothing_to_say(tmp_path: Path, precision: str) -> None:
    write_project(code_with_a_state(precision), tmp_path, INPUTS)
    make(tmp_path, flags=SANITIZED)
    assert "passed" in make(tmp_path, "test", flags=SANITIZED)
    for text in ("1 2 3\nread\n", "1 2\n", "1 " * 500, "\n" * 300, "add 1 nan inf\n", "1e999 0 0"):
        status, _, errors = asked(tmp_path, text)
        assert status in (0, 2)
        assert "Sanitizer" not in errors
        assert "runtime error" not in errors


@needs_cppcheck
@pytest.mark.parametrize("precision", ["double", "single"])
def test_cppcheck_has_nothing_to_say(tmp_path: Path, precision: str) -> None:
    write_project(code_with_a_state(precision), tmp_path, INPUTS)
    check_statically(tmp_path)


@needs_c
@pytest.mark.parametrize("has_state", [True, False])
def test_program_of_the_readme_compiles_and_its_line_is_answered(
    tmp_path: Path, has_state: bool
) -> None:
    if has_state:
        write_project(code_with_a_state(), tmp_path, INPUTS)
    else:
        export_project(SYSTEM, tmp_path)
    readme = (tmp_path / "README.md").read_text(encoding="utf-8")
    program = readme.partition("```c\n")[2].partition("```")[0]
    declared, _, done = program.rpartition("\n\n")
    (tmp_path / "user.c").write_text(
        f"{declared}\nint main(void)\n{{\n{done}\nreturn 0;\n}}\n", encoding="utf-8"
    )
    code = "sums.c" if has_state else "system.c"
    subprocess.run(
        ["gcc", "-std=c99", "-Wall", "-Werror", "user.c", code, "-lm", "-o", "user"],
        cwd=tmp_path,
        check=True,
    )
    make(tmp_path)
    (command,) = re.findall(r"^    (echo .*)$", readme, flags=re.MULTILINE)
    said = subprocess.run(
        command, shell=True, cwd=tmp_path, check=True, capture_output=True, encoding="utf-8"
    )
    assert len(said.stdout.split()) == (3 if has_state else 4)


@pytest.mark.parametrize("name", ["main", "test", "calls", "cases", "runner"])
def test_names_of_other_files_are_refused(tmp_path: Path, name: str) -> None:
    with pytest.raises(InvalidValue, match=r"name must be none of calls, cases, main"):
        export_project(SYSTEM, tmp_path / "there", name=name)


@pytest.mark.parametrize(
    "inputs",
    [
        {"number": INPUTS["number"]},
        INPUTS | {"step": INPUTS["number"]},
        INPUTS | {"step": INPUTS["step"][:7]},
    ],
)
def test_inputs_that_are_missing_are_named(tmp_path: Path, inputs: dict[str, np.ndarray]) -> None:
    with pytest.raises(InvalidValue, match=r"cases of shape \(200, 2\) for 'step'"):
        write_project(code_with_a_state(), tmp_path, inputs)


def test_inputs_are_mostly_within_their_range_some_outside_and_some_no_numbers() -> None:
    inputs = drawn([-1.0, 10.0], [1.0, 10.0])
    finite = np.isfinite(inputs).all(axis=1)
    within = (np.abs(inputs[finite, 0]) <= 1.0).mean()
    assert inputs.shape == (CASES, 2)
    assert np.isnan(inputs).sum() == 2
    assert np.isinf(inputs).sum() == 3
    assert 0.8 <= within < 0.95
    assert 1.0 < np.abs(inputs[finite, 0]).max() <= 3.0
    assert set(inputs[finite, 1]) == {10.0}


@needs_c
def test_ranges_may_be_as_wide_as_numbers_are(tmp_path: Path) -> None:
    far = 1.7e308
    terms = [[fuzzy2.Gaussian(m, 1e308) for m in (-far, far)]]
    system = fuzzy2.Type1System(
        terms, [[0], [1]], [[-1.0], [2.0]], input_ranges=[(-far, far)], default_outputs=[3.0]
    )
    export_project(system, tmp_path)
    assert "passed: 0 differ" in make(tmp_path, "test")
    # Others are drawn as ever: the numbers of a range are an eighth of those of one eight times it.
    assert (drawn(-8.0, 8.0) / 8.0)[:10].tolist() == drawn(-1.0, 1.0)[:10].tolist()
