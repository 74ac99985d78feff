"""Tests of the package psp3.symbolic."""
