"""Tests of fuzzy2.reduction, one file per module."""
