"""Tests of psp3.export, one file per module."""
