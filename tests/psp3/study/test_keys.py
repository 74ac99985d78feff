"""Keys of runs, and the runs of a study by them."""

from __future__ import annotations

import math
from dataclasses import asdict, replace
from hashlib import blake2b
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from psp3.errors import InvalidValue, UnknownName
from psp3.study import columns, grid, grids
from psp3.study.columns import RunColumns
from psp3.study.keys import Runs, as_keys, key, setting_key, setting_keys, setting_values
from psp3.study.run import METRICS, Run, contents
from psp3.study.table import Table


def test_key_is_the_content_of_a_run() -> None:
    assert key(Run(snr_db=20)) == key(Run(snr_db=20.0))
    assert key(Run(payload=-0.0)) == key(Run(payload=0.0))
    # What a minus before a zero leads to must not touch what is no float.
    assert key(Run(payload=-0.0, delay=0, speed_noise=-0.05)) == key(Run(speed_noise=-0.05))
    runs = [
        Run(),
        Run("t1"),
        Run(seed=1),
        Run(mean_variation=0.0),
        Run(snr_reference="unit"),
        Run(noisy_entries="gravity"),
        Run(snr_reference="unit", noisy_entries="gravity"),
        Run(defuzzify="last"),
        Run(snr_reference="unit", defuzzify="last"),
        Run(snr_db=20.0),
        Run(snr_db=math.nextafter(20.0, 21.0)),
        Run(robot="delta"),
        Run(kp=1.0),
        Run(kv=1.0),
        Run(seed=256),
    ]
    assert len({key(run) for run in runs}) == len(runs)


def test_key_is_the_one_that_files_have() -> None:
    """A hash of the values as Python writes them, and the seed: a file finds its runs."""
    run = Run(snr_db=20.0, seed=258, mean_variation=0.25)
    values = tuple(value for name, value in asdict(run).items() if name != "seed")
    text = repr(values)
    assert text.startswith("('it2', 'parameters', 20.0, None, None, 2, 0.25, 5, 'alpha_planes', ")
    assert key(run) == blake2b(text.encode(), digest_size=16).digest() + bytes(
        [0, 0, 0, 0, 0, 0, 1, 2]
    )


@given(st.lists(st.binary(min_size=24, max_size=24), min_size=1, unique=True))
def test_arrays_of_keys_keep_zeros_at_the_end_apart(texts: list[bytes]) -> None:
    array = as_keys(b"".join(texts))
    assert len(np.unique(array)) == len(texts)
    assert np.isin(array, as_keys(texts[0])).tolist() == [True] + [False] * (len(texts) - 1)


def test_runs_are_there_once_and_in_canonical_form() -> None:
    given_runs = [
        Run("ctc", snr_db=20.0, seed=5),
        Run("t1", snr_db=20.0, seed=2),
        Run("ctc", snr_db=10.0),
        Run("t1", snr_db=20.0, seed=1),
        Run("t1", snr_db=20.0, seed=2, levels=3),
    ]
    runs = Runs(given_runs)
    assert list(runs) == [given_runs[k].canonical() for k in (0, 1, 3)]
    assert (runs[-1], runs[1:]) == (given_runs[3].canonical(), tuple(runs)[1:])
    assert runs.keys.tobytes() == b"".join(map(key, runs))
    assert runs.shared == {"duration": 10.4}
    assert list(Runs(iter(given_runs))) == list(runs)
    assert runs.missing(as_keys(key(runs[1]))).tolist() == [0, 2]
    assert runs.missing(as_keys(b"")).tolist() == [0, 1, 2]


@pytest.mark.parametrize("at_a_time", [10_000, 7, 1])
def test_keys_are_those_of_canonical_runs(at_a_time: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """One run at a time has no columns, so they make no difference."""
    runs = grid(
        controller=("pd", "t1", "gt2", "ctc-integral", "adaptive-it2"),
        reading=("parameters", "measurement", "online", "plant", "inputs"),
        snr_db=(math.inf, 20.0),
        learner=(None, "ridge"),
        lead=(None, 0.01),
        seed=range(2),
    )
    expected = dict.fromkeys(key(run.canonical()) for run in runs)
    monkeypatch.setattr(columns, "AT_A_TIME", at_a_time)
    monkeypatch.setattr(grids, "AT_A_TIME", at_a_time)
    assert Runs(runs).keys.tobytes() == b"".join(expected)
    assert Runs(list(runs)).keys.tobytes() == b"".join(expected)


VALUES: dict[str, list[Any]] = {
    "controller": ["pd", "feed-forward", "t1", "gt2", "it2", "adaptive-t1", "adaptive-it2", "a:B"],
    "reading": ["parameters", "measurement", "online", "plant", "inputs"],
    "snr_db": [math.inf, 20.0, 9.5, -20.0],
    "seed": [0, 1, 2**63 - 1],
    "trajectory": [None, "helix", "drawn-helix"],
    "mean_variation": [None, 0.0, -0.0, 0.3, 0.4],
    "levels": [1, 5],
    "reduction": ["alpha_planes", "gaussian"],
    "payload": [0.0, -0.0, 1.5, 2.5],
    "payload_from": [0.0, 3.0],
    "motor_inertia": [0.0, 1e-5],
    "lead": [0.01, 0.02],
    "kp": [None, 0.0, 100.0],
    "noisy_entries": ["all", "mass-coriolis"],
    "learned_on": [None, "circle"],
    "learning_seed": [None, 0, 5],
    "position_noise": [0.0, 1e-5, 2e-5],
    "initial_error": [0.0, 1e-3],
}


CHOICES = st.fixed_dictionaries(
    {}, optional={name: st.sampled_from(values) for name, values in VALUES.items()}
)


@given(st.lists(CHOICES, min_size=1, max_size=30))
def test_keys_in_columns_are_those_of_each_run(fields: list[dict[str, Any]]) -> None:
    runs = [Run(**{"lead": 0.02, **values}) for values in fields]
    expected = dict.fromkeys(key(run.canonical()) for run in runs)
    found = Runs(runs)
    assert found.keys.tobytes() == b"".join(expected)
    assert [key(run) for run in found] == list(expected)
    settings = RunColumns.of(runs)
    assert setting_keys(settings) == [key(run)[:16] for run in runs]


WRONG: dict[str, list[Any]] = {
    "payload": [-1.0, math.nan, math.inf, True, "1", None],
    "snr_db": [math.nan, -math.inf, "20", None, True],
    "kv": [-1.0, math.inf, False, "1"],
    "seed": [-1, 2**63, 1.0, True, None],
    "learning_seed": [-1, 2**63, 1.0, True],
    "samples": [1, 2**63, 209.0, True],
    "levels": [0, 5.0, True, "5"],
    "n_terms": [0, 2.0, True],
    "delay": [0.0, False, -1],
    "duration": [0.0, True, 5.0],
    "period": [0.0, 0.003, True],
    "controller": ["none", None, 1],
}


@pytest.mark.parametrize(("name", "value"), [(k, v) for k, values in WRONG.items() for v in values])
def test_what_is_wrong_is_found_among_many_that_are_right(name: str, value: Any) -> None:
    """Also where it is equal to what is right, as True is to 1."""
    right = [Run(payload=1.0, kv=1.0, learning_seed=1, samples=209, seed=k) for k in range(5)]
    with pytest.raises((InvalidValue, UnknownName)) as alone:
        Runs([right[0], replace(right[0], **{name: value})])
    with pytest.raises(type(alone.value)) as among:
        Runs([*right, replace(right[0], **{name: value}), *right])
    assert str(among.value) == str(alone.value)
    assert name in str(alone.value)


@pytest.mark.parametrize("wrong", [{"n_terms": [2]}, {"controller": ["it2"]}, {"seed": [1]}])
def test_what_cannot_be_hashed_is_refused_as_by_the_check(wrong: dict[str, Any]) -> None:
    with pytest.raises((InvalidValue, UnknownName)):
        Runs([Run(**wrong)])


def test_rows_of_others_are_left_out() -> None:
    ours, others = (Run("ctc", "plant", 20.0, seed).canonical() for seed in (3, 4))
    rows = [{**contents(run), **dict.fromkeys(METRICS, 1.0)} for run in (others, ours)]
    found = Runs([ours]).rows_of(Table.of(rows))
    assert [row["seed"] for row in found] == [3]


def test_setting_is_all_but_the_seed() -> None:
    run = Run("it2", seed=3)
    assert setting_key(setting_values(run)) == key(run)[:16]
    assert setting_values(run) == setting_values(replace(run, seed=4))
