"""Pages are opened in the user's browser."""

from __future__ import annotations

import os
import sys

SCREENS = ("DISPLAY", "WAYLAND_DISPLAY", "BROWSER")
"""Variables of which a desktop sets one, and who has a browser elsewhere the last one."""


def open_page(url: str) -> bool:
    """Show a page in the browser, and tell whether one was found.

    Without a screen none is looked for: one that runs in a terminal shows no robot, and would keep
    the terminal.
    """
    if sys.platform.startswith("linux") and not any(map(os.environ.get, SCREENS)):
        return False
    import webbrowser

    return webbrowser.open(url)
