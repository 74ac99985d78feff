"""Put a picture at the top of each notebook: one of what it shows, as it is before it is run.

Jupyter shows a notebook that it did not run itself without its drawings and 3D views; a picture in
a text is always there. Run by ``make pictures`` or ``python docs/pictures/make_openings.py``, after
the outputs of notebooks have changed; needs what :mod:`make_pictures` needs.
"""

from __future__ import annotations

import base64
import hashlib
import io
import json
import re
import tempfile
from itertools import pairwise
from pathlib import Path
from typing import Any

from make_pictures import RENDER_WITHOUT_A_SCREEN
from PIL import Image
from selenium import webdriver
from selenium.webdriver.chrome.service import Service

NOTEBOOKS = Path(__file__).parents[2] / "notebooks"

SHOWN = {
    "01": "3D view 1",
    "02": "Figure 1",
    "03": "Figure 2",
    "04": "3D view 1",
    "05": "Figure 2",
    "06": "Figure 1",
    "07": "3D view 1",
    "08": "Figure 2",
    "09": "Figure 3",
    "10": "Figure 1",
    "11": "3D view 1",
    "12": "Figure 2",
    "13": "Figure 2",
}
"""The caption of the output that each notebook opens with."""

IN_OTHER_WORDS = {
    # Every number of this notebook is compared with its source; here none is needed.
    "05": "Squared error of type-1 over that of type-2 against the noise, with intervals, for "
    "three learners and as printed. Above one, type-2 is better; where an interval includes one, "
    "nothing is shown.",
}

NAME, WIDTH, SCENE_HEIGHT, COLORS = "opening.png", 760, 400, 255

IS_DRAWN = """
const done = arguments[0];
const wait = () => requestAnimationFrame(() => requestAnimationFrame(() => setTimeout(done, 1500)));
document.readyState === "complete" ? wait() : addEventListener("load", wait);
"""


def output_of(cells: list[Any], caption: str) -> tuple[str, str, str]:
    """Return kind and content of the output above a caption, and its alternative text."""
    for cell, below in pairwise(cells):
        if cell["cell_type"] == "code" and "".join(below["source"]).startswith(f"*{caption}. "):
            for output in cell["outputs"]:
                for kind in ("image/svg+xml", "text/html"):
                    if kind in output.get("data", {}):
                        text = cell["metadata"]["mystnb"]["image"]["alt"]
                        content = "".join(output["data"][kind])
                        return kind, content, text.removeprefix(f"{caption}. ")
    raise SystemExit(f"no output above {caption}")


def png_of(browser: webdriver.Chrome, kind: str, content: str) -> bytes:
    """Return a drawing or a 3D view as the browser shows it."""
    if kind == "image/svg+xml":
        data = base64.b64encode(content.encode()).decode()
        content = (
            '<!doctype html><body style="margin:0"><img style="width:100%;display:block" '
            f'src="data:image/svg+xml;base64,{data}">'
        )
    else:
        content = f'<!doctype html><body style="margin:0">{content}'
    with tempfile.TemporaryDirectory() as folder:
        page = Path(folder) / "page.html"
        page.write_text(content, encoding="utf-8")
        size = {"width": WIDTH, "height": SCENE_HEIGHT, "deviceScaleFactor": 1, "mobile": False}
        browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
        browser.get(page.as_uri())
        browser.execute_async_script(IS_DRAWN)
        height = browser.execute_script(
            "return document.querySelector('img, iframe').getBoundingClientRect().height"
        )
        shot = browser.execute_cdp_cmd(
            "Page.captureScreenshot",
            {
                "format": "png",
                "captureBeyondViewport": True,
                "clip": {"x": 0, "y": 0, "width": WIDTH, "height": height, "scale": 1},
            },
        )
    picture = Image.open(io.BytesIO(base64.b64decode(shot["data"]))).convert("RGB")
    buffer = io.BytesIO()
    picture.quantize(COLORS, kmeans=4).save(buffer, "PNG", optimize=True)
    return buffer.getvalue()


def main() -> None:
    """Write the pictures into the notebooks."""
    options = webdriver.ChromeOptions()
    options.binary_location = "/usr/bin/chromium"
    for argument in RENDER_WITHOUT_A_SCREEN:
        options.add_argument(argument)
    browser = webdriver.Chrome(options=options, service=Service("/usr/bin/chromedriver"))
    for path in sorted(NOTEBOOKS.glob("*.ipynb")):
        notebook = json.loads(path.read_text(encoding="utf-8"))
        caption = SHOWN[path.name[:2]]
        kind, content, alt = output_of(notebook["cells"], caption)
        alt = re.sub(
            r"[\[\]]", "", IN_OTHER_WORDS.get(path.name[:2], alt.split(" Drag to turn")[0])
        )
        first = notebook["cells"][0]
        text = re.sub(r"\n\n!\[[^\]]*\]\([^)]*\)", "", "".join(first["source"]))
        heading, rest = text.split("\n", 1)
        first["source"] = f"{heading}\n\n![{alt}](attachment:{NAME})\n{rest}".splitlines(True)
        picture = base64.b64encode(png_of(browser, kind, content)).decode("ascii")
        first["attachments"] = {NAME: {"image/png": picture}}
        # By which a test tells whether the output is still the same.
        digest = hashlib.sha256(content.encode()).hexdigest()
        first["metadata"]["opening"] = {"shows": caption, "sha256": digest}
        path.write_text(json.dumps(notebook, ensure_ascii=False, indent=1) + "\n", encoding="utf-8")
    browser.quit()


if __name__ == "__main__":
    main()
