"""Tests of psp3.fuzzy_control, one file per module."""
