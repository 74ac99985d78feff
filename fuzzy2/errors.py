"""Errors and warnings that this package raises on purpose.

Each error carries the values that caused it, and its message says what to do. Messages can quote
names read from foreign files; :func:`printable` makes any text safe to show.
"""

from __future__ import annotations

import errno
import re
from collections.abc import Sequence
from typing import Any, Self

import numpy as np

_UNSEEN = re.compile(
    # Control characters except newline and tab: escape sequences, bell, carriage return.
    "[\x00-\x08\x0b-\x1f\x7f-\x9f"
    # Characters that change the direction of writing, that join nothing, or that only some readers
    # treat as line ends. The joiners U+200C and U+200D stay because Persian and emoji need them.
    "\u00ad\u061c\u180e\u200b\u200e\u200f\u2028-\u202e\u2060-\u206f\ufeff\ufff9-\ufffb"
    # Lone surrogates, which occur in file names that are not UTF-8, and tag characters.
    "\ud800-\udfff\U000e0000-\U000e007f]"
)


def printable(text: str) -> str:
    r"""Return a text with every control or invisible character written as its number.

    Names come from foreign files. An escape sequence in a name could clear a terminal or overwrite
    its text, and a direction mark could reorder the text around it.

    Parameters
    ----------
    text : str
        Any text. Its line breaks and tabs are kept.

    Returns
    -------
    str
        The text, with escapes such as ``\x1b``, ``\u202e`` or ``\U000e0041`` for those characters.
    """
    return _UNSEEN.sub(lambda found: _number_of(found[0]), text)


def _number_of(character: str) -> str:
    code = ord(character)
    width, mark = next(
        (width, mark) for width, mark in ((2, "x"), (4, "u"), (8, "U")) if code < 16**width
    )
    return f"\\{mark}{code:0{width}x}"


class RaisedOnPurpose(BaseException):
    """Base of the errors and warnings of this package and of packages that build on it.

    They can be pickled, so they cross process boundaries intact. Their messages can quote foreign
    names, so they are made safe for a terminal with :func:`printable`.
    """

    _arguments: tuple[Any, ...]

    def __new__(cls, *arguments: Any) -> Self:
        """Keep the arguments, from which a pickled error is rebuilt."""
        error = super().__new__(cls, *arguments)
        error._arguments = arguments
        return error

    def __reduce__(self) -> tuple[type[RaisedOnPurpose], tuple[Any, ...]]:
        return type(self), self._arguments

    def __str__(self) -> str:
        return printable(super().__str__())


def in_words(value: object) -> str:
    """Return the representation of a value on one line, or its type if it has none."""
    try:
        return " ".join(repr(value)[:120].split())
    except Exception:  # e.g. integers of thousands of digits, or a failing __repr__
        return f"a {type(value).__name__} that cannot be shown"


class Fuzzy2Error(RaisedOnPurpose, Exception):
    """Base of every error this package raises on purpose."""


class UnknownName(Fuzzy2Error, ValueError):
    """A name is not among the known ones."""

    def __init__(self, kind: str, name: object, known: Sequence[str]) -> None:
        self.name, self.known = name, tuple(known)
        super().__init__(f"unknown {kind} {in_words(name)}; known are {', '.join(known)}")


class InvalidValue(Fuzzy2Error, ValueError):
    """An argument has an invalid value."""

    def __init__(self, name: str, value: object, requirement: str) -> None:
        self.name, self.value = name, value
        super().__init__(f"{name} must be {requirement}, got {self._shown(value)}")

    @staticmethod
    def _shown(value: object) -> str:
        # array2string would show the values below a mask, which nobody gave.
        if isinstance(value, np.ndarray) and not isinstance(value, np.ma.MaskedArray):
            return np.array2string(value, threshold=12)
        return in_words(value)


class NotApplicable(Fuzzy2Error, ValueError):
    """A theorem or a shortcut was requested where its conditions do not hold."""

    def __init__(self, what: str, reason: str) -> None:
        self.what, self.reason = what, reason
        super().__init__(f"{what} does not apply: {reason}")


class ReadOnly(Fuzzy2Error, AttributeError):
    """An attribute of an immutable object was about to be set."""

    def __init__(self, what: str, name: str) -> None:
        self.what, self.name = what, name
        super().__init__(
            f"{what} cannot be changed once it is made, so its {name} cannot be set: make another "
            f"with replace({name}=...)"
        )


class InvalidRule(Fuzzy2Error, ValueError):
    """A rule cannot be parsed, or does not match the variables."""

    def __init__(self, number: int, text: str, reason: str) -> None:
        self.number, self.text, self.reason = number, text, reason
        super().__init__(f"rule {number} ({text}) {reason}")


class MalformedFile(Fuzzy2Error, ValueError):
    """A file violates its format.

    ``place`` is the line number, or the path within the document.
    """

    def __init__(self, source: str, place: str, reason: str) -> None:
        self.source, self.place, self.reason = source, place, reason
        super().__init__(f"{source}, {place}: {reason}")


class FileNotWritten(Fuzzy2Error, OSError):
    """A file cannot be written.

    It is also an ``OSError``, with ``errno``, ``strerror`` and ``filename``.
    """

    def __init__(self, number: int, reason: str, path: str) -> None:
        self.errno, self.strerror, self.filename = number, reason, path

    def __str__(self) -> str:
        remedy = _REMEDIES.get(self.errno or 0, "give another place")
        return f"{self.filename}: {self.strerror}; {remedy}"


_FREE_SPACE = "free space on its disk, or give another place"
_ALLOWED = "allow writing to it and its folder, or give another place"
_REMEDIES = {
    errno.ENOSPC: _FREE_SPACE,
    errno.EDQUOT: _FREE_SPACE,
    errno.EFBIG: "raise the largest size of a file (ulimit -f), or give another place",
    errno.EACCES: _ALLOWED,
    errno.EPERM: _ALLOWED,
    errno.EROFS: "its file system is read-only; give another place",
    errno.ENOENT: "make the folder first",
    errno.ENOTDIR: "a part of the path is a file, not a folder; give another one",
    errno.EISDIR: "it is a folder; give the name of a file in it",
    errno.ENAMETOOLONG: "give a shorter name",
}


class NotExpressible(Fuzzy2Error, ValueError):
    """A file format cannot represent something, or this package cannot represent a file."""

    def __init__(self, what: str, where: str, reason: str) -> None:
        self.what, self.where, self.reason = what, where, reason
        super().__init__(f"{what} cannot be expressed in {where}: {reason}")


class NotExportable(Fuzzy2Error, ValueError):
    """Something cannot be translated to C."""

    def __init__(self, what: str, why: str, remedy: str) -> None:
        self.what, self.why, self.remedy = what, why, remedy
        super().__init__(f"{what} cannot be written in C: {why}; give {remedy}")


class FileInTheWay(Fuzzy2Error, ValueError):
    """A file of the user's is in the place where an export would write."""

    def __init__(self, path: str) -> None:
        self.path = path
        super().__init__(
            f"{path} exists and was not left there by an export; nothing was written: move or "
            "delete it, or name another folder"
        )


class TooManyEmbeddedSets(Fuzzy2Error, ValueError):
    """Enumerating the embedded sets would take unreasonably long."""

    def __init__(self, count: int, limit: int) -> None:
        self.count, self.limit = count, limit
        super().__init__(
            f"there are {count:,} embedded sets, and at most {limit:,} are enumerated; "
            "take fewer points or coarser secondary sets, or reduce by alpha-planes"
        )


class ApproximationWarning(RaisedOnPurpose, UserWarning):
    """An approximation is used outside the range where it is close.

    See :mod:`fuzzy2.reduction.approximate`.
    """

    def __init__(self, what: str, validity: float, limit: float) -> None:
        self.what, self.validity, self.limit = what, validity, limit
        super().__init__(
            f"{what} has a validity measure of {validity:.3g}, above {limit:g}: the approximate "
            "type-reduced set may be far from the exact one; reduce by alpha-planes, or use "
            "narrower type-2 sets"
        )


class DefaultReductionWarning(RaisedOnPurpose, UserWarning):
    """Rules in words conclude sets and are reduced with the default, which is not the centroid."""

    def __init__(self) -> None:
        super().__init__(
            "the rules conclude sets, and the output is the average of the sets' centroids "
            "(type_reduction='center_of_sets', the default); Mamdani's is the centroid of the "
            "sets' union (type_reduction='centroid'): name the one you mean"
        )


class NotNumbers(Fuzzy2Error, TypeError):
    """Samples have a type that cannot be read as a table of numbers."""

    def __init__(self, name: str, reason: str) -> None:
        self.name, self.reason = name, reason
        super().__init__(f"{name} cannot be read as numbers: {reason}")


class UnsupportedRule(Fuzzy2Error, ValueError):
    """No sample determines the consequent of a rule of the grid."""

    def __init__(
        self,
        number: int,
        text: str,
        firing: float,
        least: float,
        count: int,
        remedy: str = "add samples there, use fewer terms, or another completion than 'refuse'",
    ) -> None:
        self.number, self.text, self.firing, self.least, self.count = (
            number,
            text,
            firing,
            least,
            count,
        )
        self.remedy = remedy
        super().__init__(
            f"no sample fires rule {number} (IF {text}) more strongly than {firing:.3g}, and at "
            f"least {least:g} is needed ({count} such rules); {remedy}"
        )


class CompletedRules(RaisedOnPurpose, UserWarning):
    """Some rules of a grid have no samples and took their consequents from their neighbors."""

    def __init__(self, count: int, total: int, completion: str) -> None:
        self.count, self.total, self.completion = count, total, completion
        done = "left out" if completion == "none" else "completed from other rules"
        super().__init__(
            f"{count} of {total} rules are not fired noticeably by any sample and were {done} "
            f"(completion={completion!r}); completion='refuse' makes that an error"
        )


class NotFitted(Fuzzy2Error, ValueError, AttributeError):
    """An estimator is used before it is fitted."""

    def __init__(self, estimator: str) -> None:
        self.estimator = estimator
        super().__init__(f"this {estimator} is not fitted yet: call fit first")


class WrongFeatures(Fuzzy2Error, ValueError):
    """The inputs have different columns from those that the estimator was fitted with."""

    def __init__(
        self,
        estimator: str,
        expected: int,
        given: int,
        expected_names: Sequence[str] = (),
        given_names: Sequence[str] = (),
    ) -> None:
        self.estimator, self.expected, self.given = estimator, expected, given
        self.expected_names, self.given_names = tuple(expected_names), tuple(given_names)
        if not given_names:
            super().__init__(
                f"X has {given} features, but {estimator} is expecting {expected} features as input"
            )
            return
        lines = ["The feature names should match those that were passed during fit."]
        unseen = sorted(set(given_names) - set(expected_names))
        missing = sorted(set(expected_names) - set(given_names))
        if unseen:
            lines += ["Feature names unseen at fit time:", *(f"- {name}" for name in unseen)]
        if missing:
            lines += [
                "Feature names seen at fit time, yet now missing:",
                *(f"- {name}" for name in missing),
            ]
        if not unseen and not missing:
            lines.append("Feature names must be in the same order as they were in fit.")
        super().__init__("\n".join(lines) + "\n")


class FeatureNamesWarning(RaisedOnPurpose, UserWarning):
    """The inputs have column names but the estimator was fitted without, or the reverse."""

    def __init__(self, estimator: str, was_fitted_with_names: bool) -> None:
        self.estimator, self.was_fitted_with_names = estimator, was_fitted_with_names
        if was_fitted_with_names:
            super().__init__(
                f"X does not have valid feature names, but {estimator} was fitted with feature "
                "names"
            )
        else:
            super().__init__(
                f"X has feature names, but {estimator} was fitted without feature names"
            )


class UnansweredInC(RaisedOnPurpose, UserWarning):
    """The exported code of a system has no answer at some inputs where the system has one."""

    def __init__(self, name: str, count: int, total: int) -> None:
        self.name, self.count, self.total = name, count, total
        super().__init__(
            f"the code of {name!r} returns 0 and writes NaN at {count} of {total} inputs within "
            "the ranges, where exact unions of the output sets need more pieces than the code has "
            "room for; integration='sum' with a resolution has an answer everywhere"
        )


class CodeNotKept(RaisedOnPurpose, UserWarning):
    """Compiled code is missing from the disk, or is damaged."""

    def __init__(self, folder: str, why: str) -> None:
        self.folder, self.why = folder, why
        super().__init__(
            f"code is compiled again, which takes a while: {why}: {folder}; if this warning comes "
            "back, delete that folder, make room on its disk, or name another one in "
            "NUMBA_CACHE_DIR"
        )
