"""A text that is read, whose errors name the line."""

from __future__ import annotations

from fuzzy2.errors import MalformedFile, NotExpressible


class Source:
    """What readers of all formats share.

    Parameters
    ----------
    name : str
        What error messages call the text.
    """

    def __init__(self, name: str) -> None:
        self.source = name

    def malformed(self, line: int, reason: str) -> MalformedFile:
        """Return the error of a line that is not of the format."""
        return MalformedFile(self.source, f"line {line}", reason)

    def refused(self, line: int, what: str, reason: str) -> NotExpressible:
        """Return the error of a line that describes what a system here cannot be."""
        return NotExpressible(f"{self.source}, line {line}: {what}", "fuzzy2", reason)
