"""What the text of notebook 5 says in numbers: templates, and comparisons in words."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

TEMPLATES = (
    (
        "With a helix of radius {settings/radius:mm.0f} mm, period {settings/turn:g} s, rise "
        "{settings/rise:mm.0f} mm/s, started at rest, {settings/duration} s long, and one sample "
        "of the squared error every {settings/sampling_period} s, a number that we chose to fit "
        "the PD row:"
    ),
    (
        "Add the exact $G$ to the PD law, which the thesis did not try, and its error is "
        "{derived/PD over PD with gravity:.0f} times smaller."
    ),
    (
        "Here are {notebook/seeds} seeds, two levels of noise on the recorded $M$, $C$, $G$, "
        "three learners, type-1 against interval type-2."
    ),
    (
        "Of ten seeds like ours such an interval of a mean holds the true value in "
        "{measured_coverage/10 seeds/mean:%.1f} % of cases, and that of a difference of means in "
        "{measured_coverage/10 seeds/difference of means:%.1f} %."
    ),
    (
        "Mean squared error with 95 % intervals over {notebook/seeds} seeds, on a logarithmic "
        "scale, for three learners at 20 dB (on the left) and 10 dB (on the right)."
    ),
    (
        "Keeping the strongest sample instead of averaging multiplies type-1's error by "
        "{notebook/learner/20:.0f} and {notebook/learner/10:.0f}, and type-2 instead of type-1 "
        "divides it by {notebook/type/20:.1f} and {notebook/type/10:.1f}."
    ),
    (
        "With the strongest sample or with averages type-2's error is {notebook/least ratio:.2f} "
        "to {notebook/most ratio:.2f} of type-1's;"
    ),
    (
        "the printed ratios (squares) are {printed/inverse/20:.2f} at 20 dB and "
        "{printed/inverse/10:.2f} at 10 dB, of one run each."
    ),
    (
        "**Under which definition:** only where the ratio is set against the mean square, its "
        "mean included, and noise is on $G$. 20 dB are then {noise_on_gravity_at_20_dB/noise:.1f}"
        " N of noise on $G$, which varies by {noise_on_gravity_at_20_dB/standard_deviation:.1f} N"
        " (standard deviation) along the helix."
    ),
    (
        "Against the variance of each entry, against one in each unit (0 dBW), or with noise on "
        'the recorded inputs (`snr_reference` and `reading="inputs"` of `psp3.Run`), type-2\'s '
        "error is {derived/whole/min:.2f} to {derived/whole/max:.2f} times type-1's, and with the"
        " mean variation that suits it best about the same. The report of `psp3 reproduce` "
        "has that table."
    ),
    (
        "it is {derived/times/10/t1:.1f} to {derived/times/20/t1:.1f} times as large as printed, "
        "and the choice favors type-2."
    ),
    (
        "Single runs spread from {type_2_against_type_1/20/spread_of_ratios/0:.2f} to "
        "{type_2_against_type_1/20/spread_of_ratios/1:.2f} at 20 dB, so widely that the printed "
        "ratios neither confirm nor contradict ours."
    ),
    (
        "at gains of {printed/gains/CTC/p:.0f} and {printed/gains/CTC/v:.0f} they are soft, and "
        "any error of the model shows in full.)"
    ),
    ("the differences for factors {settings/widths/0:g} and {settings/widths/1:g} are negative."),
    (
        "With rules that average, type-1 with terms {settings/widths/2:g} times as wide has less "
        "error than type-2 in {wider_type_1_terms_average/20/type_1_wins} of "
        "{wider_type_1_terms_average/20/seeds_compared} seeds (`psp3 reproduce`), but no "
        "difference of the means is shown."
    ),
    "The {notebook/seeds} errors behind each mean, sorted:",
    (
        "between the best and the worst run is a factor of {notebook/least spread:.1f} to "
        "{notebook/most spread:.1f}, more than between the controllers."
    ),
    (
        "**Runs that diverge have no error.** At 10 dB with the strongest sample "
        "{notebook/diverged:.0f} of the {notebook/seeds} type-1 runs end early."
    ),
    (
        "The thesis learned $M$, $C$ and $G$ because computing them took {printed/step/CTC:ms.0f}"
        " ms;"
    ),
    "What {notebook/seeds} seeds cannot do:",
)


def comparisons(sources: Mapping[str, Any]) -> list[tuple[str, bool]]:
    """Return what is said in words, and whether the numbers say so."""
    levels = ("20", "15", "10")
    table, wide = sources["table_6_3"], sources["wider_type_1_terms_average"]
    ridge = sources["notebook"]["ratios"]["ridge"].values()
    best = [
        sources["definitions"][name][level]["best_ratio"]["value"]
        for name in (
            "variance of each entry",
            "1 in each unit (0 dBW)",
            "mean square, on the recorded inputs",
        )
        for level in levels
    ]
    return [
        (
            "but no difference of the means is shown",
            all(wide[level]["verdicts"]["3"] == "no difference shown" for level in levels),
        ),
        (
            "With ridge regression both intervals include one",
            all(ratio.low < 1.0 < ratio.high for ratio in ridge),
        ),
        (
            "and with the mean variation that suits it best about the same",
            all(abs(ratio - 1.0) < 0.005 for ratio in best),
        ),
        (
            "on this helix by PD with the exact gravity term",
            table["PD with gravity"]["sum_of_squared_errors"]
            < min(entry["mean"]["value"] for entry in table["fuzzy"]["∞"].values()),
        ),
    ]
