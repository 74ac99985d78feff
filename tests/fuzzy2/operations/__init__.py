"""Tests of fuzzy2.operations, one file per module."""
