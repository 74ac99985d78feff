"""Tests of :mod:`fuzzy2.export`."""
