"""Runs of the study as data: what their values may be, and which of them are the same run."""

from __future__ import annotations

import json
import math
import pickle
from dataclasses import asdict, replace
from typing import Any

import numpy as np
import pytest

import fuzzy2
import psp3
from psp3.errors import InvalidValue, UnknownName
from psp3.study.run import CONTROLLERS, DRAWN_BY_SEED, OF_PLANT, Run, field_types

# What a run is


@pytest.mark.parametrize(
    "wrong",
    [
        {"controller": "PD"},
        {"controller": None},
        {"controller": ["it2"]},
        {"controller": psp3.PD()},
        {"reading": "parameter"},
        {"snr_reference": "power"},
        {"snr_reference": 1.0},
        {"noisy_entries": "G"},
        {"noisy_entries": None},
        {"defuzzify": "middle"},
        {"defuzzify": None},
        {"trajectory": "spiral"},
        {"trajectory": psp3.PD()},
        {"trajectory": "sway"},
        {"trajectory": "helix", "robot": "delta"},
        {"learned_on": "spiral"},
        {"controller": "module"},
        {"controller": "no module:Name"},
        {"controller": "module:"},
        {"learner": "best"},
        {"reduction": "km"},
        {"outside": "ignore"},
        {"parameters": "table_9"},
        {"parameters": 1.0},
        {"parameters": "table_3_1", "robot": "delta"},
        {"robot": "eiffel_tower"},
        {"robot": None},
    ],
)
def test_unknown_names_are_refused_and_the_known_ones_listed(wrong: dict[str, Any]) -> None:
    with pytest.raises(UnknownName, match="known are") as caught:
        Run(**wrong).check()
    assert caught.value.name is next(iter(wrong.values()))


@pytest.mark.parametrize(
    "wrong",
    [
        {"snr_db": math.nan},
        {"snr_db": -math.inf},
        {"snr_db": "15"},
        {"snr_db": None},
        {"snr_db": True},
        {"snr_db": [15.0]},
        {"snr_db": 15 + 0j},
        {"snr_db": -1e4},
        {"snr_db": -40.0, "reading": "plant"},
        {"seed": -1},
        {"seed": 1.0},
        {"seed": True},
        {"seed": "1"},
        {"seed": None},
        {"seed": np.bool_(True)},
        {"seed": np.float64(1.0)},
        {"seed": 2**63},
        {"learning_seed": -1},
        {"learning_seed": 0.5},
        {"learned_on": "drawn-helix"},
        {"mass_mismatch": 0.1, "reading": "plant"},
        *({name: -0.1} for name in OF_PLANT),
        {"kp": -1.0},
        {"kv": math.inf},
        {"samples": 0},
        {"samples": 1},
        {"samples": 209.0},
        {"n_terms": 0},
        {"n_terms": 2.5},
        {"n_terms": "2"},
        {"levels": 0},
        {"levels": False},
        {"mean_variation": -0.1},
        {"mean_variation": math.nan},
        {"mean_variation": math.inf},
        {"mean_variation": "0.3"},
        {"mean_variation": True},
        {"payload": -1.0, "reading": "plant"},
        {"payload": math.inf, "reading": "plant"},
        {"payload": None},
        {"payload": "1"},
        {"payload": math.nan},
        {"coulomb_friction": -1.0, "reading": "plant"},
        {"viscous_friction": math.nan, "reading": "plant"},
        {"motor_inertia": "1e-4", "lead": 0.01},
        {"encoder_resolution": -1e-6, "reading": "plant"},
        {"delay": 0.5, "reading": "plant"},
        {"delay": -1, "reading": "plant"},
        {"delay": True, "reading": "plant"},
        {"lead": 0.0},
        {"lead": "10 mm"},
        {"duration": 0.0},
        {"duration": -1.0},
        {"duration": math.nan},
        {"duration": math.inf},
        {"duration": 0.001},
        {"duration": "10"},
        {"duration": None},
        {"duration": True},
        {"duration": 1e300},
        {"period": 0.0},
        {"period": -0.002},
        {"period": math.nan},
        {"period": "0.002"},
        {"period": 1e-300},
        {"period": 1e-9},
        {"period": 0.003},
        {"period": 0.1},
        {"period": 0.05000001},
    ],
)
def test_numbers_outside_of_what_they_can_be_are_refused(wrong: dict[str, Any]) -> None:
    run = Run("it2", **wrong)
    with pytest.raises(InvalidValue) as caught:
        run.check()
    assert caught.value.name in (*wrong, "duration")
    # Even where the field plays no part: a typing error is not passed over.
    with pytest.raises(InvalidValue):
        replace(run, controller="pd").check()


def test_a_motor_with_inertia_needs_a_lead() -> None:
    with pytest.raises(InvalidValue, match="lead must be given"):
        Run("ctc", "plant", motor_inertia=1e-4).check()
    assert Run("ctc", "plant", lead=0.010).canonical() == Run("ctc").canonical()


def test_numbers_of_numpy_make_the_same_run() -> None:
    """Grids are made of them.

    They would count as other types in a table of results, and compile everything anew.
    """
    plain = Run(
        "it2", snr_db=15.0, seed=3, samples=100, mean_variation=0.25, lead=0.5, duration=0.5
    )
    grid = Run(
        "it2",
        snr_db=np.float32(15.0),
        seed=np.int64(3),
        samples=np.uint8(100),
        mean_variation=np.float16(0.25),
        lead=np.float32(0.5),
        duration=np.float64(0.5),
    )  # type: ignore[arg-type]
    assert plain == grid
    assert {type(value) for value in asdict(grid).values()} == {str, int, float, type(None)}
    for name, value in asdict(grid).items():
        assert value is None or type(value) is field_types()[name]
    assert str(grid) == (
        "Run(controller='it2', snr_db=15.0, seed=3, mean_variation=0.25, samples=100, "
        "lead=0.5, duration=0.5)"
    )


def test_runs_can_be_hashed_pickled_and_written_down() -> None:
    run = Run("gt2", "online", 15.0, 7, mean_variation=0.3)
    assert pickle.loads(pickle.dumps(run)) == run
    assert Run(**json.loads(json.dumps(asdict(run)))) == run
    assert len({run, replace(run), Run()}) == 2
    assert eval(str(run)) == run


def test_what_cannot_matter_is_dropped_and_nothing_else() -> None:
    noisy = {"snr_db": 15.0, "seed": 4, "learner": "ridge", "levels": 3}

    def same(run: Run, other: Run, **used: Any) -> bool:
        """Tell whether a run becomes another, with the names that are used for what is left out."""
        return run.canonical() == replace(other, trajectory="helix", **used)

    rules = {"learner": "strongest", "n_terms": 2, "samples": 209, "learned_on": "helix"}
    assert same(Run("pd", **noisy), Run("pd"))
    assert same(Run("pd", "online", **noisy), Run("pd"))
    assert same(Run("feed-forward", "measurement", **noisy, kp=1.0), Run("feed-forward"))
    assert same(
        Run("pd-gravity", "online", **noisy),
        Run("pd-gravity", "online", 15.0, 4),
        learned_on="helix",
    )
    assert same(
        Run("ctc", "measurement", **noisy), Run("ctc", "measurement", 15.0, 4), learned_on="helix"
    )
    assert same(
        Run("t1", **noisy),
        Run("t1", snr_db=15.0, seed=4, mean_variation=0.0),
        **(rules | {"learner": "ridge"}),
    )
    assert Run("it2", snr_db=15.0).canonical().mean_variation == float(
        fuzzy2.mean_variation_from_snr(15.0)
    )
    assert Run("gt2", **noisy).canonical().levels == 3
    assert same(Run("gt2", "measurement", seed=9), Run("gt2", mean_variation=0.0), **rules)
    last = {"mean_variation": 0.0, "defuzzify": "last"}
    for controller in CONTROLLERS:
        kept = Run(controller, **last).canonical().defuzzify
        assert kept == ("last" if controller == "gt2" else "first")
    assert Run("gt2", reduction="gaussian", **last).canonical().defuzzify == "first"
    assert same(Run("ctc", "plant", payload=1.0, seed=9), Run("ctc", payload=1.0))
    other = {"snr_reference": "unit", "noisy_entries": "mass-coriolis"}
    assert same(Run("t1", **other), Run("t1", mean_variation=0.0), **rules)
    assert same(Run("pd", **noisy, **other), Run("pd"))
    assert same(Run("ctc", "inputs", **noisy, **other), Run("ctc"))
    assert same(Run("pd-gravity", "online", **noisy, **other), Run("pd-gravity"))
    for reading, kept in (
        ("parameters", other),
        ("online", other),
        ("inputs", {"snr_reference": "unit"}),
        ("measurement", {"snr_reference": "unit"}),
        ("plant", {}),
    ):
        run = Run("t1", reading, 15.0, 4, mean_variation=0.0)
        assert same(replace(run, **other), replace(run, **kept), **rules)


@pytest.mark.parametrize("name", DRAWN_BY_SEED)
def test_what_a_seed_draws_besides_the_noise_keeps_the_seed(name: str) -> None:
    assert Run("ctc", seed=3).canonical().seed == 0
    assert Run("ctc", seed=3, **{name: 0.01}).canonical().seed == 3
    # Rules of one seed for all runs leave nothing for the others to draw.
    learned = Run("it2", snr_db=20.0, seed=3, learning_seed=0)
    assert learned.canonical().seed == 0
    assert learned.canonical().learning_seed == 0
    assert replace(learned, **{name: 0.01}).canonical().seed == 3
    assert Run("ctc", seed=3, trajectory="drawn-helix").canonical().seed == 3


def test_names_of_another_robot_are_its_own() -> None:
    run = Run("it2", robot="delta")
    run.check()
    one = run.canonical()
    assert (one.trajectory, one.learned_on, one.learner) == ("sway", "sway", "least-squares")
    assert one.samples is None
    Run("ctc", robot="of mine/crane.urdf").check()
    Run("some.module:Name", robot="delta").check()


@pytest.mark.parametrize("controller", ["adaptive-t1", "adaptive-it2"])
def test_rules_of_any_robot_adapt(controller: str) -> None:
    Run(controller).check()
    Run(controller, robot="delta").check()
