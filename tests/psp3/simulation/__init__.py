"""Tests of psp3.simulation, one file per module."""
