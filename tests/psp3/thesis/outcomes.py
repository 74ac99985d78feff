"""Outcomes of runs that were not done, and the tables made of them."""

from __future__ import annotations

import math
from dataclasses import asdict

from psp3.study.run import METRICS
from psp3.study.table import Row
from psp3.thesis.plan import Plan

PLAN = Plan(seeds=6, sweep_seeds=6, terms=(2, 3))


def rows(**factors: float) -> list[Row]:
    """Results of the plan: errors grow as noise does.

    They differ by seed, and are those of type-1 times a factor by controller.
    """
    found = {}
    for run in PLAN.runs():
        one = run.canonical()
        noise = 0.0 if math.isinf(one.snr_db) else 10.0 ** (-one.snr_db / 20.0)
        base = 0.05 + (5.0 if one.learner == "strongest" else 1.0) * noise * (1.0 + 0.1 * one.seed)
        metrics = dict.fromkeys(METRICS, 0.0) | {
            "coverage": 1.0,
            "end_time": 10.4,
            "largest_tip_error": 0.01,
        }
        metrics["sum_of_squared_errors"] = base * (
            1.0 if noise == 0.0 else factors.get(one.controller, 1.0)
        )
        found[one] = {**asdict(one), **metrics}
    return list(found.values())
