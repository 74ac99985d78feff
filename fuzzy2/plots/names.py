r"""Names in figures, protected from matplotlib's special characters.

Matplotlib typesets ``$\foo$`` as mathematics and raises an error if it cannot be parsed, and it
leaves labels that begin with an underscore out of legends.
"""

from __future__ import annotations

from fuzzy2.errors import printable

_INVISIBLE = "\N{ZERO WIDTH SPACE}"


def literal(name: str) -> str:
    """Return a label that shows a name, or any other text, letter by letter.

    Parameters
    ----------
    name : str
        A name of a term, a variable, a joint, a controller or a file.

    Returns
    -------
    str
        A text that matplotlib draws as the name. Invisible characters are written as their numbers,
        see :func:`fuzzy2.errors.printable`.
    """
    shown = printable(name).replace("$", r"\$")
    return _INVISIBLE + shown if shown.startswith("_") else shown
