"""Draw the badges of the README anew, from ``pyproject.toml``.

Run by ``make pictures``, or ``python docs/pictures/make_badges.py``. They are files of the
repository, so that no page asks a server for them, and a test compares them with what they say.
"""

from __future__ import annotations

import tomllib
from pathlib import Path

HERE = Path(__file__).resolve().parent
PROJECT = tomllib.loads((HERE.parents[1] / "pyproject.toml").read_text(encoding="utf-8"))["project"]

WIDTH_OF_A_LETTER, MARGIN = 7, 6  # [px]

BADGE = """\
<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="20" role="img" aria-label="{name}: {value}">
<title>{name}: {value}</title>
<rect width="{width}" height="20" rx="3" fill="#444"/>
<path d="M{split} 0h{rest}a3 3 0 0 1 3 3v14a3 3 0 0 1-3 3h-{rest}z" fill="#0b5c8a"/>
<g fill="#fff" font-family="Verdana,DejaVu Sans,sans-serif" font-size="11" text-anchor="middle">
<text x="{left}" y="14">{name}</text>
<text x="{right}" y="14">{value}</text>
</g>
</svg>
"""  # noqa: E501


def badges() -> dict[str, str]:
    """Return what the badges say: a value by its name."""
    return {
        "python": PROJECT["requires-python"].replace(">=", "≥ "),
        "license": PROJECT["license"],
        "version": PROJECT["version"],
    }


def drawn(name: str, value: str) -> str:
    """Return the SVG of a badge: its name on dark gray and its value on blue."""
    split, rest = (WIDTH_OF_A_LETTER * len(text) + 2 * MARGIN for text in (name, value))
    return BADGE.format(
        name=name,
        value=value,
        width=split + rest,
        split=split,
        rest=rest - 3,
        left=split / 2,
        right=split + rest / 2,
    )


if __name__ == "__main__":
    for name, value in badges().items():
        (HERE / f"badge_{name}.svg").write_text(drawn(name, value), encoding="utf-8")
