"""Tests of psp3.kinematics, one file per module."""
