"""What tests of the 3D view share.

A page in a real browser, what it shows, and where it puts things.
"""

from __future__ import annotations

import base64
import io
import json
from pathlib import Path

import numpy as np
from PIL import Image
from selenium import webdriver

from psp3.visualize.scene import Scene, page

WIDTH, HEIGHT = 400, 312
"""Size of the page [pixels]: small, since it is rendered in software."""

SCREENSHOTS = Path(__file__).parents[1] / "results" / "screenshots"
"""Where pictures for people are kept; git ignores results/."""

PHONE, DESKTOP = (390, 844), (1440, 900)
SIZES = (PHONE, (800, 600), DESKTOP)
"""Windows in which pages are looked at [pixels]: of a phone, of a small and of a common screen."""

STICKING_OUT = """
document.querySelectorAll("details").forEach((one) => { one.open = true; });
const found = [], width = document.documentElement.clientWidth, range = document.createRange();
const words = (one) => one.textContent.trim().slice(0, 40);
const say = (what, one) => found.push(`${what}: <${one.tagName}> ${words(one)}`);
if (document.documentElement.scrollWidth > innerWidth) found.push("the page scrolls sideways");
for (const one of document.body.querySelectorAll("*")) {
  // MeshCat's own controls end a little beyond the stage.
  if (one.closest("script, style, .dg") || one.id === "stage") continue;
  const box = one.getBoundingClientRect();
  if (!box.width) continue;
  if (box.right > width + 1 || box.left < -1) say("beyond the window", one);
  if (one.clientWidth && one.scrollWidth > one.clientWidth + 1) say("cut or scrolled", one);
}
for (const cell of document.querySelectorAll("td, th, figcaption, .note")) {
  const box = cell.getBoundingClientRect();
  range.selectNodeContents(cell);
  for (const line of range.getClientRects())
    if (line.right > box.right + 1 || line.bottom > box.bottom + 1) say("over its edge", cell);
}
return [...new Set(found)];
"""

# The world of three.js has y up; the scene is turned into it.
PLACEMENT = """
const node = viewer.scene_tree.find(arguments[0]).object;
viewer.scene.updateMatrixWorld(true);
const matrix = viewer.scene.matrixWorld.clone().invert().multiply(node.matrixWorld);
return matrix.toArray();
"""


def set_size(browser: webdriver.Chrome, width: int, height: int) -> None:
    size = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False}
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)


def sticking_out(browser: webdriver.Chrome) -> list[str]:
    """Return what is cut, scrolls sideways or lies over its edge, with all of the page unfolded."""
    found: list[str] = browser.execute_script(STICKING_OUT)
    return found


def open_scene(
    browser: webdriver.Chrome, scene: Scene, width: int = WIDTH, height: int = HEIGHT
) -> None:
    """Show a scene at rest.

    In the page that is open if it is ours already, since loading MeshCat takes seconds.

    The page of a file differs from this one only in that its commands are written into it.
    """
    set_size(browser, width, height)
    browser.get_log("browser")
    if browser.execute_script("return window.fed") is not True:
        browser.get("about:blank")
        browser.execute_script(
            "document.open(); document.write(arguments[0]); document.close(); window.fed = true",
            page("[]"),
        )
    browser.execute_script(
        """viewer.delete_path(["meshcat", "robots"]);
        arguments[0].forEach(handle); animator.pause(); animator.seek(0); animator.time = 0;""",
        json.loads(scene._commands.as_json()),
    )
    settle(browser)


def open_file(browser: webdriver.Chrome, path: Path) -> None:
    """Open a file as people do."""
    set_size(browser, WIDTH, HEIGHT)
    browser.get_log("browser")
    browser.get(path.as_uri())


def settle(browser: webdriver.Chrome) -> None:
    """Stop the clock and let the page lay itself out.

    It sizes its picture in the next frame of the browser.
    """
    browser.execute_script("animator.pause()")
    browser.execute_async_script("requestAnimationFrame(() => requestAnimationFrame(arguments[0]))")


def wait_for(browser: webdriver.Chrome, condition: str) -> None:
    """Wait until an expression in JavaScript is true; it is looked at before each frame."""
    browser.execute_async_script(
        f"""const done = arguments[0];
        const look = () => ({condition}) ? done() : requestAnimationFrame(look);
        look();"""
    )


def picture_of(browser: webdriver.Chrome, name: str | None = None) -> bytes:
    """Return what is on the screen as PNG, and keep it for people if it has a name.

    The driver's own command for it gives a page 10 s to be drawn.
    """
    png = base64.b64decode(
        browser.execute_cdp_cmd("Page.captureScreenshot", {"format": "png"})["data"]
    )
    if name is not None:
        SCREENSHOTS.mkdir(parents=True, exist_ok=True)
        (SCREENSHOTS / f"{name}.png").write_bytes(png)
    return png


def screenshot(browser: webdriver.Chrome, name: str | None = None) -> np.ndarray:
    """Return what is on the screen, (height, width, 3), and keep it for people if it has a name.

    Not while the page plays: one that draws all the time may leave no time for it.
    """
    browser.execute_script("viewer.render()")
    png = picture_of(browser, name)
    return np.asarray(Image.open(io.BytesIO(png)).convert("RGB")).astype(int)


def changed_pixels(browser: webdriver.Chrome, *paths: str) -> np.ndarray:
    """Where something is: the pixels that change when it is hidden, shadows aside."""
    set_visible = (
        "for (const name of arguments[0]) viewer.scene_tree.find(name).object.visible = "
        "arguments[1]"
    )
    nodes = [["meshcat", *path.split("/")] for path in paths]
    browser.execute_script("light.castShadow = false")
    shown = screenshot(browser)
    browser.execute_script(set_visible, nodes, False)
    hidden = screenshot(browser)
    browser.execute_script(set_visible, nodes, True)
    browser.execute_script("light.castShadow = true")
    return np.abs(shown - hidden).max(axis=-1) > 12


def placement(browser: webdriver.Chrome, *path: str) -> np.ndarray:
    """Homogeneous transform of a node in base axes, as the browser has it."""
    return np.array(browser.execute_script(PLACEMENT, list(path))).reshape(4, 4).T


def star_center(browser: webdriver.Chrome, robot: int = 0) -> np.ndarray:
    return placement(browser, "meshcat", "robots", str(robot), "visuals", "b1")[:3, 3]


def complaints(browser: webdriver.Chrome) -> list[str]:
    """Errors and warnings on the console, but for a software renderer's remarks on its speed."""
    entries = [
        entry["message"]
        for entry in browser.get_log("browser")
        if entry["level"] in ("SEVERE", "WARNING")
    ]
    return [message for message in entries if "GL Driver Message" not in message]
