"""The scene in a browser that follows what is done to it, served to this machine only.

MeshCat's own server is not used because it listens on all network interfaces.
"""

from __future__ import annotations

import queue
import threading
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from types import TracebackType
from typing import Any

from psp3.checks import checked_count
from psp3.errors import InvalidValue
from psp3.robots.robot import Robot
from psp3.visualize.commands import DrawingCommands
from psp3.visualize.scene import Scene, page

LAST_PORT = 65535


class _Server(ThreadingHTTPServer):
    """Serves the page and its commands.

    The commands are server-sent events, on one long connection to each browser.
    """

    daemon_threads = True

    def __init__(self, port: int, commands: DrawingCommands) -> None:
        super().__init__(("127.0.0.1", port), _Handler)
        self.commands = commands


class _Handler(BaseHTTPRequestHandler):
    server: _Server

    def do_GET(self) -> None:
        if self.path == "/":
            self._answer("text/html; charset=utf-8")
            self.wfile.write(page("listen();").encode())
        elif self.path == "/commands":
            self._answer("text/event-stream")
            self._stream()
        else:
            self.send_error(404)

    def _answer(self, content_type: str) -> None:
        self.send_response(200)
        self.send_header("Content-Type", content_type)
        self.send_header("Cache-Control", "no-store")
        self.end_headers()

    def _stream(self) -> None:
        commands = self.server.commands.subscribe()
        try:
            while True:
                try:
                    text = commands.get(timeout=10.0)
                except queue.Empty:
                    # A comment, by which a browser that has left is noticed.
                    self.wfile.write(b":\n\n")
                    continue
                if text is None:
                    self.wfile.write(b'data: {"type":"end"}\n\n')
                    return
                self.wfile.write(f"data: {text}\n\n".encode())
        except ConnectionError:
            return
        finally:
            self.server.commands.unsubscribe(commands)

    def log_message(self, format: str, *args: Any) -> None:
        """Print nothing: the library never does."""


class Viewer(Scene):
    """A scene in the browser that follows what is done to it, served to this machine only.

    Use it as a context manager, or call :meth:`close`.

    Parameters
    ----------
    robot : robot from :func:`psp3.load`
        What to show.
    port : int
        Port to listen on, up to 65535; if it is taken, the next one that is free.

    Attributes
    ----------
    url : str
        What to open in the browser.

    Raises
    ------
    InvalidValue
        If there is no such port.
    """

    def __init__(self, robot: Robot, port: int = 7000) -> None:
        super().__init__(robot)
        self._server = self._listen(port)
        self.url = f"http://127.0.0.1:{self._server.server_port}/"
        self._thread = threading.Thread(
            target=self._server.serve_forever, kwargs={"poll_interval": 0.05}, daemon=True
        )
        self._thread.start()

    def _listen(self, port: int) -> _Server:
        if checked_count("port", port, 0) > LAST_PORT:
            raise InvalidValue("port", port, f"from 0 to {LAST_PORT}")
        for candidate in range(port, min(port + 100, LAST_PORT + 1)):
            try:
                return _Server(candidate, self._commands)
            except OSError:
                continue
        any_free_port = 0
        return _Server(any_free_port, self._commands)

    def close(self) -> None:
        """Stop serving and free the port; the page in the browser keeps its last picture."""
        self._commands.end()
        self._server.shutdown()
        self._server.server_close()
        self._thread.join()

    def __enter__(self) -> Viewer:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()
