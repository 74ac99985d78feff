"""Tests of psp3.description, one file per module."""
