"""Fuzzy sets of type 1, interval type 2 and general type 2."""
