"""Tests of psp3.collisions, one file per module."""
