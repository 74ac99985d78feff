"""Tests of psp3.cli, one file per module."""
