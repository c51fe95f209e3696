"""A virtual screen: an X server of our own without a window manager, on a display that nobody else has."""

from __future__ import annotations

import os
import subprocess
import threading
import time
from collections.abc import Callable
from typing import TypeVar

from x11 import Display

WIDTH, HEIGHT = 1760, 1000
_START_LIMIT_S = 30.0
_POLL_S = 0.01

Value = TypeVar("Value")


class Late(Exception):
    """What was waited for did not come."""


def wait_for(what: str, limit_s: float, look: Callable[[], Value | None], poll_s: float = _POLL_S) -> Value:
    """Calls `look` until it returns something true, and returns that. Raises Late, which names `what`."""
    end = time.monotonic() + limit_s
    while True:
        found = look()
        if found:
            return found
        if time.monotonic() > end:
            raise Late(f"waited {limit_s:.0f} s for: {what}")
        time.sleep(poll_s)


class Screen:
    """Xvfb and our own connection to it. A context manager; at its end the server is ended, by its process id."""

    def __init__(self) -> None:
        read, write = os.pipe()
        mode = f"{WIDTH}x{HEIGHT}x24"
        command = ["Xvfb", "-displayfd", str(write), "-screen", "0", mode, "-nolisten", "tcp", "-noreset"]
        quiet = subprocess.DEVNULL
        try:
            self._server = subprocess.Popen(command, pass_fds=[write], stdout=quiet, stderr=quiet)
        finally:
            os.close(write)
        guard = threading.Timer(_START_LIMIT_S, self._server.kill)
        guard.start()
        with os.fdopen(read) as pipe:
            number = pipe.readline().strip()  # empty if the server has ended
        guard.cancel()
        if not number:
            raise Late("Xvfb did not start")
        self.name = f":{number}"
        self.display = Display(self.name)

    def __enter__(self) -> Screen:
        return self

    def __exit__(self, *_: object) -> None:
        self.display.close()
        self._server.terminate()
        self._server.wait()

    def environment(self) -> dict[str, str]:
        """Our environment with this display and no other."""
        return {**without_display(), "DISPLAY": self.name}

    def xdotool(self, *words: str | int) -> str:
        """Runs xdotool and returns what it prints. Raises CalledProcessError if it fails."""
        command = ["xdotool", *map(str, words)]
        env = self.environment()
        return subprocess.run(command, env=env, capture_output=True, text=True, check=True, timeout=60).stdout


def without_display() -> dict[str, str]:
    """Our environment without any display."""
    return {k: v for k, v in os.environ.items() if k not in ("DISPLAY", "WAYLAND_DISPLAY", "WAYLAND_SOCKET")}
