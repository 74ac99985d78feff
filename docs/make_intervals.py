"""Write ``docs/concepts/intervals.md``: how often 95 % intervals hold the truth.

Run by ``python docs/make_intervals.py``, which takes some five minutes.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np

from fuzzy2.support.text_files import written_whole
from psp3.checks import Array
from psp3.study.statistics import (
    Estimate,
    mean,
    median,
    paired_difference,
    ratio_of_geometric_means,
    ratio_of_means,
)

PAGE = Path(__file__).resolve().parent / "concepts" / "intervals.md"

SETS = 4000
TYPICAL_RATIO = 0.45


class Case(NamedTuple):
    """Lognormal pairs: their number, and standard deviations and correlation of logarithms.

    Those of the sums of squared errors of type-1 and type-2, seed by seed.
    """

    pairs: int
    spreads: tuple[float, float]
    correlation: float


# From 30 seeds of each level, of which at 10 dB 21 have two errors.
CASES = {
    "20 dB, 10 pairs": Case(10, (0.77, 0.62), 0.67),
    "20 dB, 30 pairs": Case(30, (0.77, 0.62), 0.67),
    "15 dB, 30 pairs": Case(30, (0.81, 0.65), 0.54),
    "10 dB, 30 pairs": Case(30, (0.54, 0.68), -0.12),
}

ESTIMATES: dict[str, Callable[[Array, Array], Estimate]] = {
    "mean": lambda one, other: mean(one),
    "median": lambda one, other: median(one),
    "difference of means": lambda one, other: paired_difference(other, one),
    "ratio of means": lambda one, other: ratio_of_means(other, one),
    "ratio of geometric means": lambda one, other: ratio_of_geometric_means(other, one),
}

TEXT = """# How far to trust a 95 % interval

*Written by `docs/make_intervals.py`; do not edit.*

Errors of runs are skewed: most are small, some are large. A 95 % interval that assumes normally
distributed numbers, or many of them, contains the true value less often than it claims. Every
`Estimate` of `psp3.study.statistics` names what it estimates (`estimand`) and how its interval was
found (`method`). The table says how often these intervals contained the true value in {sets}
simulated sets of pairs like those of the study. Each share is uncertain by {error:.1f} %.

{table}

The pairs are lognormal. Logarithms of the sums of squared errors have these standard deviations:
{cases}. True values are known by formula.

- **Ratio of geometric means**, `ratio_of_geometric_means`: by what factor one controller changes
  the error of a typical run. Student's interval of the logarithms by seed is exact for lognormal
  pairs, so here its row differs from 95 % only by chance. In general it needs logarithms that are
  nearly normal. Use it to ask which controller is better with the same noise.
- **Ratio of means**, `ratio_of_means`: the error of one controller in all runs together, divided
  by that of the other. Runs with large errors decide it. It is a different number: with the pairs
  of 20 dB it is {ratio:.2f}, and the ratio of geometric means is {typical:.2f}. An interval
  of one is not an interval of the other.
- **Mean** and **difference of means**: the interval is a symmetric bootstrap-t (P. Hall, 1988).
  The distance of each resample from the estimate is measured in the standard error of the resample.
  The half-width is the distance that 95 % of the resamples do not exceed in either direction. For
  means and ratios of positive numbers this is done with logarithms. The misses are not symmetric:
  most intervals of a mean that miss the true value lie below it.
- **Median**: the interval lies between percentiles of the bootstrap.

Intervals of means and differences with ten seeds contain the true value in less than 95 % of
cases. For numbers that are more skewed than these pairs, such as a metric with single runs that
nearly diverge, expect still less. If you can choose, take thirty seeds and the ratio of geometric
means. All intervals leave out runs that diverged; their share is printed beside them.
"""


def truth(case: Case) -> dict[str, float]:
    """Return the true values of the estimates, by name."""
    one, other = (math.exp(0.5 * spread**2) for spread in case.spreads)
    other *= TYPICAL_RATIO
    return {
        "mean": one,
        "median": 1.0,
        "difference of means": other - one,
        "ratio of means": other / one,
        "ratio of geometric means": TYPICAL_RATIO,
    }


def coverage(case: Case, sets: int, rng: np.random.Generator) -> dict[str, float]:
    """Return the share of simulated sets whose interval holds the true value, by name."""
    hits, true = dict.fromkeys(ESTIMATES, 0), truth(case)
    for _ in range(sets):
        shared, own = rng.standard_normal((2, case.pairs))
        own = case.correlation * shared + math.sqrt(1.0 - case.correlation**2) * own
        one, other = np.exp(case.spreads[0] * shared), np.exp(case.spreads[1] * own)
        for name, estimated in ESTIMATES.items():
            estimate = estimated(one, TYPICAL_RATIO * other)
            hits[name] += estimate.low <= true[name] <= estimate.high
    return {name: hit / sets for name, hit in hits.items()}


def read() -> dict[str, dict[str, float]]:
    """Return the shares that the page prints, by case and estimate."""
    printed: dict[str, dict[str, float]] = {name: {} for name in CASES}
    for estimate in ESTIMATES:
        row = re.search(rf"^\| {estimate} \|.*$", PAGE.read_text(), re.MULTILINE)
        if row is None:
            raise SystemExit(f"{PAGE} has no row {estimate!r}: write it again")
        shares = re.findall(r"([\d.]+) %", row.group())
        for name, share in zip(CASES, shares, strict=True):
            printed[name][estimate] = float(share) / 100.0
    return printed


def main() -> None:
    """Simulate, and write the page."""
    rng = np.random.default_rng(0)
    found = {name: coverage(case, SETS, rng) for name, case in CASES.items()}
    sample = np.exp(rng.standard_normal((2, 5)))
    lines = [
        "| estimate | interval | " + " | ".join(CASES) + " |",
        "|---|---|" + "---|" * len(CASES),
    ]
    for estimate, estimated in ESTIMATES.items():
        shares = " | ".join(f"{100.0 * found[name][estimate]:.1f} %" for name in CASES)
        lines.append(f"| {estimate} | {estimated(*sample).method} | {shares} |")
    cases = [
        f"{case.spreads[0]} for type-1 and {case.spreads[1]} for type-2, with the correlation "
        f"{case.correlation} from seed to seed at {name.partition(',')[0]}"
        for name, case in CASES.items()
        if case.pairs == 30
    ]
    text = TEXT.format(
        sets=SETS,
        error=100.0 * math.sqrt(0.95 * 0.05 / SETS),
        table="\n".join(lines),
        cases="; ".join(cases),
        ratio=truth(CASES["20 dB, 30 pairs"])["ratio of means"],
        typical=TYPICAL_RATIO,
    )
    with written_whole(PAGE) as file:
        file.write(text)


if __name__ == "__main__":
    main()
