"""Exported systems answer as those in Python do, to the last bit.

With ``make export-states`` the code of all kinds is optimized and read by ``cppcheck``, and those
whose answers take long are asked more often.
"""

from __future__ import annotations

import functools
import shutil
import subprocess
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings

import fuzzy2
from fuzzy2.errors import InvalidValue, NotExportable, NotFitted, UnknownName
from fuzzy2.export.c_code import CCode
from fuzzy2.export.calls import FUNCTIONS
from fuzzy2.export.systems import has_intervals, system_of
from tests.c_code import BEFORE_A_RELEASE, FLAGS, functions_of, optimization
from tests.fuzzy2.export.in_c import InC, bind, build, needs_gcc
from tests.fuzzy2.export.kinds import JUMPING, KINDS, SLOW, interval, type_1
from tests.fuzzy2.systems.random_systems import states, systems
from tests.project_folder import check_statically, needs_clang, needs_cppcheck

pytestmark = pytest.mark.filterwarnings("ignore::fuzzy2.ApproximationWarning")

ALL = KINDS | SLOW

WITH_EVERY_FUNCTION = (
    *("formulas, interval", "planes, silent", "mamdani", "wu-mendel on a grid", "side by side"),
    *("or, not, hedges, weights, silence, defaults", "corollary", "bisector on a grid", "clouds"),
    *("mean_of_maxima", "tsukamoto", "united sum, interval", "bisector", "classifier"),
    *("fuzzylite's bisector", "nie-tan mamdani"),
)
"""Systems that have, together, every function that is in any of them.

Their code is optimized, and ``cppcheck`` reads it; the code of all others is not optimized.
"""


@functools.cache
def made(kind: str) -> Any:
    """Return a system or learner of a kind, the same one in every test."""
    return ALL[kind]()


def inputs(count: int) -> Any:
    """Near and far away, where grades underflow."""
    rng = np.random.default_rng(count)
    scales = rng.choice([0.5, 0.5, 2.0, 40.0, 1e4], size=(count, 1))
    return rng.normal(size=(count, 2)) * scales


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], CCode]:
    """Return a function that exports a system of a kind, each once, to the same folder."""
    folder = tmp_path_factory.mktemp("systems")

    @functools.cache
    def write(kind: str) -> CCode:
        return fuzzy2.export_c(made(kind), folder, name=f"system_{[*ALL].index(kind)}")

    setattr(write, "folder", folder)  # noqa: B010 (a function has no such attribute for mypy)
    return write


@pytest.fixture(scope="module")
def compiled(written: Any, tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], InC]:
    """Return a function that compiles a system of a kind in double precision, each once."""
    folder = tmp_path_factory.mktemp("compiled")
    return functools.cache(
        lambda kind: InC(written(kind), folder, optimization(kind in WITH_EVERY_FUNCTION))
    )


@needs_gcc
@pytest.mark.parametrize("kind", KINDS)
def test_ten_thousand_inputs_give_the_same_numbers(kind, compiled):
    X = inputs(10_000)
    outputs, codes = compiled(kind).rows(0, X)
    right = np.asarray(system_of(made(kind))(X))
    assert (codes == 1).all()
    np.testing.assert_array_equal(outputs, right)
    assert np.isfinite(right).any()


@needs_gcc
@pytest.mark.parametrize("kind", KINDS)
def test_ends_of_intervals_are_those_of_python(kind, compiled):
    system, in_c = system_of(made(kind)), compiled(kind)
    assert has_intervals(system) == (len(in_c.code.functions) == 2)
    if not has_intervals(system):
        return
    X = inputs(10_000)
    ends, codes = in_c.rows(1, X)
    ends = ends.reshape(len(X), -1, 2)
    assert (codes == 1).all()
    np.testing.assert_array_equal(ends, system.type_reduced(X))
    left, right = ends[np.isfinite(ends).all(axis=-1)].T
    assert left.size
    if getattr(system, "reduction", "") != "gaussian":
        assert (left <= right).all()


def test_systems_whose_intervals_are_points_have_no_function_for_them(tmp_path):
    names = {
        kind: [function.name for function in fuzzy2.export_c(made(kind), tmp_path).functions]
        for kind in ("type-1", "interval", "planes", "nie-tan", "side by side")
    }
    assert names["type-1"] == names["nie-tan"] == ["system_evaluate"]
    assert names["interval"] == names["planes"] == ["system_evaluate", "system_interval"]
    assert names["side by side"] == names["interval"]


@needs_gcc
@settings(max_examples=30)
@given(system=systems())
def test_random_systems_answer_as_in_python(system):
    """Of any kind: terms, rules, norms, consequents and reductions are drawn."""
    X = states(system)
    with tempfile.TemporaryDirectory() as folder:
        try:
            code = fuzzy2.export_c(system, folder)
        except NotExportable as error:
            # Of what is drawn here nothing else: unions that only arrays integrate.
            assert "without a grid" in error.what  # noqa: PT017
            return
        library = build(code, Path(folder), flags=("-O0",))
        run = bind(library, code, code.functions[0])
        right, ends = np.asarray(system(X)), system.type_reduced(X)
        for x, outputs in zip(X, right, strict=True):
            out = np.empty(len(outputs))
            if run(x.copy(), out) == 1:
                np.testing.assert_array_equal(out, outputs)
        if len(code.functions) > 1:
            run = bind(library, code, code.functions[1])
            for x, interval_ends in zip(X, ends, strict=True):
                out = np.empty(interval_ends.size)
                if run(x.copy(), out) == 1:
                    np.testing.assert_array_equal(out, interval_ends.ravel())


@needs_gcc
@pytest.mark.slow
@pytest.mark.parametrize("norm", ["min", "product"])
@pytest.mark.parametrize("kind", SLOW)
def test_unions_give_the_same_numbers_or_say_that_memory_is_short(kind, norm, tmp_path):
    """Where lower strengths are tiny beside the upper ones, pieces are many."""
    system = made(kind).replace(t_norm=norm, implication=norm)
    X = inputs(500 if norm == "product" else 10_000 if BEFORE_A_RELEASE else 1500)
    outputs, codes = InC(fuzzy2.export_c(system, tmp_path), tmp_path).rows(0, X)
    right, done = np.asarray(system(X)), codes == 1
    assert done.mean() > (0.99 if norm == "min" else 0.97)
    np.testing.assert_array_equal(outputs[done], right[done])
    assert np.isnan(outputs[~done]).all()
    assert np.isfinite(right[~done]).all()


@needs_gcc
@pytest.mark.parametrize("kind", KINDS)
def test_what_is_not_finite_has_no_answer(kind, compiled):
    bad = np.array([[0.0, np.nan], [np.inf, 0.0], [0.0, -np.inf], [np.nan, np.inf]])
    for number in range(len(compiled(kind).code.functions)):
        out, codes = compiled(kind).rows(number, bad)
        assert (codes == 0).all()
        assert np.isnan(out).all()


@needs_gcc
@pytest.mark.parametrize("kind", [*KINDS, *(pytest.param(k, marks=pytest.mark.slow) for k in SLOW)])
def test_single_precision_is_near(kind, tmp_path, record_property):
    """What single precision costs, relative to the spread of the outputs, near the terms."""
    X = np.random.default_rng(1).uniform(-1.5, 1.5, (2000, 2))
    code = fuzzy2.export_c(made(kind), tmp_path, precision="single")
    optimized = optimization(kind in WITH_EVERY_FUNCTION)
    outputs, codes = InC(code, tmp_path, optimized).rows(0, X)
    right = np.asarray(system_of(made(kind))(X))
    assert (codes == 1).all()
    both = np.isfinite(right)
    assert (np.isfinite(outputs) == both).mean() > 0.999
    both &= np.isfinite(outputs)
    error = abs(outputs - right)[both] / np.ptp(right[both])
    record_property("error", float(error.max()))
    # Rounding of inputs and of some dozens of sums; of a switch point a few percent more.
    assert np.median(error) < 2e-6
    if kind in JUMPING:
        # Rounding of 1e-7 decides in as many states as are that near to a jump, 1e-5 or so of them.
        assert (error > 2e-3).mean() < 2e-3
    else:
        assert error.max() < 2e-3


MAIN = """
#include <stdio.h>
{headers}
int main(void)
{{
    static double x[{count}][2], out[64];
    int i, code;
    if (fread(x, sizeof x[0], {count}, stdin) != {count}) {{
        return 1;
    }}
{calls}
    return 0;
}}
"""

CALLS = """
    for (i = 0; i < {count}; i++) {{
        code = {function}(x[i], out);
        fwrite(&code, sizeof code, 1, stdout);
        fwrite(out, sizeof out[0], {writes}, stdout);
    }}"""


def _hard_inputs() -> Any:
    """Return inputs from zero to 1e300, and some that are no numbers."""
    steps = 0.1 * np.arange(-20.0, 21.0, 5.0)
    grid = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)
    X = np.concatenate([scale * grid for scale in (0.0, 0.3, 1.0, 3.0, 40.0, 1e4, 1e300)])
    X[::50, 0], X[7::50, 1], X[9::50, 1] = np.nan, np.inf, -np.inf
    return X


@needs_gcc
@needs_clang
def test_clang_and_sanitizers_find_nothing_and_numbers_are_the_same(written, compiled, tmp_path):
    """Of all kinds in one program, which says the numbers that gcc's code does."""
    X, kinds = _hard_inputs(), list(KINDS)
    codes = [written(kind) for kind in kinds]
    functions = [function for code in codes for function in code.functions]
    headers = "\n".join(f'#include "{code.name}.h"' for code in codes)
    calls = "".join(
        CALLS.format(count=len(X), function=one.name, writes=one.visible[1].size)
        for one in functions
    )
    main = MAIN.format(headers=headers, count=len(X), calls=calls)
    (tmp_path / "main.c").write_text(main, encoding="utf-8")
    sanitize = ["-fsanitize=address,undefined,float-cast-overflow", "-fno-sanitize-recover=all"]
    command = ["clang", *FLAGS, "-O0", "-g", *sanitize, f"-I{written.folder}", "-o", "main"]
    files = ["main.c", *(str(written.folder / f"{code.name}.c") for code in codes), "-lm"]
    made = subprocess.run([*command, *files], cwd=tmp_path, capture_output=True, check=False)
    assert made.returncode == 0, made.stderr[:2000].decode()
    run = subprocess.run([tmp_path / "main"], input=X.tobytes(), capture_output=True, check=False)
    assert run.returncode == 0, run.stderr[:2000].decode()
    at = 0
    for kind in kinds:
        for number, function in enumerate(written(kind).functions):
            of_one = np.dtype([("code", "i4"), ("out", "f8", (function.visible[1].size,))])
            said = np.frombuffer(run.stdout, of_one, len(X), at)
            at += said.nbytes
            out, done = compiled(kind).rows(number, X)
            np.testing.assert_array_equal(said["code"], done, kind)
            np.testing.assert_array_equal(said["out"], out, kind)
            assert done.any()
            assert not done[~np.isfinite(X).all(axis=1)].any()
    assert at == len(run.stdout)


@needs_gcc
@pytest.mark.skipif(shutil.which("nm") is None, reason="no nm on this machine")
@pytest.mark.parametrize("kind", KINDS)
def test_nothing_is_taken_from_elsewhere_and_nothing_global_is_written(kind, compiled):
    code, folder = compiled(kind).code, compiled(kind).folder
    listed = subprocess.run(
        ["nm", f"{code.name}.o"], cwd=folder, capture_output=True, text=True, check=True
    )
    symbols = [line.split()[-2:] for line in listed.stdout.splitlines()]
    mathematics = {"exp", "log", "log1p", "expm1", "sqrt", "pow", "memset", "memcpy"}
    if "formulas" in kind:
        mathematics |= FUNCTIONS | {"fmod"}
    assert {name for kind, name in symbols if kind == "U"} <= mathematics
    # T and t are code, r constants; D, B and C would be variables.
    assert {kind for kind, _ in symbols} <= {"T", "t", "r", "U"}
    functions = sorted(function.name for function in code.functions)
    assert sorted(name for kind, name in symbols if kind == "T") == functions
    assert code.source.count("#include") == 2


@needs_cppcheck
def test_a_static_check_finds_nothing(written, tmp_path):
    """Of every function in some system; of every system with ``make export-states``."""
    functions = set().union(*(functions_of(written(kind)) for kind in ALL))
    assert len(functions) > 100
    assert functions == set().union(*(functions_of(written(k)) for k in WITH_EVERY_FUNCTION))
    for kind in ALL if BEFORE_A_RELEASE else WITH_EVERY_FUNCTION:
        written(kind).write(tmp_path)
    check_statically(tmp_path)


def test_the_header_says_what_there_is(tmp_path):
    system = interval().replace(
        input_names=["error", "rate"], input_ranges=[(-1.0, 1.0), (-5.0, 5.0)]
    )
    code = fuzzy2.export_c(system, tmp_path / "new", precision="single", name="force")
    header = (tmp_path / "new" / "force.h").read_text()
    assert "int force_evaluate(const float x[2], float out[2]);" in header
    assert "[0] error in [-1, 1]" in header
    assert fuzzy2.__version__ in header
    assert code.hash in header
    assert code.hash in code.source


def test_what_is_no_system_is_refused():
    with pytest.raises(NotExportable, match="a dict"):
        fuzzy2.export_c({}, ".")
    with pytest.raises(NotFitted):
        fuzzy2.export_c(fuzzy2.ANFIS(), ".")
    with pytest.raises(UnknownName, match="half"):
        fuzzy2.export_c(type_1(), ".", precision="half")
    for name in ("my system", "", b"", b"rules", "größe", None, 3):
        with pytest.raises(InvalidValue, match="a letter first"):
            fuzzy2.export_c(type_1(), ".", name=name)
    principal = fuzzy2.Gaussian(0.0, 0.3)
    bounded = fuzzy2.GaussianType2Set(principal, 0.1, domain=(-1.0, 1.0))
    system = fuzzy2.GeneralType2System([[bounded]], [[0]], [[1.0]])
    with pytest.raises(NotExportable, match="the term 'term1'"):
        fuzzy2.export_c(system, ".")
