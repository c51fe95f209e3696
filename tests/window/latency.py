#!/usr/bin/env python3
"""Measures how soon the window shows what a person did while a render keeps all cores busy, and its work when idle.

    PENOMBRE_VIEW_BIN=target/release/penombre-view python3 tests/window/latency.py [--quick] [--json]

The program runs with `--latency-marker`: one pixel of its window tells how many events the frame on the screen has
seen, and whether it shows the raster view or an image. Events come from XTest; times run from just before an event is
sent until that pixel, read once a millisecond, has changed on the screen. Seeds are fixed. Exit status 1 if something
could not be measured, 2 if a program is missing. Needs what tests/window/drive.py needs.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import random
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

from drive import binary, require
from report import FAULTS
from screen import Late, Screen, wait_for
from viewer import COARSE, COMPLETE, FRAME_LIMIT_S, RASTER, Viewer

WIDE, SQUARE = (1280, 720), (480, 480)
PANEL_WIDTH = 280
IDLE_S = 10.0
SEED = 1
# Rows and columns of the displaced sphere: 2 * 158 * 317 triangles.
RINGS, SECTORS = 159, 317
# The pixel that is read must have been still for so long before an event is sent, seconds.
STILL_S = 0.1
# Between events of a drag that ends in rest, as a hand gives them, seconds.
HAND_S = 0.016
POLL_S = 0.001

SCENE = """\
penombre = 1
[render]
integrator = "classic"
spp = 100000
[camera.main]
type = "perspective"
position = [0, 2, 6]
target = [0, 0, 0]
up = [0, 1, 0]
fov = 45
[material.stone]
type = "phong"
diffuse = [0.7, 0.6, 0.5]
specular = [0.2, 0.2, 0.2]
shininess = 20
[material.ground]
type = "phong"
diffuse = [0.5, 0.5, 0.5]
[shape.ground]
type = "quad"
origin = [-6, -1.3, 6]
sides = [[12, 0, 0], [0, 0, -12]]
material = "ground"
[shape.stone]
type = "mesh"
file = "stone.obj"
material = "stone"
[light.lamp]
type = "quad"
origin = [-1, 4, 1]
sides = [[2, 0, 0], [0, 0, 2]]
color = [1, 1, 1]
shadow_samples = 16
"""


def write_scene(folder: Path) -> tuple[Path, int]:
    """A displaced sphere over a ground below a square lamp; the file and the number of the sphere's triangles."""
    lines, faces = [], []
    for ring in range(RINGS):
        polar = math.pi * (ring + 0.5) / RINGS
        for sector in range(SECTORS):
            turn = 2.0 * math.pi * sector / SECTORS
            radius = 1.0 + 0.08 * math.sin(9.0 * polar) * math.sin(11.0 * turn)
            x, z = math.sin(polar) * math.cos(turn), math.sin(polar) * math.sin(turn)
            lines.append(f"v {radius * x:.6f} {radius * math.cos(polar):.6f} {radius * z:.6f}")
    for ring in range(RINGS - 1):
        for sector in range(SECTORS):
            a, b = ring * SECTORS + sector + 1, ring * SECTORS + (sector + 1) % SECTORS + 1
            faces += [f"f {a} {b} {b + SECTORS}", f"f {a} {b + SECTORS} {a + SECTORS}"]
    (folder / "stone.obj").write_text("\n".join(lines + faces) + "\n")
    path = folder / "stone.toml"
    path.write_text(SCENE)
    return path, len(faces)


class Probe:
    """Sends events to a running program and times what its marker says. All times are seconds."""

    def __init__(self, viewer: Viewer) -> None:
        self.viewer, self.display = viewer, viewer.screen.display
        self.random = random.Random(SEED)
        self.left, self.top = self.display.origin(viewer.window)

    def move(self, x: int, y: int) -> None:
        """Moves the pointer to a point of the window."""
        self.display.move(self.left + x, self.top + y)

    def pause(self, least: float, most: float) -> None:
        """Lets the program work undisturbed: the hand that waits."""
        time.sleep(self.random.uniform(least, most))

    def still(self) -> int:
        """Waits until the frame on the screen has seen all events; their number."""
        last, since = self.viewer.marker()[0], time.monotonic()

        def stays() -> bool:
            nonlocal last, since
            now = self.viewer.marker()[0]
            if now != last:
                last, since = now, time.monotonic()
            return time.monotonic() - since >= STILL_S

        wait_for("all events to be drawn", FRAME_LIMIT_S, stays, POLL_S)
        return last

    def until(self, what: str, event: Callable[[], None], seen: Callable[[int, int], bool]) -> float:
        """Time from just before `event` until `seen` is content with the marker's count and kind."""
        start = time.perf_counter()
        event()
        wait_for(what, FRAME_LIMIT_S, lambda: seen(*self.viewer.marker()), POLL_S)
        return time.perf_counter() - start

    def render(self) -> None:
        """Starts a render and waits for a first image."""
        self.display.key("r")
        self.viewer.shows(COARSE, "a first image after r")


def over_panel(probe: Probe, count: int) -> list[float]:
    """The pointer moves over the panel while a render runs."""
    times = []
    probe.render()
    for _ in range(count):
        probe.pause(0.1, 0.4)
        before = probe.still()
        x = WIDE[0] + probe.random.randrange(20, PANEL_WIDTH - 20)
        y = probe.random.randrange(20, WIDE[1] - 20)
        times.append(probe.until("a frame", lambda: probe.move(x, y), lambda n, _: n != before))
        if probe.viewer.marker()[1] == RASTER:
            raise Late("the render was cancelled by a pointer over the panel")
    return times


def into_raster(probe: Probe, count: int) -> list[float]:
    """A drag begins while a render runs: until the raster view is on the screen."""
    times = []
    for i in range(count):
        probe.move(WIDE[0] // 2, WIDE[1] // 2)
        if probe.viewer.marker()[1] == RASTER:
            probe.render()
        probe.pause(0.1, 0.8)
        before = probe.still()
        probe.until("the press", lambda: probe.display.button(True), lambda n, _: n != before)
        x = WIDE[0] // 2 + (20 if i % 2 else -20)
        raster = probe.until(
            "the raster view", lambda: probe.move(x, WIDE[1] // 2), lambda _, kind: kind == RASTER
        )
        times.append(raster)
        probe.display.button(False)
        probe.still()
    return times


def in_raster(probe: Probe, count: int) -> list[float]:
    """The moves of a long drag in the raster view, each drawn before the next is sent."""
    times = []
    probe.display.button(False)
    x, y = WIDE[0] // 4, WIDE[1] // 2
    probe.move(x, y)
    probe.still()
    probe.display.button(True)
    for i in range(count):
        before = probe.still()
        x += 8 if i % 40 < 20 else -8
        times.append(probe.until("a frame", lambda: probe.move(x, y), lambda n, _: n != before))
    probe.display.button(False)
    probe.still()
    return times


def first_image(probe: Probe, count: int) -> list[float]:
    """With the live render on: from the last move of a drag until an image of that camera is on the screen."""
    times = []
    for i in range(count):
        probe.viewer.shows(COARSE, "a live image")
        probe.pause(0.1, 0.5)
        x, y = SQUARE[0] // 2, SQUARE[1] // 2
        probe.move(x, y)
        probe.display.button(True)
        for _ in range(12):
            time.sleep(HAND_S)
            x += 4 if i % 2 else -4
            start = time.perf_counter()
            probe.move(x, y)
        probe.display.button(False)
        times.append(first_image_at(probe) - start)
    return times


def first_image_at(probe: Probe) -> float:
    """When an image appeared that has seen all events: known only when the count has not changed for a while."""
    count, first, end = -1, math.inf, time.perf_counter() + FRAME_LIMIT_S
    while time.perf_counter() < end:
        (n, kind), now = probe.viewer.marker(), time.perf_counter()
        if n != count:
            count, first, changed = n, math.inf, now
        if kind >= COARSE:
            first = min(first, now)
        if first < math.inf and now - changed > 4.0 * STILL_S:
            return first
        time.sleep(POLL_S)
    raise Late("waited for a live image after a drag")


def idle_seconds(viewer: Viewer) -> float:
    """Processor time of all threads in ten idle seconds."""
    viewer.at_rest()
    before = viewer.cpu_seconds()
    time.sleep(IDLE_S)
    return viewer.cpu_seconds() - before


class Bench:
    """Runs of the program, and what was measured in them."""

    def __init__(self, screen: Screen, view: Path, folder: Path, count: int) -> None:
        self.screen, self.view, self.folder, self.count = screen, view, folder, count
        self.rows: dict[str, list[float]] = {}
        self.idle: dict[str, float] = {}
        self.failures = 0

    def part(self, name: str, scene: str, size: tuple[int, int], work: Callable[[Viewer], None], *options: str) -> None:
        """One run of the program. What goes wrong in it is told, and the next one goes on."""
        arguments = [scene, "--latency-marker", *options]
        with Viewer(self.screen, self.view, self.folder, arguments, size) as viewer:
            try:
                viewer.appear()
                work(viewer)
            except FAULTS as error:
                self.failures += 1
                print(f"NOT MEASURED {name}: {error} {viewer.said()}", file=sys.stderr, flush=True)

    def large(self, viewer: Viewer) -> None:
        """Everything that concerns a large picture of a large mesh."""
        viewer.at_rest()
        probe = Probe(viewer)
        self.rows["pointer over the panel while rendering"] = over_panel(probe, 2 * self.count)
        self.rows["drag while rendering, to the raster view"] = into_raster(probe, self.count)
        self.rows["drag in the raster view"] = in_raster(probe, 2 * self.count)

    def live(self, scene: str, viewer: Viewer) -> None:
        """The first image after a drag."""
        self.rows[f"end of a drag to the first image, {scene}"] = first_image(Probe(viewer), self.count)

    def rest(self, viewer: Viewer) -> None:
        """Processor time without input, before and after a render."""
        self.idle["raster view"] = idle_seconds(viewer)
        viewer.key("r")
        viewer.shows(COMPLETE, "a complete image", 120.0)
        self.idle["complete image"] = idle_seconds(viewer)


def summary(times: list[float]) -> dict[str, float]:
    """Count, and median, 95th percentile and maximum in milliseconds."""
    ranked = sorted(1000.0 * t for t in times)
    rank = [ranked[math.ceil(share * len(ranked)) - 1] for share in (0.5, 0.95, 1.0)]
    return {"count": len(ranked), **dict(zip(("median_ms", "p95_ms", "max_ms"), (round(v, 1) for v in rank)))}


def show(bench: Bench, triangles: int) -> None:
    """Prints the table."""
    load = " ".join(f"{l:.1f}" for l in os.getloadavg())
    sizes = f"first images at {SQUARE[0]} x {SQUARE[1]}, the rest at {WIDE[0]} x {WIDE[1]}"
    print(f"{triangles} triangles, {os.cpu_count()} cores, load {load}; {sizes}")
    print(f"{'ms':<52}{'n':>5}{'median':>9}{'p95':>9}{'max':>9}")
    for name, times in bench.rows.items():
        count, *figures = summary(times).values()
        print(f"{name:<52}{count:>5}{''.join(f'{v:>9.1f}' for v in figures)}")
    for name, seconds in bench.idle.items():
        print(f"processor time in {IDLE_S:.0f} idle seconds, {name}: {seconds:.2f} s")


def main() -> int:
    """Runs the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="fewer events: does it work at all?")
    parser.add_argument("--json", action="store_true", help="one line of JSON after the table")
    arguments = parser.parse_args()
    view = binary("PENOMBRE_VIEW_BIN", "release/penombre-view")
    require("Xvfb", "xdotool")
    with Screen() as screen, tempfile.TemporaryDirectory(prefix="penombre-latency-") as name:
        scene, triangles = write_scene(Path(name))
        bench = Bench(screen, view, Path(name), 5 if arguments.quick else 30)
        bench.part("large", str(scene), WIDE, bench.large)
        for live in ("cornell", str(scene)):
            title = Path(live).stem
            bench.part(f"live {title}", live, SQUARE, lambda v, t=title: bench.live(t, v), "--live")
        bench.part("idle", "cornell", SQUARE, bench.rest, "--set", "render.spp=4")
    show(bench, triangles)
    if arguments.json:
        rows = {name: summary(times) for name, times in bench.rows.items()}
        print(json.dumps({"triangles": triangles, "latency": rows, "idle_cpu_s": bench.idle}))
    return 1 if bench.failures else 0


if __name__ == "__main__":
    sys.exit(main())
