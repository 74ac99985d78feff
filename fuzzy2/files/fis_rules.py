"""Reader and writer of the rules of a ``.fis`` file.

A rule is ``<terms of inputs>, <terms of outputs> (<weight>) : <1 for and, 2 for or>``. Terms are
numbers from 1; 0 means none, and a negative number means *not*. Octave's toolkit and fuzzylite
write hedges as a fraction, which is a tenth of the power: ``2.2`` is *very* for term 2.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

from fuzzy2.errors import NotExpressible
from fuzzy2.files.clauses import clauses_of_rule
from fuzzy2.files.description import (
    SILENT,
    Constant,
    DescribedRule,
    LinearFunction,
    Variable,
    negated,
)
from fuzzy2.files.fis_lines import NUMBER, FisLines, Section
from fuzzy2.systems.antecedents import And, Antecedent, Hedged, Is, Not, Or
from fuzzy2.systems.hedges import HEDGES, Hedge

_RULE = re.compile(rf"([^,():]*),([^,():]*)\(\s*({NUMBER})\s*\)\s*:\s*([0-9]+)\s*")
_TERM_NUMBER = re.compile(r"(-?)([0-9]{1,9})(?:\.([0-9]{1,2})0*)?")

_FUZZYLITE = {0: None, 5: 0.5, 20: 2.0, 30: 3.0, 40: 4.0}
"""Powers of hedges by their hundredths in fuzzylite."""


class FisRules:
    """The rules of a file, with the numbers of its variables' terms."""

    def __init__(
        self, lines: FisLines, inputs: tuple[Variable, ...], outputs: tuple[Variable, ...]
    ) -> None:
        self._lines, self._inputs, self._outputs = lines, inputs, outputs
        # A negation adds a term to its output, which the numbers in the file do not count.
        self._counts = [len(variable.terms) for variable in outputs]

    def rules(self, system: Section) -> tuple[DescribedRule, ...]:
        """Return the rules."""
        lines = self._lines
        if "Rules" not in lines.sections or not lines.sections["Rules"].rules:
            raise lines.malformed(system.number, "there are no rules")
        section = lines.sections["Rules"]
        count = lines.count(system, "NumRules")
        if count != len(section.rules):
            raise lines.malformed(
                system.entries["NumRules"].number,
                f"NumRules is {count}, but there are {len(section.rules)} rules",
            )
        sugeno = lines.string(system, "Type") == "sugeno"
        return tuple(
            rule for line in section.rules for rule in self._rule(line.number, line.value, sugeno)
        )

    def _rule(self, line: int, text: str, sugeno: bool) -> list[DescribedRule]:
        """Return a rule, split up for outputs with hedged terms, which change the firing.

        Octave raises the firing to the inverse of the power.
        """
        found = _RULE.fullmatch(text)
        if found is None:
            raise self._lines.malformed(
                line, f"expected '<inputs>, <outputs> (<weight>) : <1 or 2>', got {text[:60]!r}"
            )
        if found[4] not in ("1", "2"):
            raise self._lines.malformed(
                line, f"expected 1 (and) or 2 (or) at the end, got {found[4]}"
            )
        asked = self._asked(line, found[1].split())
        said, hedged = self._said(line, found[2].split(), sugeno)
        weight = float(found[3])
        if not 0.0 <= weight <= 1.0:
            raise self._lines.malformed(line, f"expected a weight from 0 to 1, got {found[3]}")
        if not asked:
            raise self._lines.malformed(line, "the rule has no antecedent")
        if all(number == SILENT for number in said):
            raise self._lines.malformed(line, "the rule has no consequent")
        tree = asked[0] if len(asked) == 1 else Or(asked) if found[4] == "2" else And(asked)
        if hedged and weight != 1.0:
            raise self._lines.refused(line, "a hedge of an output in a rule with a weight", "use 1")
        plain = tuple(SILENT if j in hedged else number for j, number in enumerate(said))
        rules = [DescribedRule(tree, plain, weight)] if max(plain) > SILENT else []
        for j, power in hedged.items():
            alone = tuple(number if i == j else SILENT for i, number in enumerate(said))
            rules.append(DescribedRule(Hedged(_hedge(power), tree), alone))
        return rules

    def _number(
        self, line: int, word: str, variable: Variable, count: int
    ) -> tuple[bool, int, int]:
        """Return whether a term is negated, its number (0 for none), and its hedge."""
        found = _TERM_NUMBER.fullmatch(word)
        if found is None or int(found[2]) > count:
            raise self._lines.malformed(
                line, f"{variable.name} has membership functions 1 to {count}, got {word!r}"
            )
        return found[1] == "-", int(found[2]), int((found[3] or "0").ljust(2, "0"))

    def _check_length(self, line: int, words: list[str], count: int, kind: str) -> None:
        if len(words) != count:
            raise self._lines.malformed(
                line, f"expected {count} numbers for the {kind}s, got {len(words)}"
            )

    def _asked(self, line: int, words: list[str]) -> tuple[Antecedent, ...]:
        self._check_length(line, words, len(self._inputs), "input")
        parts: list[Antecedent] = []
        for i, (word, variable) in enumerate(zip(words, self._inputs, strict=True)):
            no, number, hundredths = self._number(line, word, variable, len(variable.terms))
            if number == 0:
                continue
            part: Antecedent = Is(i, number - 1)
            power = self._power(line, word, hundredths, variable)
            if hundredths == 99 and self._lines.dialect != "octave":
                part = Is(i, None)
            elif power is not None:
                part = Hedged(_hedge(power), part)
            parts.append(Not(part) if no else part)
        return tuple(parts)

    def _power(self, line: int, word: str, hundredths: int, variable: Variable) -> float | None:
        if hundredths == 0:
            return None
        if self._lines.dialect == "octave":
            return hundredths / 10.0
        if hundredths == 1:
            raise self._lines.refused(line, f"the hedge of {word}, seldom", "it is not a power")
        if hundredths != 99 and hundredths not in _FUZZYLITE:
            count = len(variable.terms)
            raise self._lines.malformed(
                line, f"{variable.name} has membership functions 1 to {count}, got {word!r}"
            )
        return _FUZZYLITE.get(hundredths)

    def _said(
        self, line: int, words: list[str], sugeno: bool
    ) -> tuple[tuple[int, ...], dict[int, float]]:
        """Return the numbers of the outputs' terms, and powers of the firing for hedged ones."""
        self._check_length(line, words, len(self._outputs), "output")
        numbers, hedged = [], {}
        for j, (word, variable, count) in enumerate(
            zip(words, self._outputs, self._counts, strict=True)
        ):
            no, number, hundredths = self._number(line, word, variable, count)
            if hundredths:
                power = self._power(line, word, hundredths, variable)
                if no or power is None or not (sugeno and self._lines.dialect == "octave"):
                    reason = "only Sugeno's outputs have one, in Octave's files (dialect='octave')"
                    raise self._lines.refused(line, f"the hedge of the output {word}", reason)
                hedged[j] = 1.0 / power
            if number == 0:
                numbers.append(SILENT)
                continue
            number -= 1
            if no:
                if isinstance(list(variable.terms.values())[number], Constant | LinearFunction):
                    raise self._lines.refused(
                        line, f"the negation {word}", "only sets have a complement"
                    )
                number = negated(variable, number)
            numbers.append(number)
        return tuple(numbers), hedged


def _hedge(power: float) -> Hedge:
    known = next((hedge for hedge in HEDGES.values() if hedge.power == power), None)
    return known or Hedge(f"to the power {power:g}", power)


def rule_line(
    rule: DescribedRule,
    inputs: Sequence[list[int]],
    outputs: Sequence[list[int]],
    where: str,
) -> str:
    """Return a rule as a line of text.

    Parameters
    ----------
    rule : DescribedRule
        The rule.
    inputs, outputs : sequence of lists of int
        Numbers in the file for the terms of each variable; negative for complements.
    where : str
        The format; hedges are written for Octave.

    Raises
    ------
    NotExpressible
        If it is nested, uses an input twice, has no antecedent, or has hedges that the format
        cannot express.
    """
    flat = clauses_of_rule(rule.asked)
    if flat is None:
        raise NotExpressible(
            "a rule with and and or, or with a negated group", where, "a rule has either"
        )
    either, clauses = flat
    if not clauses:
        raise NotExpressible(
            "a rule without an antecedent", where, "it would look like a rule that never fires"
        )
    words = ["0"] * len(inputs)
    for clause in clauses:
        if words[clause.input] != "0":
            raise NotExpressible(
                "a rule that uses an input twice", where, "it has one number for each"
            )
        words[clause.input] = _word(inputs[clause.input][clause.term], clause.changes, where)
    said = " ".join(
        "0" if number == SILENT else str(numbers[number])
        for number, numbers in zip(rule.said, outputs, strict=True)
    )
    weight = repr(float(rule.weight)).removesuffix(".0")
    return f"{' '.join(words)}, {said} ({weight}) : {2 if either else 1}"


def _word(number: int, changes: tuple[str | Hedge, ...], where: str) -> str:
    """Return the number of a term with its modifiers."""
    negations, power = 0, 1.0
    for change in changes:
        if isinstance(change, Hedge):
            if change.power is None or where != OCTAVE:
                raise NotExpressible(
                    f"the hedge {change.name!r}",
                    where,
                    "only powers have numbers, in the octave dialect",
                )
            power *= change.power
        elif power != 1.0:
            raise NotExpressible("a hedge of a negation", where, "it negates what is hedged")
        else:
            negations += 1
    if number < 0:
        if power != 1.0:
            raise NotExpressible("a hedge of a complement", where, "it negates what is hedged")
        number, negations = -number, negations + 1
    sign = "-" if negations % 2 else ""
    if power == 1.0:
        return f"{sign}{number}"
    hundredths = round(10.0 * power)
    if not 0 < hundredths < 100 or abs(10.0 * power - hundredths) > 1e-9:
        raise NotExpressible(
            f"the power {power:g} of a hedge", where, "it has tenths below 10 only"
        )
    return f"{sign}{number}.{hundredths:02d}"


OCTAVE = ".fis of Octave"
"""Name of the dialect of Octave's toolkit in error messages."""
