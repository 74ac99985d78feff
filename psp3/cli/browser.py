"""Open pages in the user's browser."""

from __future__ import annotations

import os
import sys

SCREENS = ("DISPLAY", "WAYLAND_DISPLAY", "BROWSER")
"""Environment variables: a desktop sets one of the first, and users with a browser elsewhere set
the last."""


def open_page(url: str) -> bool:
    """Show a page in the browser, and return whether a browser was found.

    Without a screen no browser is opened: one that runs in the terminal cannot show the robot, and
    would block the terminal.
    """
    if sys.platform.startswith("linux") and not any(map(os.environ.get, SCREENS)):
        return False
    import webbrowser

    return webbrowser.open(url)
