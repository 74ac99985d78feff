"""Tests of fuzzy2.systems, one file per module."""
