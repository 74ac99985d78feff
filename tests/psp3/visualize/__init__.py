"""Tests of psp3.visualize, one file per module."""
