"""The plan of the replication: which runs it asks for."""

from __future__ import annotations

from psp3.thesis.plan import DEFINITIONS, Plan


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


def test_every_definition_of_the_noise_is_run_with_both_types_and_the_same_seeds() -> None:
    """And with every mean variation; the default one with all seeds."""
    plan = Plan.of(30)
    for label, fields in DEFINITIONS.items():
        runs = [
            run
            for run in plan.of_definitions()
            if (run.snr_reference, run.noisy_entries, run.reading)
            == (
                fields.get("snr_reference", "mean-square"),
                fields.get("noisy_entries", "all"),
                fields.get("reading", "parameters"),
            )
        ]
        for snr in plan.sweep_levels:
            at = [run for run in runs if run.snr_db == snr]
            seeds = {
                kind: {
                    run.seed for run in at if run.controller == kind and run.mean_variation is None
                }
                for kind in ("t1", "it2")
            }
            assert seeds["t1"] == seeds["it2"] == set(range(30 if label.endswith("here)") else 10))
            tried = {run.mean_variation for run in at} - {None}
            assert tried == set(plan.suited)
