"""A run of `penombre-view` on a virtual screen, and what a person does with it, by xdotool."""

from __future__ import annotations

import os
import subprocess
import threading
import time
from pathlib import Path

from pictures import Picture
from screen import Screen, wait_for
from x11 import XError

START_LIMIT_S = 60.0
FRAME_LIMIT_S = 20.0
_SETTLED_S = 0.5
# A library's complaint about desktops that are not there.
_NOISE = "XDG_RUNTIME_DIR"
_CLOCK_TICKS = os.sysconf("SC_CLK_TCK")

# What the picture shows, as the third byte of the latency marker says it.
RASTER, COARSE, REFINING, COMPLETE = 0x20, 0x60, 0xA0, 0xE0

Buttons = {"left": 1, "middle": 2, "right": 3}


class Viewer:
    """The running program. A context manager; at its end the program is ended, by its process id."""

    def __init__(self, screen: Screen, binary: Path, folder: Path, arguments: list[str], size: tuple[int, int]) -> None:
        self.screen, self.folder, self.size = screen, folder, size
        self.command = [str(binary), *arguments, "--size", f"{size[0]}x{size[1]}"]
        self.log = folder / "stderr.txt"
        with open(self.log, "ab") as log:
            self.process = subprocess.Popen(
                self.command, cwd=folder, env=screen.environment(), stdout=subprocess.PIPE, stderr=log, text=True
            )
        self.lines: list[str] = []
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()
        self.window = 0

    def __enter__(self) -> Viewer:
        return self

    def __exit__(self, *_: object) -> None:
        if self.process.poll() is None:
            self.process.kill()
            self.process.wait()
        self._reader.join(timeout=5.0)

    def _read(self) -> None:
        assert self.process.stdout is not None
        for line in self.process.stdout:
            self.lines.append(line.rstrip("\n"))

    def lives(self) -> bool:
        """Whether the program runs."""
        return self.process.poll() is None

    def appear(self) -> None:
        """Waits for the window and its first frame, and gives it the keyboard. The scene may still be loading."""
        self.window = wait_for("the window", START_LIMIT_S, self._find)
        # Without a window manager nothing has the focus.
        self.screen.xdotool("windowfocus", "--sync", self.window)
        wait_for("a first frame", FRAME_LIMIT_S, lambda: len(set(self.picture().data)) > 3)

    def _find(self) -> int | None:
        if not self.lives():
            raise XError(f"the program ended with status {self.process.returncode}: {self.said()}")
        search = ["xdotool", "search", "--onlyvisible", "--name", "^penombre"]
        env = self.screen.environment()
        found = subprocess.run(search, env=env, capture_output=True, text=True, timeout=60, check=False).stdout.split()
        return int(found[0]) if found else None

    def said(self) -> str:
        """The end of what the program printed as errors."""
        lines = self.log.read_text(errors="replace").splitlines()
        return "\n".join(line for line in lines if _NOISE not in line)[-800:]

    def title(self) -> str:
        """Title of the window."""
        return self.screen.xdotool("getwindowname", self.window).strip()

    def extent(self) -> tuple[int, int]:
        """Width and height of the whole window, pixels."""
        words = dict(w.split("=") for w in self.screen.xdotool("getwindowgeometry", "--shell", self.window).split())
        return int(words["WIDTH"]), int(words["HEIGHT"])

    def picture(self) -> Picture:
        """The picture, without the panel, as the screen shows it now."""
        return self.screen.display.grab(self.window, 0, 0, *self.size)

    def whole(self) -> Picture:
        """The whole window as the screen shows it now."""
        return self.screen.display.grab(self.window, 0, 0, *self.extent())

    def at_rest(self) -> Picture:
        """The whole window once nothing in it has changed for a while."""
        last, since = self.whole(), time.monotonic()

        def rests() -> bool:
            nonlocal last, since
            now = self.whole()
            if now != last:
                last, since = now, time.monotonic()
            return time.monotonic() - since >= _SETTLED_S

        wait_for("the window to come to rest", FRAME_LIMIT_S, rests, poll_s=0.05)
        return last

    def settled(self) -> Picture:
        """The picture once nothing in the window has changed for a while."""
        return self.at_rest().part(0, 0, *self.size)

    def changed(self, before: Picture, what: str) -> Picture:
        """The picture at rest after it has become another than `before`."""
        wait_for(what, FRAME_LIMIT_S, lambda: self.picture() != before)
        return self.settled()

    def becomes(self, expected: Picture, what: str, limit_s: float = FRAME_LIMIT_S) -> None:
        """Waits until the picture is exactly `expected`."""
        wait_for(what, limit_s, lambda: self.picture() == expected)

    def marker(self) -> tuple[int, int]:
        """The latency marker: number of events that the frame on the screen has seen, and what it shows."""
        low, high, kind = self.screen.display.pixel(self.window, 3, 3)
        return low | high << 8, kind

    def shows(self, least: int, what: str, limit_s: float = FRAME_LIMIT_S) -> int:
        """Waits until the marker says `least` or, for an image, something better; returns what it says."""
        fits = (lambda kind: kind == RASTER) if least == RASTER else (lambda kind: kind >= least)
        wait_for(what, limit_s, lambda: fits(self.marker()[1]), poll_s=0.001)
        return self.marker()[1]

    def key(self, *names: str) -> None:
        """Presses keys, by their names of X."""
        self.screen.xdotool("key", "--delay", 30, *names)

    def answer(self, key: str, text: str) -> None:
        """Opens a dialogue by a key, types a text over what it proposes, and Return."""
        before = self.whole()
        self.key(key)
        wait_for(f"a dialogue after {key}", FRAME_LIMIT_S, lambda: self.whole() != before)
        self.screen.xdotool("type", "--delay", 15, text)
        self.key("Return")

    def drag(self, button: str, start: tuple[int, int], steps: list[tuple[int, int]]) -> None:
        """Drags from a point of the window by steps in pixels."""
        number = Buttons[button]
        words: list[str | int] = ["mousemove", "--window", self.window, *start, "mousedown", number]
        for dx, dy in steps:
            words += ["sleep", 0.03, "mousemove_relative", "--", dx, dy]
        self.screen.xdotool(*words, "sleep", 0.03, "mouseup", number)

    def wheel(self, notches: int, at: tuple[int, int]) -> None:
        """Turns the wheel over a point of the window; away from the hand is positive."""
        button = 4 if notches > 0 else 5
        self.screen.xdotool("mousemove", "--window", self.window, *at, "click", "--repeat", abs(notches), button)

    def resize(self, width: int, height: int) -> None:
        """Gives the whole window another size."""
        self.screen.xdotool("windowsize", self.window, width, height)

    def quit(self) -> int:
        """Presses `q` and waits for the end; the exit status."""
        self.key("q")
        wait_for("the end after q", FRAME_LIMIT_S, lambda: not self.lives())
        return self.process.returncode

    def cpu_seconds(self) -> float:
        """Processor time of all threads until now."""
        fields = Path(f"/proc/{self.process.pid}/stat").read_text().rpartition(")")[2].split()
        return (int(fields[11]) + int(fields[12])) / _CLOCK_TICKS
