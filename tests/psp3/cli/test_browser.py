"""The browser is opened where there is one with a screen."""

from __future__ import annotations

import pytest

from psp3.cli import browser


@pytest.mark.parametrize(
    ("variable", "looked_for"), [("", False), *((one, True) for one in browser.SCREENS)]
)
def test_a_browser_is_looked_for_on_a_screen_only(
    monkeypatch: pytest.MonkeyPatch, variable: str, looked_for: bool
) -> None:
    for name in browser.SCREENS:
        monkeypatch.delenv(name, raising=False)
    if variable:
        monkeypatch.setenv(variable, "anything")
    asked = []
    monkeypatch.setattr("sys.platform", "linux")
    monkeypatch.setattr("webbrowser.open", lambda url: asked.append(url) or True)
    assert browser.open_page("http://127.0.0.1:1/") is looked_for
    assert asked == ["http://127.0.0.1:1/"] * looked_for
