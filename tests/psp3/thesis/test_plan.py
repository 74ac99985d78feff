"""The plan of the replication: which runs it asks for."""

from __future__ import annotations

from psp3.thesis.plan import Plan


def test_the_whole_plan_has_the_seeds_it_is_asked_for() -> None:
    runs = Plan.of(30).runs()
    main = {
        run.seed
        for run in runs
        if (run.controller, run.snr_db, run.reading) == ("it2", 10.0, "parameters")
    }
    sweep = {run.seed for run in runs if run.reading == "plant"}
    assert main == set(range(30))
    assert sweep == set(range(10))
    assert Plan.of(3).sweep_seeds == 3
    for run in runs:
        run.check()
