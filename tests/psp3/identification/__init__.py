"""Tests of psp3.identification, one file per module."""
