"""Engines in the words of fuzzylite, for the tests of its format and of what it shares."""

from __future__ import annotations

import numpy as np

from fuzzy2 import ParallelSystem, Type1System

HYBRID = """\
Engine: hybrid
InputVariable: heat
  description: a name
  range: 0 10
  term: cold Ramp 6 2
  term: hot Ramp 4 9
InputVariable: wind
  enabled: true
  range: 0 10
  lock-range: false
  term: calm Triangle 0 1 5   # never asked for
  term: windy Gaussian 8 2
OutputVariable: power
  enabled: true
  range: 0 1
  aggregation: AlgebraicSum
  defuzzifier: Centroid 200
  default: nan
  term: low Triangle 0 0.25 0.5
  term: high Triangle 0.5 0.75 1
OutputVariable: price
  range: -20 30
  lock-range: false
  aggregation: none
  defuzzifier: WeightedAverage TakagiSugeno
  default: -1
  term: rising Linear 2 -1 1
  term: fixed Constant 7
RuleBlock: mamdani
  enabled: true
  conjunction: AlgebraicProduct
  disjunction: AlgebraicSum
  implication: Minimum
  # the only activation that is read
  activation: General

  rule: if heat is cold or wind is windy then power is high
  rule: if heat is hot and wind is very not windy then power is low with 0.5
RuleBlock: takagi
  enabled: true
  conjunction: AlgebraicProduct
  disjunction: none
  implication: none
  activation: General
  rule: if heat is cold and wind is any then price is rising
  rule: if (heat is hot and wind is windy) then price is fixed
"""

CHAIN = """\
Engine: chain
InputVariable: light
  range: 0 1
  term: dark Triangle 0 0.25 0.7
  term: bright Triangle 0.3 0.75 1
OutputVariable: first
  range: 0 1
  aggregation: Maximum
  defuzzifier: Centroid 200
  term: low Triangle 0 0.25 0.5
  term: high Triangle 0.5 0.75 1
OutputVariable: second
  range: 0 1
  aggregation: Maximum
  defuzzifier: Centroid 200
  term: high Triangle 0.5 0.75 1
RuleBlock:
  conjunction: none
  disjunction: none
  implication: Minimum
  activation: General
  rule: if light is dark then first is high
  rule: if light is bright then first is low
  rule: if light is dark then first is very low
  rule: if first is somewhat low then second is high
"""

TSUKAMOTO = """\
Engine: tsukamoto
InputVariable: x
  range: -10 10
  term: low Sigmoid 0 -0.5
  term: high Sigmoid 0 0.5
OutputVariable: ramps
  range: 0 1
  defuzzifier: WeightedAverage
  term: b Ramp 0.6 0.4
  term: a Ramp 0 0.25
OutputVariable: sigmoids
  range: 0.02 1
  defuzzifier: WeightedAverage Tsukamoto
  term: b Sigmoid 0.5 -30
  term: a Sigmoid 0.83 30
OutputVariable: concaves
  range: 0 1
  defuzzifier: WeightedAverage Automatic
  term: b Concave 0.5 0.4
  term: a Concave 0.9 1
RuleBlock:
  activation: General
  rule: if x is low then ramps is b and sigmoids is b and concaves is b
  rule: if x is high then ramps is a and sigmoids is a and concaves is a
"""

FORMULAS = """\
Engine: formulas
InputVariable: a
  range: -2 2
  term: low Function 1/(1 + exp(3*x))
  term: high Ramp -1 1
InputVariable: b
  range: 0 4
  term: some Gaussian 2 1
OutputVariable: wave
  aggregation: none
  defuzzifier: WeightedAverage
  default: nan
  lock-previous: true
  term: up Function sin(2*a)*b^2
  term: down Linear 1 -2 0.5
  term: flat Constant -3
OutputVariable: error
  aggregation: none
  defuzzifier: WeightedSum Automatic
  term: off Function abs(wave - a) % 2
OutputVariable: push
  range: 0 2
  aggregation: Maximum
  defuzzifier: Centroid 100
  term: weak Function (1 - x)*lt(x, 0.75)
  term: strong Function 2*x - 2.5
RuleBlock:
  conjunction: AlgebraicProduct
  disjunction: none
  implication: Minimum
  activation: General
  rule: if a is low and b is some then wave is up and push is weak
  rule: if a is high then wave is down and push is strong with 0.5
  rule: if b is not some then wave is flat
  rule: if a is any then error is off
"""
"""Formulas of the inputs, of an output, and of x; the last one is below 0 in its range."""

_KINDS = """\
Arc 0 2
Bell 3 1 2
Binary 2 inf
Concave 1 4
Cosine 3 2
Discrete 0 0.2 2 1 5 0.5
Gaussian 3 1
GaussianProduct 3 1 2 0.5
PiShape 0 1 3 5
Ramp 5 1
Rectangle 1 4
SemiEllipse 1 5
Sigmoid 3 -2
SigmoidDifference 1 4 3 5
SigmoidProduct 1 4 -3 5
Spike 3 4
SShape 1 5
Trapezoid 0 1 2 6
Triangle 1 3 4
ZShape 1 5
Trapezoid -inf 1 2 6 0.5
Bell 3 1 2 0.75
Rectangle 1 4 0.5
Discrete 0 0 2 1 5 0.5 0.5
""".splitlines()

TERMS = "\n".join(
    [
        "Engine: terms",
        "InputVariable: x",
        "  range: 0 6",
        *(f"  term: t{i} {kind}" for i, kind in enumerate(_KINDS)),
        "OutputVariable: y",
        "  range: 0 6",
        "  aggregation: EinsteinSum",
        "  defuzzifier: Bisector 300",
        *(f"  term: t{i} {kind}" for i, kind in enumerate(_KINDS)),
        "OutputVariable: z",
        "  range: 0 6",
        "  aggregation: Maximum",
        "  defuzzifier: WeightedAverage",
        "  term: one Constant 1",
        "  term: two Constant 5",
        "RuleBlock:",
        "  conjunction: HamacherProduct",
        "  disjunction: none",
        "  implication: EinsteinProduct",
        "  activation: General",
        *(
            f"  rule: if x is {('extremely', 'seldom', 'very', 'somewhat')[i % 4]} t{i} "
            f"then y is t{len(_KINDS) - 1 - i} and z is {('one', 'two')[i % 2]}"
            for i in range(len(_KINDS))
        ),
        "",
    ]
)


def inputs_of(system: Type1System | ParallelSystem, count: int = 100, seed: int = 0) -> np.ndarray:
    """Return inputs (count, p) within the ranges of a system."""
    one = system.systems[0] if isinstance(system, ParallelSystem) else system
    ranges = one.input_ranges
    assert ranges is not None
    low, high = np.array(ranges, dtype=float).T
    return np.random.default_rng(seed).uniform(low, high, (count, len(low)))
