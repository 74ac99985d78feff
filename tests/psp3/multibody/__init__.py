"""Tests of psp3.multibody, one file per module."""
