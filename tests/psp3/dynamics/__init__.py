"""Tests of psp3.dynamics, one file per module."""
