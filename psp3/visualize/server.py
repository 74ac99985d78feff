"""The server of a scene: one page and its commands, for browsers on this machine only.

MeshCat's own server is not used because it listens on all network interfaces.

Foreign pages run in the same browsers, and can send requests to this machine. Three attacks are
blocked: reading the scene under a foreign name that resolves to this machine (DNS rebinding, which
shows in ``Host``), requests from other sites (``Origin``, ``Sec-Fetch-Site``), and using up all
connections or keeping one busy forever.
"""

from __future__ import annotations

import io
import queue
import socket
import sys
import threading
import time
from contextlib import suppress
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any

from psp3.visualize.commands import DrawingCommands
from psp3.visualize.scene import page

ADDRESS = "127.0.0.1"

HOSTS = frozenset({ADDRESS, "localhost"})
"""Names of this machine. Any port is accepted, because a tunnel may begin at another one."""

CONNECTIONS = 32
"""Greatest number of open connections; a browser takes one for each page, and at most six."""

PATIENCE = 10.0
"""Time limit for a request to arrive, and for a piece of the answer to be sent [s]."""

GRACE = 1.0
"""Time for browsers to receive the rest of the scene when the server closes [s]."""

BEAT = 10.0
"""Time between keep-alive messages, which detect a browser that has left [s]."""


class SceneServer(ThreadingHTTPServer):
    """A server of the page and its commands.

    The commands are server-sent events, on one long connection to each browser.

    Parameters
    ----------
    port : int
        Port to listen on; 0 for any that is free.
    commands : DrawingCommands
        The scene.

    Raises
    ------
    OSError
        If the port is taken.
    """

    daemon_threads = True
    request_queue_size = CONNECTIONS

    def __init__(self, port: int, commands: DrawingCommands) -> None:
        self.commands = commands
        self._lock = threading.Lock()
        self._open: dict[Any, threading.Thread] = {}
        super().__init__((ADDRESS, port), _Handler)

    def process_request(self, request: Any, client_address: Any) -> None:
        """Answer a request in a thread of its own, if there are not too many."""
        thread = threading.Thread(
            target=self.process_request_thread, args=(request, client_address), daemon=True
        )
        with self._lock:
            room = len(self._open) < CONNECTIONS
            if room:
                self._open[request] = thread
        if room:
            thread.start()
        else:
            self.shutdown_request(request)

    def shutdown_request(self, request: Any) -> None:
        """Close a connection."""
        with self._lock:
            self._open.pop(request, None)
        super().shutdown_request(request)

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Print no error for a browser that has left, or is too slow."""
        if not isinstance(sys.exc_info()[1], OSError):
            super().handle_error(request, client_address)

    def server_close(self) -> None:
        """Let browsers receive the data already sent, and close all connections."""
        super().server_close()
        with self._lock:
            threads = list(self._open.values())
        end = time.monotonic() + GRACE
        for thread in threads:
            thread.join(max(0.0, end - time.monotonic()))
        with self._lock:
            for request in self._open:
                with suppress(OSError):  # the connection is already closed
                    request.shutdown(socket.SHUT_RDWR)
        for thread in threads:
            thread.join()


class _Handler(BaseHTTPRequestHandler):
    server: SceneServer

    def setup(self) -> None:
        """Read the whole request by one deadline, because a timeout applies to each byte."""
        super().setup()
        self.rfile.close()
        self.rfile = io.BufferedReader(_InTime(self.connection, time.monotonic() + PATIENCE))

    def do_GET(self) -> None:
        self.connection.settimeout(PATIENCE)
        if not self._is_for_this_machine():
            self.send_error(403)
        elif self.path == "/":
            self._answer("text/html; charset=utf-8")
            self.wfile.write(page().encode())
        elif self.path == "/commands":
            self._answer("text/event-stream")
            self._stream()
        else:
            self.send_error(404)

    def _is_for_this_machine(self) -> bool:
        """Return whether a request is from our page, or no page, under a name of this machine."""
        hosts, origins = (self.headers.get_all(name, []) for name in ("Host", "Origin"))
        if len(hosts) != 1 or hosts[0].partition(":")[0].lower() not in HOSTS:
            return False
        if any(origin != f"http://{hosts[0]}" for origin in origins):
            return False
        # A link to the page may be anywhere, but requests for its data must come from the page
        # itself.
        sites = {"same-origin", "none"} | (
            {"cross-site", "same-site"} if self.path == "/" else set()
        )
        return self.headers.get("Sec-Fetch-Site", "none") in sites

    def _answer(self, content_type: str) -> None:
        self.send_response(200)
        self.send_header("Content-Type", content_type)
        self.send_header("Cache-Control", "no-store")
        self.send_header("Cross-Origin-Resource-Policy", "same-origin")
        self.send_header("X-Content-Type-Options", "nosniff")
        self.end_headers()

    def _stream(self) -> None:
        commands = self.server.commands.subscribe()
        try:
            while True:
                try:
                    text = commands.get(timeout=BEAT)
                except queue.Empty:
                    self.wfile.write(b":\n\n")
                    continue
                if text is None:
                    self.wfile.write(b'data: {"type":"end"}\n\n')
                    return
                self.wfile.write(f"data: {text}\n\n".encode())
        finally:
            self.server.commands.unsubscribe(commands)

    def log_message(self, format: str, *args: Any) -> None:
        """Print nothing, because a library must not."""


class _InTime(io.RawIOBase):
    """The input of a connection until a deadline."""

    def __init__(self, connection: socket.socket, deadline: float) -> None:
        self._connection, self._deadline = connection, deadline

    def readable(self) -> bool:
        """Return True: the stream can be read."""
        return True

    def readinto(self, buffer: Any) -> int:
        """Read available data, or raise TimeoutError at the deadline."""
        self._connection.settimeout(max(self._deadline - time.monotonic(), 1e-3))
        return self._connection.recv_into(buffer)
