"""Tests of psp3.drives, one file per module."""
