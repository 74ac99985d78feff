"""The tipping problem: two inputs, three rules in words, and the tip over all inputs."""

import fuzzy2
from fuzzy2.plots.systems import figure_of_rule_surface

T = fuzzy2.Triangular
service = {"poor": T(-5, 0, 5), "good": T(0, 5, 10), "excellent": T(5, 10, 15)}
food = {"bad": T(-10, 0, 10), "nice": T(0, 10, 20)}
system = fuzzy2.Type1System(
    {"service": service, "food": food},
    """
    IF service is poor or food is bad THEN tip is low
    IF service is good THEN tip is medium
    IF service is excellent or food is nice THEN tip is high
    """,
    {"tip": {"low": T(0, 5, 10), "medium": T(10, 15, 20), "high": T(20, 25, 30)}},
    t_norm="min",
    type_reduction="centroid",
    input_ranges=[(0, 10), (0, 10)],
    output_ranges=[(0, 30)],
)
for s, f in ((2, 3), (5, 5), (9, 8)):
    print(f"service {s}, food {f}: {system(service=s, food=f)[0]:.1f} %")

figure_of_rule_surface(system)[0].figure.savefig("tip.png", dpi=120)
print("tip.png")
