"""A live scene in the browser, served only to this machine."""

from __future__ import annotations

import threading
from types import TracebackType

from psp3.checks import checked_count
from psp3.robots.robot import Robot
from psp3.visualize.scene import Scene
from psp3.visualize.server import SceneServer

LAST_PORT = 65535


class Viewer(Scene):
    """A scene in the browser that shows changes at once, served only to this machine.

    Use it as a context manager, or call :meth:`close`.

    Parameters
    ----------
    robot : robot from :func:`psp3.load`
        What to show.
    port : int
        Port to listen on, up to 65535; if it is taken, the next free one.

    Attributes
    ----------
    url : str
        Address to open in the browser.

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

    def _listen(self, port: int) -> SceneServer:
        port = checked_count("port", port, 0, LAST_PORT)
        for candidate in range(port, min(port + 100, LAST_PORT + 1)):
            try:
                return SceneServer(candidate, self._commands)
            except OSError:
                continue
        any_free_port = 0
        return SceneServer(any_free_port, self._commands)

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
