"""A fuzzy system for a microcontroller: two C99 files, and a test against Python."""

import fuzzy2
from fuzzy2.export.project import export_project

terms = {
    "low": fuzzy2.GaussianUncertainMean(mean=(18.0, 19.0), sigma=3.0),
    "high": fuzzy2.GaussianUncertainMean(mean=(25.0, 26.0), sigma=3.0),
}
system = fuzzy2.IntervalType2System(
    {"temperature": terms},
    "IF temperature is low THEN heating is on \n IF temperature is high THEN heating is off",
    {"heating": {"on": 1.0, "off": 0.0}},
)
code = export_project(system, "heating", precision="single", name="heating")
for function in code.functions:
    print("heating/heating.c has", function.name)
print(f"Python says {system([20.0])[0]:.4f}; 'make -C heating test' compares 200 cases in C")
