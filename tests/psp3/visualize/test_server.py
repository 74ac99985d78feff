"""The server of a scene: whom it answers, and that nobody can hold it up."""

from __future__ import annotations

import http.client
import select
import socket
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from selenium import webdriver

import psp3
from psp3.visualize import Viewer, server

ROBOT = psp3.load("five_bar")


@pytest.fixture
def viewer() -> Iterator[Viewer]:
    with Viewer(ROBOT, 0) as viewer:
        viewer.show(ROBOT.reference)
        yield viewer


def port_of(viewer: Viewer) -> int:
    return int(viewer._server.server_port)


def connected(viewer: Viewer) -> socket.socket:
    return socket.create_connection(("127.0.0.1", port_of(viewer)))


def status(viewer: Viewer, path: str, *headers: tuple[str, str], method: str = "GET") -> int:
    connection = http.client.HTTPConnection("127.0.0.1", port_of(viewer))
    connection.putrequest(method, path, skip_host=True)
    for name, value in headers:
        connection.putheader(name, value)
    connection.endheaders()
    answer = connection.getresponse()
    connection.close()
    return answer.status


@pytest.mark.parametrize("path", ["/", "/commands"])
@pytest.mark.parametrize(
    "hosts",
    [
        (),
        ("evil.example",),
        ("evil.example:{port}",),
        ("127.0.0.1.evil.example:{port}",),
        ("localhost.evil.example",),
        ("localhost:{port}", "evil.example"),
        ("[::1]:{port}",),
        ("",),
    ],
)
def test_under_another_name_nothing_is_served(
    viewer: Viewer, path: str, hosts: tuple[str, ...]
) -> None:
    """A name of others that leads to this machine is how their pages would read the scene."""
    headers = [("Host", host.format(port=port_of(viewer))) for host in hosts]
    assert status(viewer, path, *headers) == 403


@pytest.mark.parametrize("host", ["127.0.0.1:{port}", "localhost:{port}", "LocalHost:8000"])
def test_names_of_this_machine_are_served_from_any_port(viewer: Viewer, host: str) -> None:
    """The browser's end of a tunnel has another port."""
    name = host.format(port=port_of(viewer))
    assert status(viewer, "/", ("Host", name)) == 200
    assert status(viewer, "/commands", ("Host", name), ("Origin", f"http://{name}")) == 200


@pytest.mark.parametrize(
    "headers",
    [
        [("Origin", "http://evil.example")],
        [("Origin", "null")],
        [("Origin", "http://localhost:1")],
        [("Sec-Fetch-Site", "cross-site")],
        [("Sec-Fetch-Site", "same-site")],
    ],
)
def test_pages_of_others_do_not_get_the_commands(
    viewer: Viewer, headers: list[tuple[str, str]]
) -> None:
    host = ("Host", f"127.0.0.1:{port_of(viewer)}")
    assert status(viewer, "/commands", host, *headers) == 403
    assert status(viewer, "/", host, ("Sec-Fetch-Site", "cross-site")) == 200, "a link to it"


@pytest.mark.parametrize("method", ["POST", "PUT", "DELETE", "OPTIONS", "HEAD"])
def test_nothing_but_reading_is_understood(viewer: Viewer, method: str) -> None:
    host = ("Host", f"127.0.0.1:{port_of(viewer)}")
    assert status(viewer, "/", host, method=method) == 501


def test_a_request_that_trickles_in_is_given_up(
    viewer: Viewer, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A byte now and then: the time is that of the request, not between two bytes."""
    monkeypatch.setattr(server, "PATIENCE", 0.5)
    with connected(viewer) as slow:
        slow.settimeout(0.05)
        started, sent = time.monotonic(), 0
        while time.monotonic() - started < 60.0:
            try:
                slow.send(b"GET / HTTP/1.1\r\nX: "[sent : sent + 1] or b"a")
                sent += 1
                if slow.recv(1) == b"":
                    break
            except TimeoutError:
                continue
            except ConnectionError:
                break
        assert 0.4 < time.monotonic() - started < 30.0
        assert sent > 3


def test_connections_are_bounded_and_their_places_come_free(
    viewer: Viewer, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(server, "PATIENCE", 3600.0)
    idle = [connected(viewer) for _ in range(3 * server.CONNECTIONS)]
    refused: list[socket.socket] = []
    # Those above the bound are closed without an answer, and so can be read; the others wait.
    while len(refused) < 2 * server.CONNECTIONS:
        refused = select.select(idle, [], [], 1.0)[0]
    assert len(viewer._server._open) == server.CONNECTIONS
    for one in idle:
        one.close()
    host = ("Host", f"127.0.0.1:{port_of(viewer)}")
    while viewer._server._open:
        time.sleep(0.01)
    assert status(viewer, "/", host) == 200


def test_browsers_that_leave_or_send_garbage_are_not_spoken_of(
    viewer: Viewer, capfd: pytest.CaptureFixture[str]
) -> None:
    for request in (
        b"",
        b"\x16\x03\x01\x02\x00\x01\x00\x01",
        b"GET / HTTP/1.1\r\nHost: localhost\r\n\r\n",
        b"GET /commands HTTP/1.1\r\nHost: localhost\r\n\r\n",
        b"GET / HTTP/9\r\n\r\n",
        b"G" * 100_000,
        b"GET / HTTP/1.1\r\n" + b"a: b\r\n" * 1000,
    ):
        with connected(viewer) as leaving:
            # An answer that comes after this is a connection reset.
            leaving.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, b"\1\0\0\0\0\0\0\0")
            leaving.sendall(request)
    for n in range(200):
        viewer._commands.add({"type": "nothing", "path": str(n)})
    while viewer._server._open:
        viewer._commands.add({"type": "nothing"})
        time.sleep(0.01)
    assert capfd.readouterr() == ("", "")


def test_a_browser_that_does_not_read_does_not_hold_up_the_end(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(server, "GRACE", 0.2)
    viewer = Viewer(ROBOT, 0)
    with connected(viewer) as stalled:
        stalled.sendall(b"GET /commands HTTP/1.1\r\nHost: localhost\r\n\r\n")
        assert stalled.recv(15) == b"HTTP/1.0 200 OK"
        # More than buffers of the system hold.
        for n in range(64):
            viewer._commands.add({"type": "nothing", "path": str(n), "text": "a" * 10**6})
        before = set(threading.enumerate())
        viewer.close()
        viewer.close()
    left = before - set(threading.enumerate())
    assert viewer._server._open == {}
    assert len(left) >= 2, "the one that serves and that of the browser"


def test_a_page_of_others_cannot_read_the_scene(
    browser: webdriver.Chrome, viewer: Viewer, tmp_path: Path
) -> None:
    """By fetch and by EventSource in a real browser; our own page can."""
    attempts = """
    const done = arguments[1], url = arguments[0];
    const found = {};
    const asked = [
      fetch(url).then((answer) => answer.body.getReader().read())
        .then(() => "read", () => "refused").then((said) => found.fetch = said),
      new Promise((next) => {
        const source = new EventSource(url);
        source.onmessage = () => { found.events = "read"; source.close(); next(); };
        source.onerror = () => { found.events = "refused"; source.close(); next(); };
      }),
    ];
    Promise.all(asked).then(() => done(found));
    """
    page = tmp_path / "other.html"
    page.write_text("<title>Other</title>", encoding="utf-8")
    url = f"http://127.0.0.1:{port_of(viewer)}/commands"
    browser.get(page.as_uri())
    assert browser.execute_async_script(attempts, url) == {"fetch": "refused", "events": "refused"}
    browser.get(viewer.url)
    assert browser.execute_async_script(attempts, url) == {"fetch": "read", "events": "read"}
