"""Cut the picture of all robots into one thumbnail for each.

Run by ``make pictures`` after ``make_pictures.py``, or ``python docs/pictures/make_thumbnails.py``.
"""

from __future__ import annotations

from pathlib import Path

from PIL import Image

from psp3.description.parts import ROBOTS

HERE = Path(__file__).resolve().parent
ROW, ROWS = 6, 2


def main() -> None:
    """Write ``robots/NAME.png`` beside this file, in the order of the picture."""
    whole = Image.open(HERE / "robots.png").convert("RGB")
    width, height = whole.width / ROW, whole.height / ROWS
    (HERE / "robots").mkdir(exist_ok=True)
    for number, name in enumerate(ROBOTS):
        left, top = number % ROW * width, number // ROW * height
        tile = whole.crop((round(left), round(top), round(left + width), round(top + height)))
        tile.quantize(64).save(HERE / "robots" / f"{name}.png", optimize=True)


if __name__ == "__main__":
    main()
