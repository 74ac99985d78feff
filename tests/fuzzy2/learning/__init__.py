"""Tests of fuzzy2.learning, one file per module."""
