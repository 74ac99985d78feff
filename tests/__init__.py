"""Tests of both packages; run them with ``pytest`` from the root of the repository."""
