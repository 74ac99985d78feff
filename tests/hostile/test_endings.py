"""A few endings of each kind; many are ``python -m tests.hostile.endings 200 0``."""

from __future__ import annotations

import pytest

from tests.hostile.endings import KINDS, campaign


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_what_is_ended_at_any_moment_loses_nothing_beyond_what_is_stated(kind: str) -> None:
    """Three with SIGKILL and three with SIGINT, at moments of a fixed seed."""
    words = campaign(3, seed=1, kinds=(kind,))
    assert sum(words.values()) == 6
