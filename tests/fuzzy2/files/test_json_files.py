"""JSON documents.

What is written is read back bit for bit, fits the schema, and what does not fit is refused with its
place.
"""

from __future__ import annotations

import copy
import json
import math
from importlib.resources import files
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fuzzy2.errors import MalformedFile, NotExpressible
from fuzzy2.files import json_files
from fuzzy2.files.json_files import SCHEMA_VERSION, from_json, load, save, to_json
from fuzzy2.sets.derived import Complement, FunctionalSet, Truncated
from fuzzy2.sets.functional_type2 import FunctionalType2Set
from fuzzy2.sets.gaussian_type2 import GaussianType2Set
from fuzzy2.sets.general_type2 import AlphaPlane, SampledType2Set, ZSlices
from fuzzy2.sets.interval_type2 import (
    EmbeddedSet,
    GaussianUncertainMean,
    GaussianUncertainSigma,
    IntervalType2Set,
)
from fuzzy2.sets.shapes import Gaussian, Interval, Trapezoidal, Triangular
from fuzzy2.sets.sigmoids import Sigmoid, SigmoidDifference, SigmoidProduct
from fuzzy2.sets.smooth_shapes import Bell, PiShaped, TwoSidedGaussian
from fuzzy2.sets.type1 import SampledSet, Singleton
from fuzzy2.sets.vertical_slices import Staircase
from fuzzy2.systems import GeneralType2System, IntervalType2System, Linear, Type1System
from fuzzy2.systems.fuzzifiers import NonSingletonFuzzifier
from fuzzy2.systems.rules import Rule
from tests import examples

SCHEMA = json.loads((files("fuzzy2.files") / "schema.json").read_text(encoding="utf-8"))
VALIDATOR = jsonschema.Draft202012Validator(SCHEMA)

numbers = st.floats(-1e6, 1e6, allow_subnormal=False)
widths = st.floats(1e-3, 1e3)
grades = st.floats(1e-3, 1.0)


def ascending(count: int) -> st.SearchStrategy[list[float]]:
    return st.lists(numbers, min_size=count, max_size=count).map(sorted)


sampled_sets = st.lists(st.tuples(numbers, grades), min_size=1, max_size=6).map(
    lambda pairs: SampledSet(*np.array(pairs).T)
)
unit_sets = st.lists(st.tuples(st.floats(0.0, 1.0), grades), min_size=1, max_size=5).map(
    lambda pairs: SampledSet(*np.array(pairs).T)
)
type1_sets = st.one_of(
    st.builds(Gaussian, numbers, widths, grades),
    st.builds(lambda corners, height: Triangular(*corners, height), ascending(3), grades),
    st.builds(lambda corners, height: Trapezoidal(*corners, height), ascending(4), grades),
    st.builds(lambda corners: Trapezoidal(-math.inf, -math.inf, *corners), ascending(2)),
    st.builds(lambda corners: Trapezoidal(*corners, math.inf, math.inf), ascending(2)),
    st.builds(Bell, numbers, widths, widths),
    st.builds(Sigmoid, numbers, widths),
    st.builds(Singleton, numbers),
    st.builds(lambda ends: Interval(*ends), ascending(2)),
    sampled_sets,
    st.builds(
        lambda mean, sigma: Truncated(Gaussian(mean, sigma), mean - 1.0, mean + 1.0),
        numbers,
        widths,
    ),
    st.builds(
        lambda mean, sigma: GaussianUncertainMean(tuple(mean), sigma).lower, ascending(2), widths
    ),
    st.builds(
        lambda mean, sigma: GaussianUncertainMean(tuple(mean), sigma).upper, ascending(2), widths
    ),
    st.builds(lambda corners, height: PiShaped(*corners, height), ascending(4), grades),
    st.builds(lambda corners: PiShaped(-math.inf, -math.inf, *corners), ascending(2)),
    st.builds(
        lambda mean, sigma: TwoSidedGaussian(tuple(mean), (sigma, math.inf)), ascending(2), widths
    ),
    st.builds(
        lambda mean, first, second: TwoSidedGaussian(tuple(mean), (first, second)),
        ascending(2),
        widths,
        widths,
    ),
    st.builds(
        lambda center, slope: SigmoidDifference((center, center + 1.0), (slope, 2.0 * slope)),
        numbers,
        widths,
    ),
    st.builds(
        lambda center, slope: SigmoidProduct((center, center + 1.0), (slope, -1.0)),
        numbers,
        st.floats(0.1, 10.0),
    ),
    st.builds(lambda mean, sigma: Complement(Gaussian(mean, sigma)), numbers, widths),
    st.builds(
        lambda left: Staircase((0.5, 1.0), (left, left + 1.0), (left + 3.0, left + 2.0)), numbers
    ),
)
interval_sets = st.one_of(
    st.builds(lambda mean, sigma: GaussianUncertainMean(tuple(mean), sigma), ascending(2), widths),
    st.builds(
        lambda mean, sigma: GaussianUncertainSigma(mean, tuple(sigma)),
        numbers,
        st.lists(widths, min_size=2, max_size=2).map(sorted),
    ),
    st.builds(
        lambda mean, sigma, height: IntervalType2Set(
            Gaussian(mean, sigma, height), Gaussian(mean, sigma)
        ),
        numbers,
        widths,
        grades,
    ),
    st.builds(
        lambda mean, sigma, alpha: AlphaPlane(
            Gaussian(mean, sigma, 0.5), Gaussian(mean, sigma), alpha
        ),
        numbers,
        widths,
        grades,
    ),
)
general_sets = st.one_of(
    st.builds(
        lambda mean, width, sigma: GaussianType2Set(Gaussian(mean, width), sigma),
        numbers,
        widths,
        grades,
    ),
    st.builds(
        lambda mean, width, sigma: GaussianType2Set(
            Gaussian(mean, width), sigma, (mean - 1, mean + 2)
        ),
        numbers,
        widths,
        grades,
    ),
    st.builds(
        lambda slices: SampledType2Set(range(len(slices)), slices),
        st.lists(unit_sets, min_size=1, max_size=4),
    ),
    st.builds(
        lambda mean, sigma: ZSlices(
            (0.4, 1.0), (GaussianUncertainMean((mean - 1, mean + 1), sigma), Gaussian(mean, sigma))
        ),
        numbers,
        widths,
    ),
)
sets = st.one_of(
    type1_sets,
    interval_sets,
    general_sets,
    st.builds(
        lambda footprint, edge: EmbeddedSet(footprint, (edge,), (1.0, 0.0)), interval_sets, numbers
    ),
)


def bits(document: Any) -> Any:
    """Return a document with each float in hexadecimal.

    So -0.0 and 0.0, and neighbors, differ.
    """
    if isinstance(document, dict):
        return {name: bits(value) for name, value in document.items()}
    if isinstance(document, list):
        return [bits(value) for value in document]
    return document.hex() if isinstance(document, float) else document


def through_text(document: dict[str, Any]) -> dict[str, Any]:
    read: dict[str, Any] = json.loads(json.dumps(document, allow_nan=False))
    return read


@given(sets)
@settings(max_examples=examples(300, of=2))
def test_sets_come_back_bit_for_bit(fuzzy_set: Any) -> None:
    document = to_json(fuzzy_set)
    read = from_json(through_text(document))
    assert type(read) is type(fuzzy_set)
    assert read == fuzzy_set
    assert bits(to_json(read)) == bits(document)
    VALIDATOR.validate(document)


@st.composite
def systems(draw: st.DrawFn) -> Any:
    kind = draw(st.sampled_from([Type1System, IntervalType2System, GeneralType2System]))
    p, m, count = draw(st.integers(1, 3)), draw(st.integers(1, 2)), draw(st.integers(1, 4))
    term = {
        Type1System: st.builds(Gaussian, numbers, widths)
        | st.builds(lambda c: Triangular(*c), ascending(3)),
        IntervalType2System: st.builds(Gaussian, numbers, widths) | interval_sets,
        GeneralType2System: st.builds(Gaussian, numbers, widths) | general_sets,
    }[kind]
    inputs = [draw(st.lists(term, min_size=1, max_size=3)) for _ in range(p)]
    rules = [[draw(st.integers(-1, len(terms) - 1)) for terms in inputs] for _ in range(count)]
    values = st.lists(st.lists(numbers, min_size=m, max_size=m), min_size=count, max_size=count)
    intervals = st.lists(
        st.lists(ascending(2), min_size=m, max_size=m), min_size=count, max_size=count
    )
    triangles = st.builds(
        lambda left, width: Triangular(left, left + width, left + 2 * width),
        st.floats(-10, 10),
        st.floats(0.1, 10),
    )
    of_sets = st.lists(st.lists(triangles, min_size=m, max_size=m), min_size=count, max_size=count)
    linear = st.builds(
        lambda seed: Linear(np.random.default_rng(seed).normal(size=(count, m, p + 1))),
        st.integers(0, 9),
    )
    consequents = draw(st.one_of(values, intervals, of_sets, linear))
    options: dict[str, Any] = {"t_norm": draw(st.sampled_from(["min", "product", "hamacher"]))}
    if isinstance(consequents, list) and isinstance(consequents[0][0], Triangular):
        options |= {
            "type_reduction": draw(st.sampled_from(["center_of_sets", "height", "centroid"])),
            "resolution": 21,
        }
    if kind is GeneralType2System:
        options |= {"levels": draw(st.integers(1, 3))}
    elif draw(st.booleans()):
        options |= {"fuzzifier": NonSingletonFuzzifier(Gaussian(0.0, 0.5))}
    if draw(st.booleans()):
        options |= {
            "consequent_names": [[f"größe {i + j}" for j in range(m)] for i in range(count)]
        }
        options |= {
            "input_ranges": [(-i - 0.1, 1.0) for i in range(p)],
            "output_ranges": [(-1e6, 1e6 + j / 3) for j in range(m)],
        }
    return kind(inputs, rules, consequents, **options, input_names=[f"größe {i}" for i in range(p)])


@pytest.mark.slow
@given(systems())
@settings(max_examples=examples(100, of=2))
def test_systems_come_back_bit_for_bit(system: Any) -> None:
    document = to_json(system)
    read = from_json(through_text(document))
    assert type(read) is type(system)
    assert bits(to_json(read)) == bits(document)
    VALIDATOR.validate(document)


def example() -> IntervalType2System:
    terms = [GaussianUncertainMean((-1.5, -0.5), 1.0), GaussianUncertainMean((0.5, 1.5), 1.0)]
    consequents = np.random.default_rng(3).normal(size=(4, 3))
    return IntervalType2System(
        [terms, terms],
        [[0, 0], [0, 1], [1, 0], [1, -1]],
        consequents,
        term_names=[["Low", "High"]] * 2,
    )


def test_a_system_answers_as_before() -> None:
    X = np.random.default_rng(5).uniform(-3.0, 3.0, size=(50, 2))
    system, linear = example(), Linear(np.arange(12.0).reshape(4, 1, 3), np.ones((4, 1, 3)))
    for original in (system, IntervalType2System(system.inputs, system.rules, linear)):
        np.testing.assert_array_equal(
            from_json(through_text(to_json(original))).type_reduced(X), original.type_reduced(X)
        )


def test_arguments_with_a_default_may_be_left_out(tmp_path: Path) -> None:
    by_hand = """{"format": "fuzzy2", "version": 1, "type": "GeneralType2System", "rules": [[0]], \
"consequents": [[2]],
                  "inputs": [[{"type": "GaussianType2Set", "principal": {"type": "Gaussian", \
"mean": 0, "sigma": 1}, "sigma": 0.1}]]}"""
    path = tmp_path / "small.json"
    path.write_text("\N{ZERO WIDTH NO-BREAK SPACE}" + by_hand, encoding="utf-8")
    system = load(path)
    assert system.inputs == ((GaussianType2Set(Gaussian(0.0, 1.0), 0.1),),)
    assert (system.levels, system.t_norm.name, system.resolution) == (5, "product", 501)
    VALIDATOR.validate(json.loads(by_hand))


def test_rule_bases(tmp_path: Path) -> None:
    rules = [Rule({"x1": "Low", "x 2": "is"}, {"y": "Small"}), Rule({"x1": "High"}, {"y": "Large"})]
    save(rules, tmp_path / "rules.json")
    assert load(tmp_path / "rules.json") == rules
    VALIDATOR.validate(to_json(rules))


@pytest.mark.parametrize(
    ("change", "place", "said"),
    [
        (
            lambda d: d["inputs"][0][1].update(sigma=-1.0),
            "$.inputs[0][1].sigma",
            "above 0, got -1.0",
        ),
        (
            lambda d: d["inputs"][0][1].update(sigma="1"),
            "$.inputs[0][1].sigma",
            'expected a finite number, got "1"',
        ),
        (
            lambda d: d["inputs"][0][1].update(sigma=True),
            "$.inputs[0][1].sigma",
            "expected a finite number, got true",
        ),
        (
            lambda d: d["inputs"][0][1].update(sigma=math.inf),
            "$.inputs[0][1].sigma",
            "expected a finite number",
        ),
        (
            lambda d: d["inputs"][0][1].update(sigma=10**400),
            "$.inputs[0][1].sigma",
            "expected a finite number",
        ),
        (
            lambda d: d["inputs"][0][1].update(sgma=1.0),
            "$.inputs[0][1].sgma",
            "did you mean 'sigma'?",
        ),
        (
            lambda d: d["inputs"][0][1].pop("sigma"),
            "$.inputs[0][1]",
            "GaussianUncertainMean needs 'sigma'",
        ),
        (lambda d: d["inputs"][0][1].pop("type"), "$.inputs[0][1]", 'has no "type"'),
        (
            lambda d: d["inputs"][0][1].update(mean=[0.0]),
            "$.inputs[0][1].mean",
            "expected two, got 1",
        ),
        (
            lambda d: d["inputs"][0][1].update(mean=[1.0, 0.0]),
            "$.inputs[0][1].mean",
            "in ascending order",
        ),
        (lambda d: d["inputs"][1].__setitem__(0, 7), "$.inputs[1][0]", "expected an object, got 7"),
        (
            lambda d: d["inputs"][1][0].update(type="GausianUncertainMean"),
            "$.inputs[1][0].type",
            "did you mean 'GaussianUncertainMean'?",
        ),
        (
            lambda d: d["inputs"][1][0].update(type="os.system"),
            "$.inputs[1][0].type",
            "unknown class 'os.system'",
        ),
        (
            lambda d: d["inputs"][1][0].update(type=3),
            "$.inputs[1][0].type",
            "expected a string, got 3",
        ),
        (lambda d: d["inputs"].__setitem__(0, {}), "$.inputs[0]", "expected a list, got {}"),
        (
            lambda d: d["inputs"][0].append(to_json(GaussianType2Set(Gaussian(0, 1), 1))),
            "$.inputs[0][2].format",
            "unknown field",
        ),
        (
            lambda d: d["inputs"].__setitem__(0, [{"type": "Linear", "coefficients": [[[1]]]}]),
            "$.inputs[0][0].type",
            "expected a set",
        ),
        (
            lambda d: d.update(rules=[[0, 0], [0, 1], [1, 5], [1, 1]]),
            "$.rules[2][1]",
            "from 0, or -1 for no part, got 5",
        ),
        (lambda d: d.update(rules=[[0, 0], [0, 1], [1], [1, 1]]), "$.rules", "different lengths"),
        (
            lambda d: d.update(rules=[[0, 0], [0, 1.0]]),
            "$.rules[1][1]",
            "expected a whole number, got 1.0",
        ),
        (
            lambda d: d.update(rules=[[0, 0], [0, 10**30]]),
            "$.rules[1][1]",
            "expected a whole number",
        ),
        (lambda d: d.update(consequents=[]), "$.consequents", "expected numbers"),
        (
            lambda d: d.update(consequents=[[1.0], [2.0], [3.0, 4.0], [5.0]]),
            "$.consequents",
            "different lengths",
        ),
        (lambda d: d.update(consequents=[[1.0]]), "$.consequents", "R = 4"),
        (
            lambda d: d.update(consequents={"type": "Gaussian", "mean": 0, "sigma": 1}),
            "$.consequents.type",
            "expected Linear or Formulas, got 'Gaussian'",
        ),
        (
            lambda d: d.update(consequents=[[{"type": "Singleton", "point": "inf"}]]),
            "$.consequents[0][0].point",
            "finite",
        ),
        (lambda d: d.update(t_norm="prodct"), "$.t_norm", "did you mean 'product'?"),
        (lambda d: d.update(method="ekn"), "$.method", "did you mean 'ekm'?"),
        (
            lambda d: d.update(fuzzifier={"type": "Gaussian", "mean": 0, "sigma": 1}),
            "$.fuzzifier.type",
            "expected a fuzzifier",
        ),
        (lambda d: d.update(input_names=["a", "a"]), "$.input_names", "2 different names"),
        (lambda d: d.update(resolution=1), "$.resolution", "at least 2"),
        (lambda d: d.update(version=2), "$.version", "this release reads version 1, got 2"),
        (lambda d: d.update(version=True), "$.version", "got true"),
        (lambda d: d.update(format="fuzzy3"), "$.format", 'expected "fuzzy2", got "fuzzy3"'),
        (lambda d: d.pop("format"), "$.format", "got null"),
        (lambda d: d.update(author="me"), "$.author", "unknown field of IntervalType2System"),
    ],
)
def test_what_is_wrong_is_said_with_its_path(change: Any, place: str, said: str) -> None:
    document = through_text(to_json(example()))
    change(document)
    with pytest.raises(MalformedFile) as caught:
        from_json(document)
    assert caught.value.place == place
    assert said in caught.value.reason


def test_a_set_of_the_wrong_type_is_named() -> None:
    document = through_text(to_json(example()))
    document["inputs"][1].append(
        {
            "type": "GaussianType2Set",
            "principal": {"type": "Gaussian", "mean": 0, "sigma": 1},
            "sigma": 1,
        }
    )
    with pytest.raises(
        MalformedFile,
        match=r"\$\.inputs\[1\]: a term of input 2 must be a type-1 or an interval type-2 set",
    ):
        from_json(document)
    low, high = ({"type": "Gaussian", "mean": 0, "sigma": sigma} for sigma in (2, 1))
    with pytest.raises(
        MalformedFile, match=r"\$\.lower: lower must be at most upper everywhere, but at x = "
    ):
        from_json(
            {
                "format": "fuzzy2",
                "version": 1,
                "type": "IntervalType2Set",
                "lower": low,
                "upper": high,
            }
        )


@pytest.mark.parametrize(
    ("text", "place", "said"),
    [
        ('{"format": "fuzzy2",\n "version": 1,,}', "line 2, column 15", "Expecting property name"),
        ("", "line 1, column 1", "Expecting value"),
        (
            '{"format": "fuzzy2", "version": 1, "type": "Gaussian", "mean": NaN, "sigma": 1}',
            "$",
            "NaN is not a number of JSON",
        ),
        (
            '{"format": "fuzzy2", "version": 1, "type": "Gaussian", "mean": 1e999, "sigma": 1}',
            "$",
            "1e999 is too large for a number",
        ),
        (
            (
                '{"format": "fuzzy2", "version": 1, "type": "Gaussian", "mean": 1, "mean": 2, '
                '"sigma": 1}'
            ),
            "$.mean",
            "is given twice",
        ),
        ("[1]", "$", "expected an object, got [1]"),
        ("[" * 100_000, "$", "is nested too deeply"),
        ('{"version": ' + "1" * 5000 + "}", "$", "digits"),
        (
            '{"format": "fuzzy2", "version": 1, "type": "RuleBase", "rules": ["IF x is THEN"]}',
            "$.rules[0]",
            "rule 1 (IF x is THEN) has",
        ),
        (
            '{"format": "fuzzy2", "version": 1, "type": "RuleBase", "rules": []}',
            "$.rules",
            "at least one rule",
        ),
        (
            '{"format": "fuzzy2", "version": 1, "type": "RuleBase"}',
            "$.rules",
            "expected a list, got null",
        ),
        (
            '{"format": "fuzzy2", "version": 1, "type": "RuleBase", "rles": []}',
            "$.rles",
            "did you mean 'rules'?",
        ),
    ],
)
def test_files_that_are_none(tmp_path: Path, text: str, place: str, said: str) -> None:
    path = tmp_path / "broken.json"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(MalformedFile) as caught:
        load(path)
    assert (caught.value.source, caught.value.place) == (str(path), place)
    assert said in caught.value.reason


def test_a_repetition_within_a_set_is_found_too(tmp_path: Path) -> None:
    path = tmp_path / "twice.json"
    path.write_text(
        '{"format": "fuzzy2", "version": 1, "type": "Truncated", "left": 0, "right": 1,'
        ' "whole": {"type": "Gaussian", "mean": 0, "sigma": 1, "sigma": 2}}',
        encoding="utf-8",
    )
    with pytest.raises(MalformedFile, match=r"\$\.whole\.sigma: is given twice"):
        load(path)


def test_deep_nesting_is_refused(tmp_path: Path) -> None:
    """Deep enough for our reader, not for json's: 5000 sets cut off one within another."""
    document: dict[str, Any] = {"type": "Gaussian", "mean": 0, "sigma": 1}
    for _ in range(5000):
        document = {"type": "Truncated", "left": -1, "right": 1, "whole": document}
    with pytest.raises(MalformedFile, match="nested too deeply"):
        from_json({"format": "fuzzy2", "version": 1, **document})


def test_a_file_that_is_not_utf8_names_the_line(tmp_path: Path) -> None:
    path = tmp_path / "latin.json"
    path.write_bytes(b'{"format":\n "gr\xf6\xdfe"}')
    with pytest.raises(MalformedFile, match=r"line 2: byte 0xf6 is not UTF-8"):
        load(path)


@pytest.mark.parametrize(
    ("thing", "said"),
    [
        (FunctionalSet(np.cos, -1.0, 1.0), "FunctionalSet"),
        (Truncated(FunctionalSet(np.cos, -1.0, 1.0), 0.0, 1.0), "FunctionalSet at whole"),
        (FunctionalType2Set(lambda x: Singleton(0.5), 0.0, 1.0), "FunctionalType2Set"),
        (GaussianType2Set(Gaussian(0, 1), np.abs), "the function sigma"),
        (
            Type1System([[Gaussian(0, 1)]], [[0]], [[1.0]], t_norm=lambda a, b: a * b),
            "the t-norm '<lambda>' at t_norm",
        ),
        (object(), "object"),
        ([], "list"),
    ],
)
def test_what_python_functions_define_is_refused(thing: object, said: str) -> None:
    with pytest.raises(NotExpressible) as caught:
        to_json(thing)
    assert str(caught.value).startswith(f"{said} cannot be expressed in JSON: ")


def test_a_file_is_replaced_whole_or_not_at_all(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "set.json"
    save(Gaussian(0.0, 1.0), path)
    before = path.read_text(encoding="utf-8")

    def fail(descriptor: int) -> None:
        raise OSError("disk full")

    monkeypatch.setattr("os.fsync", fail)
    with pytest.raises(OSError, match="disk full"):
        save(Gaussian(1.0, 1.0), path)
    assert path.read_text(encoding="utf-8") == before
    assert [entry.name for entry in tmp_path.iterdir()] == ["set.json"]


def test_behind_a_link_the_file_is_replaced(tmp_path: Path) -> None:
    target, link = tmp_path / "target.json", tmp_path / "link.json"
    save(Gaussian(0.0, 1.0), target)
    link.symlink_to(target)
    save(Gaussian(2.0, 1.0), link)
    assert link.is_symlink()
    assert load(target) == Gaussian(2.0, 1.0)


def test_the_schema_says_what_is_read() -> None:
    """Classes, fields and which of them are needed.

    From the schema that is shipped and from the table that reads.
    """
    assert SCHEMA["properties"]["version"]["const"] == SCHEMA_VERSION
    jsonschema.Draft202012Validator.check_schema(SCHEMA)
    for known, fields in json_files._FIELDS.items():
        definition = SCHEMA["$defs"][known.__name__]
        assert definition["properties"]["type"] == {"const": known.__name__}
        assert set(definition["properties"]) == {"type", *fields}
        assert set(definition["required"]) == {"type", *fields} - json_files._optional(known)
        assert {"$ref": f"#/$defs/{known.__name__}"} in SCHEMA["oneOf"]


@pytest.mark.parametrize(
    "change",
    [
        lambda d: d["inputs"][0][1].update(sigma=-1.0),
        lambda d: d["inputs"][0][1].update(sgma=1.0),
        lambda d: d["inputs"][0][1].update(mean=[0.0]),
        lambda d: d["inputs"][0][1].update(type="os.system"),
        lambda d: d.update(rules=[[0, -2]]),
        lambda d: d.update(version=2),
        lambda d: d.update(author="me"),
        lambda d: d.update(t_norm="prodct"),
    ],
)
def test_the_schema_refuses_what_the_reader_refuses(change: Any) -> None:
    document = copy.deepcopy(to_json(example()))
    assert VALIDATOR.is_valid(document)
    change(document)
    assert not VALIDATOR.is_valid(document)
    with pytest.raises(MalformedFile):
        from_json(document)
