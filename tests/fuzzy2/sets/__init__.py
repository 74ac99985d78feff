"""Tests of fuzzy2.sets, one file per module."""
