"""Tests of fuzzy2.files, one file per module."""
