"""Tests of psp3.cli.commands, one file per module."""
