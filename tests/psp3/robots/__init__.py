"""Tests of psp3.robots, one file per module."""
