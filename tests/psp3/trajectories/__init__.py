"""Tests of psp3.trajectories, one file per module."""
