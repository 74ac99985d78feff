"""What docs/results.md says in numbers: templates, and comparisons in words."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from tests.documents.sources import OTHER_PATHS, beaten_on, rises, rises_beyond_intervals

TEMPLATES = (
    *(f"{{rows/definitions/{number}}}" for number in range(6)),
    *(f"{{rows/results/{number}}}" for number in range(17)),
    (
        "The path is a helix of radius {settings/radius:mm.0f} mm, {settings/turn:g} s a turn, "
        "rise {settings/rise:mm.0f} mm/s. The robot starts at rest, a run lasts "
        "{settings/duration} s, and the control period is {settings/control_period:ms.0f} ms."
    ),
    (
        "The **error** of a run is the sum of the squared errors of the three screws, sampled "
        "every {settings/sampling_period} s."
    ),
    "The robot has {derived/star:.1f} of Table 3.1's star inertia",
    (
        "its error is the sag of {table_6_3/PD/sag:mm.0f} mm under the robot's weight. It says "
        "nothing about tracking, and we chose the length of the run to match it. The error of "
        "computed torque (CTC) comes from the start at rest. It is {derived/CTC:.2f} of the "
        "printed one."
    ),
    (
        "Ours are {derived/least times:.0f} to {derived/most times:.0f} times as large. With the "
        "table look-up that the thesis cites they are {derived/strict times/min:.0f} to "
        "{derived/strict times/max:.0f} times as large."
    ),
    (
        "**Type-2 is better under {derived/better under} of {derived/definitions} definitions of "
        '"noise of S dB"**, and worse in {derived/worse cells} of {derived/other cells} cases of '
        "the other four."
    ),
    (
        "Even under the first definition type-1 wins in {derived/wins/20:%.0f}, "
        "{derived/wins/15:%.0f} and {derived/wins/10:%.0f} % of the seeds."
    ),
    (
        "Under the first definition, type-1 with terms {settings/widths/2:g} times as wide (the "
        "best of {settings/widths/0:g}, {settings/widths/1:g} and {settings/widths/2:g}) has "
        "{derived/widened/least:%.0f} to {derived/widened/most:%.0f} % of type-2's error. If each "
        "rule averages its samples, the error of type-1 falls to {derived/averaged/least:%.0f} to "
        "{derived/averaged/most:%.0f} % of type-2's."
    ),
    (
        "**Type-2 with averaging rules** has {learners/average, 20/ratio_it2/value:.2f}, "
        "{learners/average, 15/ratio_it2/value:.2f} and {learners/average, "
        "10/ratio_it2/value:.2f} of the error of type-1 with averaging rules. Compared with "
        "type-1 with terms {settings/widths/2:g} times as wide no difference is shown, though "
        "that type-1 wins in {wider_type_1_terms_average/20/type_1_wins} of "
        "{wider_type_1_terms_average/20/seeds_compared} seeds at each level."
    ),
    "type-2 is worse in {derived/worse readings} of {derived/readings} cases.",
    (
        "computed torque takes {µs/One control step/CTC, closed form} µs a step, compiled. The "
        "thesis's own equations take {µs/One control step/CTC, NOC} µs in Python, less than the "
        "{printed/budget:ms.0f} ms that it allows. On its Pentium 4 the step took "
        "{printed/step/CTC:ms.0f} ms."
    ),
    (
        "With a learned model a step takes {µs/One control step/t1}, {µs/One control step/it2} or "
        "{µs/One control step/gt2, 5 α-planes} µs by type-1, interval type-2 or general type-2 "
        "systems (medians on [one machine])."
    ),
    (
        "The first row has {seeds/table_6_3} seeds for the formula, all others have "
        "{seeds/sweeps}, less the seeds whose runs diverged."
    ),
    (
        "A level of 20 dB then means {noise_on_gravity_at_20_dB/noise:.1f} N of noise on a force "
        "that varies by {noise_on_gravity_at_20_dB/standard_deviation:.1f} N (standard deviation) "
        "along the helix."
    ),
    (
        "the error of type-1 grows with the noise: {derived/growth:.1f}-fold at least from 20 to "
        "10 dB ({printed/growth:.1f}-fold in print)."
    ),
    (
        "These are mean errors in m² over {seeds/table_6_3} seeds, with 95 % intervals, under the "
        "first definition."
    ),
    '"Same order" means within a factor of {verdict/same order:.0f}.',
    (
        "A nut leaves its screw in {table_6_3/fuzzy/10/t1/left_stroke:%.0f} % of type-1's runs at "
        "10 dB and in {table_6_3/fuzzy/10/it2/left_stroke:%.0f} % of type-2's."
    ),
    (
        "A fit matches M to {table_5_1/largest_mass_error:.4f} kg and G to "
        "{table_5_1/largest_gravity_error:.3f} N, at its configuration 2. It needs "
        "{derived/star:.1f} of Table 3.1's star inertia with two axes exchanged, which no star of "
        "three equal arms has. The robot that is simulated here misses M by "
        "{table_5_1/largest_mass_error_of_default_parameters:.2f} kg, and Table 3.1 as printed "
        "misses it by {table_5_1/largest_mass_error_of_table_3_1:.1f} kg."
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
            "has a smaller error on this helix than every fuzzy controller with default rules, "
            "even without noise",
            gravity < min(without),
        ),
        (
            "The same holds on four other paths. On two faster helices its error is larger than "
            "that of the fuzzy controllers without noise.",
            beaten_on(sources["trajectories"]) == ["helix", *OTHER_PATHS]
            and all(path["PD with gravity"]["value"] > path["fuzzy"]["value"] for path in faster),
        ),
        (
            "no difference is shown, though that type-1 wins",
            len({wide[level]["type_1_wins"] for level in wide if level != "∞"}) == 1
            and all(
                wide[level]["verdicts"]["3"] == "no difference shown"
                for level in wide
                if level != "∞"
            ),
        ),
        (
            "is shown for averaging rules only",
            rises_beyond_intervals(sources["learners"], "average")
            and rises(sources["learners"], "average")
            and not rises_beyond_intervals(sources["learners"], "ridge")
            and all(found != sorted(found, reverse=True) for found in (ratios, strict)),
        ),
        (
            "95 % interval of that number includes one at 15 and 10 dB in the first row and at 10 "
            "dB in the row of G; that of geometric means never does",
            reached == {"ours": ["15", "10"], "on G": ["10"]}
            and all(
                entry["best_ratio_of_geometric_means"]["high"] < 1.0
                for of in (ours, on_g)
                for entry in of.values()
            ),
        ),
        (
            "In the other rows type-2 at its best is nearly type-1",
            all(0.93 < entry["best_ratio"]["value"] < 1.01 for entry in others),
        ),
        (
            "With ridge regression no difference is shown at 20 and 15 dB",
            all(
                sources["learners"][f"ridge, {level}"]["verdict"] == "no difference shown"
                for level in ("20", "15")
            ),
        ),
        (
            "**General type-2** lies between type-1 and interval type-2. If the torque is "
            "defuzzified last, by its centroid, its error is smaller than both.",
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
    ]
