r"""Names in figures: a dollar begins no formula in them, and an underscore hides none.

Matplotlib sets ``$\foo$`` as mathematics, and raises where it is none; it leaves a label with an
underscore in front out of legends.
"""

from __future__ import annotations

from fuzzy2.errors import printable

_INVISIBLE = "\N{ZERO WIDTH SPACE}"


def literal(name: str) -> str:
    """Return a label that shows a name, or any text of others, letter by letter.

    Parameters
    ----------
    name : str
        A name of a term, a variable, a joint, a controller or a file.

    Returns
    -------
    str
        What matplotlib draws as the name; what no eye sees is written as its number, see
        :func:`fuzzy2.errors.printable`.
    """
    shown = printable(name).replace("$", r"\$")
    return _INVISIBLE + shown if shown.startswith("_") else shown
