"""The terms of an FML document."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from fuzzy2.errors import Fuzzy2Error, MalformedFile, NotExpressible
from fuzzy2.files.description import Constant, LinearFunction
from fuzzy2.files.fml_elements import Element, FmlElements
from fuzzy2.files.fml_names import SHAPES, T_CONORMS, T_NORMS
from fuzzy2.operations.set_operations import complement, intersection, union
from fuzzy2.sets.derived import Complement, FunctionalSet
from fuzzy2.sets.type1 import SampledSet, Type1Set
from fuzzy2.support.checks import Array

_POINTS = ("pointSetShape", "pointSetMonotonicShape")
_OTHERS = ("circularDefinition", "customShape", "customMonotonicShape")


class FmlTerms:
    """Terms of variables, by name."""

    def __init__(self, elements: FmlElements) -> None:
        self._elements = elements

    def sets(self, variable: Element, kind: str, domain: tuple[float, float]) -> dict[str, Any]:
        """Return the sets of a variable; sets that are made from others are defined last."""
        circular: dict[str, Element] = {}

        def read(term: Element) -> Any:
            shape = self._elements.only(term, *SHAPES, *_POINTS, *_OTHERS)
            if shape.name == "circularDefinition":
                circular[term.attributes["name"]] = term
                return None
            one = self._shape(shape, domain)
            return Complement(one) if self._elements.truth(term, "complement") else one

        terms = self._terms(variable, kind, read)
        for name in circular:
            self._define(name, terms, circular, ())
        return terms

    def functions(self, variable: Element) -> dict[str, Any]:
        """Return the constants and functions of a variable."""
        return self._terms(variable, "tskTerm", self._function)

    def _terms(self, element: Element, kind: str, read: Callable[[Element], Any]) -> dict[str, Any]:
        elements, terms = self._elements, dict[str, Any]()
        for child in elements.children(element, kind):
            name = elements.attribute(child, "name")
            if name in terms:
                raise elements.malformed(child.line, f"the name {name!r} is given to two terms")
            terms[name] = read(child)
        if not terms:
            raise elements.malformed(
                element.line, f"expected at least one <{kind}> in <{element.name}>"
            )
        return terms

    def _define(
        self,
        name: str,
        terms: dict[str, Any],
        circular: dict[str, Element],
        within: tuple[str, ...],
    ) -> Any:
        """Return a term, which is defined first if it is made from others."""
        if terms.get(name) is not None:
            return terms[name]
        term = circular[name]
        if name in within:
            raise self._elements.malformed(term.line, f"{name!r} is defined by itself")
        definition = self._elements.only(term, "circularDefinition")
        (made,) = self._parts(definition, terms, circular, (*within, name), 1)
        negated = self._elements.truth(term, "complement")
        terms[name] = complement(made) if negated else made
        return terms[name]

    def _parts(
        self,
        element: Element,
        terms: dict[str, Any],
        circular: dict[str, Element],
        within: tuple[str, ...],
        count: int,
    ) -> list[Any]:
        elements, parts = self._elements, list[Any]()
        for child in elements.children(element, "and", "or", "termName"):
            if child.name == "termName":
                known = elements.named(child, terms, "term")
                parts.append(self._define(known, terms, circular, within))
            elif child.name == "and":
                t_norm = elements.choice(child, "t-norm", "MIN", T_NORMS)
                inside = self._parts(child, terms, circular, within, 2)
                parts.append(intersection(*inside, t_norm=t_norm))
            else:
                t_conorm = elements.choice(child, "t-conorm", "MAX", T_CONORMS)
                inside = self._parts(child, terms, circular, within, 2)
                parts.append(union(*inside, t_conorm=t_conorm))
        if len(parts) < count or count == 1 != len(parts):
            wanted = "one <and> or <or>" if count == 1 else "two terms"
            raise elements.malformed(
                element.line, f"expected {wanted} in <{element.name}>, got {len(parts)}"
            )
        return parts

    def _function(self, element: Element) -> Constant | LinearFunction:
        elements = self._elements
        values = [
            elements.number(child, child.text.strip())
            for child in elements.children(element, "tskValue")
        ]
        order = elements.attribute(element, "order")
        if order == "0" and len(values) == 1:
            return Constant(values[0], values[0])
        if order == "1" and len(values) > 1:
            return LinearFunction(values[0], tuple(values[1:]))
        raise elements.malformed(
            element.line,
            f"expected one value of order 0, or several of order 1, got {len(values)} of order "
            f"{order!r}",
        )

    def _shape(self, shape: Element, domain: tuple[float, float]) -> Type1Set:
        elements = self._elements
        if shape.name not in SHAPES and shape.name not in _POINTS:
            raise elements.refused(shape.line, f"<{shape.name}>", "no class here has its shape")
        try:
            if shape.name in _POINTS:
                return self._points(shape, domain)
            count, make = SHAPES[shape.name]
            return make(
                *(
                    elements.number(shape, elements.attribute(shape, f"param{i + 1}"))
                    for i in range(count)
                )
            )
        except (MalformedFile, NotExpressible):
            raise
        except Fuzzy2Error as error:
            raise elements.malformed(shape.line, f"{shape.name}: {error}") from error

    def _points(self, shape: Element, domain: tuple[float, float]) -> Type1Set:
        elements = self._elements
        method = elements.attribute(shape, "interpolationMethod", "linear").lower()
        if method not in ("linear", "lagrange"):
            raise elements.refused(
                shape.line,
                f"interpolationMethod={method!r}",
                "points are interpolated linearly, or by Lagrange's polynomial",
            )
        pairs = sorted(
            (
                elements.number(p, elements.attribute(p, "x")),
                elements.number(p, elements.attribute(p, "y")),
            )
            for p in elements.children(shape, "point")
        )
        if not pairs:
            raise elements.malformed(shape.line, "expected at least one <point>")
        if method == "lagrange":
            return self._polynomial(shape, pairs, domain)
        # Beyond its points such a shape keeps its first and last grade, whereas a sampled set is 0
        # there.
        if pairs[0][0] > domain[0] and pairs[0][1] != 0.0:
            pairs.insert(0, (domain[0], pairs[0][1]))
        if pairs[-1][0] < domain[1] and pairs[-1][1] != 0.0:
            pairs.append((domain[1], pairs[-1][1]))
        return SampledSet([x for x, _ in pairs], [y for _, y in pairs])

    def _polynomial(
        self, shape: Element, pairs: list[tuple[float, float]], domain: tuple[float, float]
    ) -> Type1Set:
        x, y = np.array(pairs).T
        if (np.diff(x) <= 0.0).any():
            raise self._elements.malformed(shape.line, "expected points at different places")

        def polynomial(at: Array) -> Array:
            total = np.zeros_like(at)
            for k in range(len(x)):
                others = np.delete(x, k)
                factors = (at[..., np.newaxis] - others) / (x[k] - others)
                total = total + y[k] * factors.prod(axis=-1)
            return total

        # The polynomial may leave [0, 1] between the points, so grades are limited.
        inside = [float(one) for one in x if math.isfinite(one)]
        return FunctionalSet(lambda at: np.clip(polynomial(at), 0.0, 1.0), *domain, tuple(inside))
