"""One line a check, and pictures of the window for whoever looks into a failure."""

from __future__ import annotations

import re
import shutil
import subprocess
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from pictures import write_png
from screen import Late, Screen
from viewer import Viewer
from x11 import XError

FAULTS = (Late, XError, OSError, ValueError, subprocess.SubprocessError)


class Report:
    """Prints checks as they come and counts them. Pictures go to `keep`, else to a folder that stays after failures."""

    def __init__(self, keep: Path | None) -> None:
        self._keeps_all = keep is not None
        self._folder = keep or Path(tempfile.mkdtemp(prefix="penombre-window-"))
        self._folder.mkdir(parents=True, exist_ok=True)
        self.passed = self.failed = 0

    def check(self, name: str, passed: bool, figure: str = "", viewer: Viewer | None = None) -> None:
        """Notes one check; of a failure, and of everything with `--keep`, the window is kept as a picture."""
        self.passed += passed
        self.failed += not passed
        shot = self._shot(name, viewer) if viewer and (self._keeps_all or not passed) else ""
        seen = f"    see {shot}" if shot and not passed else ""
        print(f"{'ok    ' if passed else 'FAILED'} {name}{f': {figure}' if figure else ''}{seen}", flush=True)

    def _shot(self, name: str, viewer: Viewer) -> str:
        number = self.passed + self.failed
        path = self._folder / f"{number:02}-{re.sub('[^a-z0-9]+', '-', name.lower()).strip('-')}.png"
        try:
            write_png(path, viewer.whole())
        except FAULTS as error:
            return f"(no picture: {error})"
        return str(path)

    def close(self) -> bool:
        """Prints the sums and removes pictures that nobody asked for; whether all checks passed."""
        print(f"window: {self.passed} passed, {self.failed} failed")
        if self.failed == 0 and not self._keeps_all:
            shutil.rmtree(self._folder)
        return self.failed == 0


class Stage:
    """What every scenario needs: the screen, the programs, an empty folder for each run."""

    def __init__(self, screen: Screen, report: Report, view: Path, penombre: Path, folder: Path) -> None:
        self.screen, self.report, self.view, self.penombre = screen, report, view, penombre
        self._folder = folder

    def folder(self, name: str) -> Path:
        """A new folder for one run, the program's current folder."""
        path = self._folder / name
        path.mkdir()
        return path

    @contextmanager
    def run(self, name: str, arguments: list[str], size: tuple[int, int] = (480, 480)) -> Iterator[Viewer]:
        """A run of the program in a folder of its own, from its first frame on. At its end it is asked to quit."""
        with Viewer(self.screen, self.view, self.folder(name), arguments, size) as viewer:
            with self.part(name, viewer):
                viewer.appear()
                viewer.at_rest()
                yield viewer
                status = viewer.quit()
                self.report.check(f"{name}: q ends the program", status == 0, f"exit status {status}")

    @contextmanager
    def part(self, name: str, viewer: Viewer) -> Iterator[None]:
        """What goes wrong inside is one failed check, and the next part goes on."""
        try:
            yield
        except FAULTS as error:
            lives = "" if viewer.lives() else f"; the program ended with status {viewer.process.returncode}"
            said = viewer.said()
            self.report.check(name, False, f"{error}{lives}{f'; it said: {said}' if said else ''}", viewer)
