"""Exported systems answer as those in Python do, to the last bit."""

from __future__ import annotations

import shutil
import subprocess
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings

import fuzzy2
from fuzzy2.errors import InvalidValue, NotExportable, NotFitted, UnknownName
from fuzzy2.export.calls import FUNCTIONS
from fuzzy2.export.systems import has_intervals, system_of
from tests.fuzzy2.export.in_c import COMPILERS, bind, build, needs_gcc
from tests.fuzzy2.export.kinds import JUMPING, KINDS, SLOW, interval, type_1
from tests.fuzzy2.systems.random_systems import states, systems

pytestmark = pytest.mark.filterwarnings("ignore::fuzzy2.ApproximationWarning")


def inputs(count: int) -> Any:
    """Near and far away, where grades underflow."""
    rng = np.random.default_rng(count)
    scales = rng.choice([0.5, 0.5, 2.0, 40.0, 1e4], size=(count, 1))
    return rng.normal(size=(count, 2)) * scales


def answers(thing: Any, X: Any, folder: Path, **options: Any) -> tuple[Any, Any, Any]:
    """Return the answers in C and in Python, and the codes."""
    code = fuzzy2.export_c(thing, folder, **options)
    run = bind(build(code, folder), code, code.functions[0])
    system = system_of(thing)
    kind = np.float32 if options.get("precision") == "single" else np.float64
    outputs = np.empty((len(X), len(system.output_names)), kind)
    codes = np.array([run(x, out) for x, out in zip(X.astype(kind), outputs, strict=True)])
    return outputs, np.asarray(system(X)), codes


@needs_gcc
@pytest.mark.parametrize("kind", KINDS)
def test_ten_thousand_inputs_give_the_same_numbers(kind, tmp_path):
    outputs, right, codes = answers(KINDS[kind](), inputs(10_000), tmp_path)
    assert (codes == 1).all()
    np.testing.assert_array_equal(outputs, right)
    assert np.isfinite(right).any()


@needs_gcc
@pytest.mark.parametrize("kind", KINDS)
def test_ends_of_intervals_are_those_of_python(kind, tmp_path):
    system = system_of(KINDS[kind]())
    code = fuzzy2.export_c(system, tmp_path)
    assert has_intervals(system) == (len(code.functions) == 2)
    if not has_intervals(system):
        return
    run = bind(build(code, tmp_path), code, code.functions[1])
    X, ends = inputs(10_000), np.empty((10_000, len(system.output_names), 2))
    assert all(run(x, out) == 1 for x, out in zip(X, ends, strict=True))
    np.testing.assert_array_equal(ends, system.type_reduced(X))
    left, right = ends[np.isfinite(ends).all(axis=-1)].T
    assert left.size
    if getattr(system, "reduction", "") != "gaussian":
        assert (left <= right).all()
    assert run(np.array([np.nan, 0.0]), ends[0]) == 0
    assert np.isnan(ends[0]).all()


def test_systems_whose_intervals_are_points_have_no_function_for_them(tmp_path):
    names = {
        kind: [function.name for function in fuzzy2.export_c(KINDS[kind](), tmp_path).functions]
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
        library = build(code, Path(folder), flags=("-O1",))
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
    system = SLOW[kind]().replace(t_norm=norm, implication=norm)
    outputs, right, codes = answers(system, inputs(10_000 if norm == "min" else 500), tmp_path)
    done = codes == 1
    assert done.mean() > (0.99 if norm == "min" else 0.97)
    np.testing.assert_array_equal(outputs[done], right[done])
    assert np.isnan(outputs[~done]).all()
    assert np.isfinite(right[~done]).all()


@needs_gcc
@pytest.mark.parametrize("kind", KINDS)
def test_what_is_not_finite_has_no_answer(kind, tmp_path):
    code = fuzzy2.export_c(KINDS[kind](), tmp_path)
    run = bind(build(code, tmp_path), code, code.functions[0])
    out = np.zeros(code.functions[0].arguments[1].size)
    for bad in (np.nan, np.inf, -np.inf):
        out[:] = 0.0
        assert run(np.array([0.0, bad]), out) == 0
        assert np.isnan(out).all()


@needs_gcc
@pytest.mark.parametrize("kind", [*KINDS, *(pytest.param(k, marks=pytest.mark.slow) for k in SLOW)])
def test_single_precision_is_near(kind, tmp_path, record_property):
    """What single precision costs, relative to the spread of the outputs, near the terms."""
    X = np.random.default_rng(1).uniform(-1.5, 1.5, (2000, 2))
    outputs, right, codes = answers((KINDS | SLOW)[kind](), X, tmp_path, precision="single")
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
#include <math.h>
#include "system.h"

int main(void)
{{
    static const double scales[7] = {{0.0, 0.3, 1.0, 3.0, 40.0, 1e4, 1e300}};
    int i, j, k, answers = 0;
    for (i = 0; i < 7; i++) {{
        for (j = -20; j <= 20; j++) {{
            for (k = -20; k <= 20; k += 5) {{
                double x[2], out[{outputs}];
                x[0] = scales[i] * 0.1 * j;
                x[1] = scales[i] * 0.1 * k;
                answers += system_evaluate(x, out);
                x[j % 2 == 0] = i % 2 == 0 ? NAN : INFINITY;
                answers -= 2 * system_evaluate(x, out);
            }}
        }}
    }}
    return answers > 0 ? 0 : 1;
}}
"""


@needs_gcc
@pytest.mark.parametrize("kind", KINDS)
def test_sanitizers_find_nothing(kind, tmp_path):
    code = fuzzy2.export_c(KINDS[kind](), tmp_path)
    outputs = code.functions[0].arguments[1].size
    (tmp_path / "main.c").write_text(MAIN.format(outputs=outputs))
    sanitize = ["-fsanitize=address,undefined", "-fno-sanitize-recover=all"]
    command = ["gcc", "-std=c99", "-O1", "-g", *sanitize, "-o", "main", "main.c", "system.c", "-lm"]
    made = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    if "cannot find" in made.stderr:
        pytest.skip("the sanitizers are not installed")
    assert made.returncode == 0, made.stderr
    run = subprocess.run([tmp_path / "main"], capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stderr[:2000]


@needs_gcc
@pytest.mark.skipif(shutil.which("nm") is None, reason="no nm on this machine")
@pytest.mark.parametrize("kind", KINDS)
def test_nothing_is_taken_from_elsewhere_and_nothing_global_is_written(kind, tmp_path):
    code = fuzzy2.export_c(KINDS[kind](), tmp_path)
    command = ["gcc", "-std=c99", "-Os", "-c", "-o", "system.o", "system.c"]
    subprocess.run(command, cwd=tmp_path, check=True)
    listed = subprocess.run(
        ["nm", "system.o"], cwd=tmp_path, capture_output=True, text=True, check=True
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


@pytest.mark.skipif("clang" not in COMPILERS, reason="no clang on this machine")
@pytest.mark.parametrize("kind", KINDS)
def test_clang_has_nothing_to_say_and_gives_the_same(kind, tmp_path):
    code = fuzzy2.export_c(KINDS[kind](), tmp_path)
    one = bind(build(code, tmp_path), code, code.functions[0])
    other = bind(build(code, tmp_path, "clang"), code, code.functions[0])
    for x in inputs(200):
        out = np.zeros((2, code.functions[0].arguments[1].size))
        assert one(x, out[0]) == other(x, out[1])
        np.testing.assert_array_equal(out[0], out[1])


@pytest.mark.skipif(shutil.which("cppcheck") is None, reason="no cppcheck on this machine")
def test_a_static_check_finds_nothing(tmp_path):
    for i, made in enumerate((KINDS | SLOW).values()):
        fuzzy2.export_c(made(), tmp_path, name=f"system_{i}")
    command = ["cppcheck", "--std=c99", "--enable=warning,portability,performance", "--quiet"]
    command += ["--error-exitcode=1", str(tmp_path)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[:2000]


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
    with pytest.raises(InvalidValue, match="a letter first"):
        fuzzy2.export_c(type_1(), ".", name="my system")
    principal = fuzzy2.Gaussian(0.0, 0.3)
    bounded = fuzzy2.GaussianType2Set(principal, 0.1, domain=(-1.0, 1.0))
    system = fuzzy2.GeneralType2System([[bounded]], [[0]], [[1.0]])
    with pytest.raises(NotExportable, match="the term 'term1'"):
        fuzzy2.export_c(system, ".")
