"""Tests of psp3.plots, one file per module."""
