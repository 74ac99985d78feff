"""Robots, controllers and fuzzy systems as C99 code."""
