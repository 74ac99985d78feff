"""What README.md says in numbers: templates, and comparisons in words."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from tests.documents.sources import OTHER_PATHS, beaten_on, rises, rises_beyond_intervals

TEMPLATES = (
    *(f"{{rows/definitions/{number}}}" for number in range(6)),
    *(f"{{rows/results/{number}}}" for number in range(17)),
    (
        "in closed form ({µs/The robot/equation_of_motion} µs a call), as Pinocchio's RNEA and "
        "CRBA projected onto the screws, and as the thesis's natural orthogonal complement, "
        "corrected where it is misprinted."
    ),
    (
        "In {bars/states} random states M and G of any two agree to {bars/M} and C to {bars/C}, "
        "relative to the largest entry."
    ),
    (
        "A system with {timed system/rules} rules and {timed system/outputs} outputs takes "
        "{µs/Type-2 inference/fuzzy2, type-1} µs a call (type-1), {µs/Type-2 inference/fuzzy2, "
        "interval type-2} µs (interval) or {µs/Type-2 inference/fuzzy2, general type-2, 5 "
        "α-planes} µs (general, five α-planes)."
    ),
    "On a machine with Linux, Python {python} or newer, make and pip:",
    (
        "M, C v and G of every robot of the thesis agree with MuJoCo's, projected on the loops, to "
        "{bars/mujoco} of the largest entry in {bars/mujoco states} random states;"
    ),
    (
        "accelerations of the robots that stand for what people build ([what each is here for]) "
        "to {bars/built}, or to "
        "{bars/rounded:.0f} times what rounding leaves open."
    ),
    (
        "`make reproduce`, with the gains of Table 6.1, on a helix of radius "
        "{settings/radius:mm.0f} mm, {settings/turn:g} s a turn, rise {settings/rise:mm.0f} mm/s,"
        " started at rest, {settings/duration} s, control at {settings/control_period:ms.0f} ms."
    ),
    (
        "An error is the sum of the squared errors of the three screws, every "
        "{settings/sampling_period} s."
    ),
    (
        'The robot has {derived/star:.1f} of Table 3.1\'s star inertia (see below), "type-2" is '
        "interval type-2, and rules are learned and judged on the same helix, by our default "
        'learner ("strongest sample") where no other is named.'
    ),
    (
        "PD's is its sag of {table_6_3/PD/sag:mm.0f} mm under gravity. It says nothing of "
        "tracking, and we chose the length of the run to fit it."
    ),
    "CTC's is the start from rest, {derived/CTC:.2f} of the printed.",
    (
        "ours are {derived/least times:.0f} to {derived/most times:.0f} times the printed, with "
        "the look-up that the thesis cites {derived/strict times/min:.0f} to {derived/strict "
        "times/max:.0f} times."
    ),
    (
        "**Type-2 beats type-1 under {derived/better under} of {derived/definitions} definitions "
        'of "noise of S dB"**, and is worse in {derived/worse cells} of {derived/other cells} '
        "cases of the others."
    ),
    (
        "Under the first type-1 wins in {derived/wins/20:%.0f}, {derived/wins/15:%.0f} and "
        "{derived/wins/10:%.0f} % of the seeds."
    ),
    (
        "**The gain needs no type-2.** Under that definition type-1 with terms "
        "{settings/widths/2:g} times as wide (the best of {settings/widths/0:g}, "
        "{settings/widths/1:g} and {settings/widths/2:g}) leaves {derived/widened/least:%.0f} to "
        "{derived/widened/most:%.0f} % of type-2's error, and type-1 with rules that average "
        "their samples {derived/averaged/least:%.0f} to {derived/averaged/most:%.0f} %."
    ),
    (
        "Among averaging rules type-2 leaves {learners/average, 20/ratio_it2/value:.2f}, "
        "{learners/average, 15/ratio_it2/value:.2f} and {learners/average, "
        "10/ratio_it2/value:.2f} of type-1's; from type-1 with terms {settings/widths/2:g} times "
        "as wide no difference is shown, though that wins in "
        "{wider_type_1_terms_average/20/type_1_wins} of "
        "{wider_type_1_terms_average/20/seeds_compared} seeds at each level."
    ),
    (
        "With noise on measurements, on M, C and G at run time, or masses that are off, type-2 is"
        " worse in {derived/worse readings} of {derived/readings} cases."
    ),
    (
        "**The reason to learn is gone.** In closed form, which the thesis itself asks for, "
        "computed torque takes {µs/One control step/CTC, closed form} µs a step, compiled; by the "
        "thesis's own equations in Python {µs/One control step/CTC, NOC} µs, less than the "
        "{printed/budget:ms.0f} ms that it allows; on its Pentium 4 it took "
        "{printed/step/CTC:ms.0f} ms."
    ),
    (
        "Learned by type-1, interval or general type-2 systems it takes {µs/One control step/t1}, "
        "{µs/One control step/it2} or {µs/One control step/gt2, 5 α-planes} µs (medians, "
        "[one machine])."
    ),
    (
        "{seeds/table_6_3} seeds by the formula in the first row, {seeds/sweeps} in all else, "
        "less those that diverged."
    ),
    (
        "Type-2 wins where the noise is on G and set against its mean square: 20 dB are then "
        "{noise_on_gravity_at_20_dB/noise:.1f} N of noise on what varies by "
        "{noise_on_gravity_at_20_dB/standard_deviation:.1f} N (standard deviation) along the "
        "helix."
    ),
    (
        "It favors type-2, and was chosen after seeing the results, because type-1's error then "
        "grows with the noise, {derived/growth:.1f}-fold at least from 20 to 10 dB "
        "({printed/growth:.1f}-fold in print)."
    ),
    ("Under that definition, mean errors in m² over {seeds/table_6_3} seeds with 95 % intervals."),
    ("Same order is within a factor of {verdict/same order:.0f}."),
    (
        "a nut leaves its screw in {table_6_3/fuzzy/10/t1/left_stroke:%.0f} % of type-1's runs at"
        " 10 dB and in {table_6_3/fuzzy/10/it2/left_stroke:%.0f} % of type-2's:"
    ),
    (
        "Table 5.1's M is matched to {table_5_1/largest_mass_error:.4f} kg and G to "
        "{table_5_1/largest_gravity_error:.3f} N, at its configuration 2, by a fit:"
    ),
    (
        "{derived/star:.1f} of Table 3.1's star inertia with two axes exchanged, which no star of"
        " three equal arms has."
    ),
    (
        "Our robot misses M by {table_5_1/largest_mass_error_of_default_parameters:.2f} kg, Table"
        " 3.1 as printed by {table_5_1/largest_mass_error_of_table_3_1:.1f} kg."
    ),
    (
        "its columns contradict the matched M by {table_5_1/printed_coriolis_column_sum_gap:.3f} "
        "kg/s."
    ),
)


def comparisons(sources: Mapping[str, Any]) -> list[tuple[str, bool]]:
    """Return what is said in words, and whether the numbers say so."""
    table, wide = sources["table_6_3"], sources["wider_type_1_terms_average"]
    without = [entry["mean"]["value"] for entry in table["fuzzy"]["∞"].values()]
    gravity = table["PD with gravity"]["sum_of_squared_errors"]
    faster = [sources["trajectories"][name] for name in ("fast-helix", "fastest-helix")]
    defined, order = sources["definitions"], sources["order"]["tracking"]
    ours, on_g = (
        defined[name]
        for name in ("mean square of each entry (taken here)", "mean square, on G alone")
    )
    others = [
        entry
        for by_level in defined.values()
        if by_level not in (ours, on_g)
        for entry in by_level.values()
    ]
    reached = {
        name: [level for level in ("20", "15", "10") if of[level]["best_ratio"]["high"] > 1.0]
        for name, of in (("ours", ours), ("on G", on_g))
    }
    ratios, strict = (
        [sources[name][level]["ratio"]["value"] for level in ("20", "15", "10")]
        for name in ("type_2_against_type_1", "type_2_against_type_1_strict")
    )
    return [
        (
            "leaves less on this helix than every fuzzy controller with default rules, even "
            "without noise",
            gravity < min(without),
        ),
        (
            "and so on four other paths; on two faster helices it leaves more than those without "
            "noise",
            beaten_on(sources["trajectories"]) == ["helix", *OTHER_PATHS]
            and all(path["PD with gravity"]["value"] > path["fuzzy"]["value"] for path in faster),
        ),
        (
            "no difference is shown, though that wins",
            len({wide[level]["type_1_wins"] for level in wide if level != "∞"}) == 1
            and all(
                wide[level]["verdicts"]["3"] == "no difference shown"
                for level in wide
                if level != "∞"
            ),
        ),
        (
            "is shown among averaging rules only",
            rises_beyond_intervals(sources["learners"], "average")
            and rises(sources["learners"], "average")
            and not rises_beyond_intervals(sources["learners"], "ridge")
            and all(found != sorted(found, reverse=True) for found in (ratios, strict)),
        ),
        (
            "95 % interval includes one at 15 and 10 dB in the first row and at 10 dB in the row "
            "of G; that of geometric means never does",
            reached == {"ours": ["15", "10"], "on G": ["10"]}
            and all(
                entry["best_ratio_of_geometric_means"]["high"] < 1.0
                for of in (ours, on_g)
                for entry in of.values()
            ),
        ),
        (
            "Elsewhere type-2 at its best is nearly type-1",
            all(0.93 < entry["best_ratio"]["value"] < 1.01 for entry in others),
        ),
        (
            "With ridge regression none is shown at 20 and 15 dB",
            all(
                sources["learners"][f"ridge, {level}"]["verdict"] == "no difference shown"
                for level in ("20", "15")
            ),
        ),
        (
            "General type-2 lies between type-1 and interval type-2, with the torque's centroid "
            "below both",
            all(float(row[4].partition(" ")[0]) < 1.0 for row in order.values())
            and all(
                of["it2"]["mean"]["value"] < of["gt2"]["mean"]["value"] < of["t1"]["mean"]["value"]
                for of in (table["fuzzy"][level] for level in ("20", "15", "10"))
            ),
        ),
        (
            "here mostly type-1",
            table["fuzzy"]["10"]["t1"]["diverged"] > table["fuzzy"]["10"]["it2"]["diverged"],
        ),
        (
            "its number for PD is matched by a fit, that for computed torque in order of "
            "magnitude, its noisy ones are not",
            abs(sources["derived"]["PD"]) < sources["verdict"]["reproduced"]
            and sources["derived"]["CTC"] > 1.0 / sources["verdict"]["same order"]
            and sources["derived"]["least times"] > sources["verdict"]["same order"],
        ),
    ]
