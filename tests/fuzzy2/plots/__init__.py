"""Tests of fuzzy2.plots, one file per module."""
