"""Tests of psp3.control, one file per module."""
