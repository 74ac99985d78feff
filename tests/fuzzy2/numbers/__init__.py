"""Tests of fuzzy2.numbers, one file per module."""
