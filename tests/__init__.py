"""Tests of both packages; run them with ``pytest`` from the root of the repository."""

from hypothesis import settings

# The first call of a compiled kernel takes up to seconds on a fresh machine, which is no property
# of the example at hand.
settings.register_profile("psp3", deadline=None)
settings.load_profile("psp3")
