"""Tests of psp3, one file per module."""
