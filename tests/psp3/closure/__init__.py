"""Tests of psp3.closure, one file per module."""
