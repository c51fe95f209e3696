#!/usr/bin/env python3
"""Drives the window program on a virtual screen, with keys and mouse by xdotool, and looks at what it shows and writes.

    PENOMBRE_VIEW_BIN=target/debug/penombre-view PENOMBRE_BIN=target/release/penombre \\
        python3 tests/window/drive.py [--keep DIR] [SCENARIO ...]

One line a check; exit status 1 if any check fails, 2 if a program is missing. Needs Xvfb, xdotool, and a driver for
Vulkan or GL (Debian: xvfb, xdotool, mesa-vulkan-drivers).
"""

from __future__ import annotations

import argparse
import os
import shutil
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import trouble
from course import course
from report import Report, Stage
from screen import Screen

ROOT = Path(__file__).resolve().parents[2]
SCENARIOS: dict[str, Callable[[Stage], None]] = {
    "course": course,
    "long-render": trouble.long_render,
    "broken-scenes": trouble.broken_scenes,
    "unwritable": trouble.unwritable,
    "sizes": trouble.sizes,
    "refusals": trouble.refusals,
}


def binary(variable: str, default: str) -> Path:
    """The program that the environment names, else the one built here. Ends this program if it is not there."""
    named = os.environ.get(variable)
    path = Path(named) if named else ROOT / "target" / default
    if not path.is_file():
        print(f"error: no program {path}: build it, or name one by {variable}", file=sys.stderr)
        sys.exit(2)
    return path.resolve()


def require(*tools: str) -> None:
    """Ends this program if a tool is not there."""
    missing = [tool for tool in tools if shutil.which(tool) is None]
    if missing:
        print(f"error: missing: {', '.join(missing)} (Debian: apt-get install xvfb xdotool)", file=sys.stderr)
        sys.exit(2)


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenario", nargs="*", help=f"of {', '.join(SCENARIOS)}; default: all")
    parser.add_argument("--keep", type=Path, metavar="DIR", help="keep a picture of the window at every check")
    arguments = parser.parse_args()
    unknown = [name for name in arguments.scenario if name not in SCENARIOS]
    if unknown:
        parser.error(f"no scenario {', '.join(unknown)}: {', '.join(SCENARIOS)}")
    return arguments


def main() -> int:
    """Runs the command line."""
    arguments = _arguments()
    view, penombre = binary("PENOMBRE_VIEW_BIN", "debug/penombre-view"), binary("PENOMBRE_BIN", "release/penombre")
    require("Xvfb", "xdotool")
    start, report = time.monotonic(), Report(arguments.keep)
    with Screen() as screen, tempfile.TemporaryDirectory(prefix="penombre-window-") as folder:
        stage = Stage(screen, report, view, penombre, Path(folder))
        for name in arguments.scenario or SCENARIOS:
            SCENARIOS[name](stage)
    passed = report.close()
    print(f"{time.monotonic() - start:.0f} s")
    return 0 if passed else 1


if __name__ == "__main__":
    sys.exit(main())
