"""Interval type-2: the uncertainty of words becomes an interval around the output."""

import fuzzy2
from fuzzy2.plots.sets import figure_of_sets

rules = "IF room is cold THEN heating is on \n IF room is warm THEN heating is off"
for doubt in (0.0, 0.5, 1.5):
    # Two people's meanings of "cold" differ by twice the doubt.
    cold = fuzzy2.GaussianUncertainMean(mean=(18.0 - doubt, 18.0 + doubt), sigma=3.0)
    warm = fuzzy2.GaussianUncertainMean(mean=(24.0 - doubt, 24.0 + doubt), sigma=3.0)
    system = fuzzy2.IntervalType2System(
        {"room": {"cold": cold, "warm": warm}}, rules, {"heating": {"on": 100.0, "off": 0.0}}
    )
    (left, right), answer = system.type_reduced([20.0])[0], system([20.0])[0]
    print(f"doubt of {doubt} degrees: {answer:.1f} %, between {left:.1f} and {right:.1f} %")

figure_of_sets({"cold": cold, "warm": warm})[0].figure.savefig("words.png", dpi=120)
print("words.png")
