"""Source text with errors that name the line."""

from __future__ import annotations

from fuzzy2.errors import MalformedFile, NotExpressible


class Source:
    """Common base of the readers of all formats.

    Parameters
    ----------
    name : str
        Name of the text in error messages.
    """

    def __init__(self, name: str) -> None:
        self.source = name

    def malformed(self, line: int, reason: str) -> MalformedFile:
        """Return the error of a line that violates the format."""
        return MalformedFile(self.source, f"line {line}", reason)

    def refused(self, line: int, what: str, reason: str) -> NotExpressible:
        """Return the error of a line that this package cannot represent."""
        return NotExpressible(f"{self.source}, line {line}: {what}", "fuzzy2", reason)
