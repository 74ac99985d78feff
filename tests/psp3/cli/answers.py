"""Answers of the command line."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any, NamedTuple, NoReturn


class Answer(NamedTuple):
    """What a command gave back."""

    status: int
    out: str
    err: str

    @property
    def json(self) -> Any:
        """Standard output, which must be strict JSON and nothing else."""
        return json.loads(self.out, parse_constant=self._refuse)

    @staticmethod
    def _refuse(constant: str) -> NoReturn:
        raise AssertionError(f"{constant} is not JSON")


Run = Callable[..., Answer]


def words(text: str) -> str:
    """Return a text as one line, however it was broken."""
    return " ".join(text.split())
