"""Type-1, interval type-2 and general type-2 fuzzy logic."""
