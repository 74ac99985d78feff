"""Tests of both packages; run them with ``pytest`` from the root of the repository."""

from hypothesis import settings


def examples(number: int, of: int = 1) -> int:
    """Return how many examples a property that is tested for many cases gets in each of them.

    The cases share the number that one property has, but each gets 20 or more. Under the profile
    ``thorough`` each of them gets all.
    """
    if settings.default is settings.get_profile("thorough"):
        return number
    return min(number, max(20, number // of))
