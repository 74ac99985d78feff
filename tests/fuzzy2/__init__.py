"""Tests of fuzzy2, one file per module."""
