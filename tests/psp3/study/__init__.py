"""Tests of psp3.study, one file per module."""
