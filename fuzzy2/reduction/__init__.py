"""Type reduction and defuzzification."""
