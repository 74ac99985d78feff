"""Tests of psp3.three_psp, one file per module."""
