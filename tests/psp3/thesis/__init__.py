"""Tests of psp3.thesis, one file per module."""
