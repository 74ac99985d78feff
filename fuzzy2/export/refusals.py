"""Parts of a fuzzy system that cannot be written in C, and their replacements."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from fuzzy2.errors import NotExportable
from fuzzy2.operations.t_norms import T_CONORMS, T_NORMS
from fuzzy2.sets.general_type2 import GeneralType2Set
from fuzzy2.systems.antecedents import And, Antecedent, Hedged, Not, Or, hedge_step
from fuzzy2.systems.consequents import Formulas, FunctionsOfInputs
from fuzzy2.systems.general_type2 import GeneralType2System
from fuzzy2.systems.hedges import Hedge
from fuzzy2.systems.operators import SUM, UNIONS
from fuzzy2.systems.system import FuzzySystem
from fuzzy2.systems.term_rows import TermRows
from fuzzy2.systems.terms import domain_of


def refusal_of(system: FuzzySystem) -> NotExportable:
    """Return the error that names the part of a system that no kernel supports."""
    return _of_terms(system) or _of_operators(system) or _of_rules(system) or _of_outputs(system)


def refusal_of_planes(system: GeneralType2System, error: NotExportable) -> NotExportable:
    """Return the error for a system with an α-plane that cannot be written in C."""
    each = zip(system.input_names, system.inputs, system.term_names, strict=True)
    for i, (name, terms, words) in enumerate(each):
        for t, (term, word) in enumerate(zip(terms, words, strict=True)):
            plane = term.alpha_plane(1.0) if isinstance(term, GeneralType2Set) else term
            if not TermRows().add(0, plane, plane.kernel_row()):
                return _unknown(i, t, term, f"the term {word!r} of {name!r}")
    return NotExportable(f"an α-plane, of it {error.what}", error.why, error.remedy)


def _unknown(i: int, t: int, term: Any, called: str) -> NotExportable:
    return NotExportable(
        f"system.inputs[{i}][{t}], {called}, a {type(term).__name__},",
        "no kernel knows this set",
        f"its samples, between which it is linear: {_tabulation(i, t, term)}",
    )


def _of_terms(system: FuzzySystem) -> NotExportable | None:
    each = zip(system.input_names, system.inputs, system.term_names, strict=True)
    for i, (name, terms, words) in enumerate(each):
        for t, (term, word) in enumerate(zip(terms, words, strict=True)):
            if not TermRows().add(0, term, system.kernel_row(term)):
                return _unknown(i, t, term, f"the term {word!r} of {name!r}")
    return None


def _tabulation(i: int, t: int, term: Any) -> str:
    """Return the code that replaces a term with its samples."""
    own = f"inputs[{i}][{t}]"
    left, right = domain_of([term.alpha_plane(1.0) if isinstance(term, GeneralType2Set) else term])
    sampled = f"{own}.sample(points)"
    if isinstance(term, GeneralType2Set):
        planes = f"{own}.alpha_plane(alpha).sample(points) for alpha in system.alphas"
        sampled = f"fuzzy2.ZSlices(system.alphas, [{planes}])"
    return (
        f"points = numpy.linspace({left:.6g}, {right:.6g}, 201); "
        "inputs = [list(terms) for terms in system.inputs]; "
        f"{own} = {sampled}; system = system.replace(inputs=inputs)"
    )


def _of_operators(system: FuzzySystem) -> NotExportable | None:
    if system.fuzzifiers is not None:
        return NotExportable(
            "the fuzzifier",
            "no kernel knows how it fires a term",
            "a singleton fuzzifier, and as terms what this one makes of them: "
            "SampledSet(points, fuzzifier.firing(term, points, system.t_norm)[:, 1])",
        )
    for what, norm, known in (
        ("the t-norm", system.t_norm, T_NORMS),
        ("the t-conorm of or", system.disjunction, T_CONORMS),
        ("the implication", system.implication, T_NORMS),
        ("the t-conorm that unites what rules say", system.t_conorm, T_CONORMS),
    ):
        if norm is not SUM and norm != known.get(norm.name):
            return NotExportable(
                f"{what}, {norm.name!r}",
                "no kernel knows this function",
                f"one of {', '.join(known)}",
            )
    return None


def _of_rules(system: FuzzySystem) -> NotExportable | None:
    if not isinstance(system.rules, tuple):
        return None
    for r, tree in enumerate(system.rules):
        for hedge in _hedges_in(tree):
            if hedge_step(hedge) is None:
                return NotExportable(
                    f"the hedge {hedge.name!r} of rule {r + 1}",
                    "kernels know no function of one's own",
                    "of fuzzy2.systems.hedges Hedge(word, power=...), or "
                    "Hedge(word, function=...) with intensify, relax or Scaled(factor)",
                )
    return None


def _hedges_in(tree: Antecedent) -> Iterator[Hedge]:
    """Yield the hedges of a rule."""
    if isinstance(tree, Hedged):
        yield tree.hedge
    if isinstance(tree, And | Or):
        for part in tree.parts:
            yield from _hedges_in(part)
    elif isinstance(tree, Not | Hedged):
        yield from _hedges_in(tree.part)


def _of_outputs(system: FuzzySystem) -> NotExportable:
    kind, given = system.type_reduction, system.consequents
    if isinstance(given, Formulas) and given.asked:
        return NotExportable(
            f"formulas of {', '.join(map(repr, given.asked))}",
            "they use outputs of another system",
            "formulas of the inputs alone",
        )
    if isinstance(given, FunctionsOfInputs):
        return NotExportable(
            f"consequents of type {type(given).__name__}",
            "no kernel knows these functions",
            "fuzzy2.Linear, fuzzy2.systems.consequents.Formulas, or numbers",
        )
    if kind in UNIONS and system.integration == "exact":
        wanted = "of their sums nothing but centroids and bisectors" if _is_summed(system) else ""
        return NotExportable(
            f"the output sets {_sets_of(system)} under {kind!r}, without a grid",
            "kernels integrate Gaussians and trapezoids, united by the maximum or the sum, clipped "
            f"by the minimum or scaled by the product{', ' + wanted if wanted else ''}",
            "system.replace(integration='sum', resolution=501), which takes the grades of any set "
            "at so many points",
        )
    if kind == "tsukamoto":
        return NotExportable(
            f"the output sets {_sets_of(system)}",
            "no kernel knows one of them",
            "their samples, set.sample(points), between which they are linear",
        )
    return NotExportable(
        f"type reduction {kind!r} of numbers up to {np.abs(system.consequent_intervals).max():.3g}",
        "no kernel knows it of such numbers",
        "consequents below 1e100, in another unit",
    )


def _is_summed(system: FuzzySystem) -> bool:
    return system.type_reduction == "center_of_sums" or system.t_conorm is SUM


def _sets_of(system: FuzzySystem) -> str:
    """Return the types of the consequents."""
    rows = system.consequent_sets or ()
    return ", ".join(sorted({type(item).__name__ for row in rows for item in row if item}))
