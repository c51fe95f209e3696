#!/usr/bin/env python3
"""Holds the renderer's classic integrator against the oracle.

    PENOMBRE_BIN=target/release/penombre python3 tests/oracle/compare.py [--quick] [--keep DIR]

One line a check with its figure; exit status 1 if any check fails, 2 if there is no renderer to check.
"""

from __future__ import annotations

import argparse
import math
import os
import shutil
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import rendering
import scenes
from images import Image
from model import Camera, Scene
from renderer import Renderer, RendererError
from soft import SoftCheck, compare_soft

TOLERANCE = 1.0 / 255.0
SHARE = 0.995


@dataclass(frozen=True)
class Result:
    """Outcome of one check: what was looked at, whether it held, and the figure."""

    name: str
    passed: bool
    figure: str


@dataclass(frozen=True)
class Plan:
    """Sizes of one run; `quick` keeps every check and makes the pictures smaller."""

    edge: int
    wide_row_step: int
    soft: SoftCheck

    @staticmethod
    def of(quick: bool) -> Plan:
        """The quick or the full plan."""
        if quick:
            return Plan(160, 90, SoftCheck(256, oracle_samples=2, seeds=8, spp=8, long_spp=64, blocks=(16,)))
        return Plan(480, 18, SoftCheck(480, oracle_samples=2, seeds=8, spp=8, long_spp=64, blocks=(16, 32)))


def compare_images(found: Image, expected: Image, row_step: int = 1) -> tuple[bool, str]:
    """Share of pixels whose channels, clamped to 0..1, all lie within 1/255, and the largest difference."""
    if (found.width, len(range(0, found.height, row_step))) != (expected.width, expected.height):
        return False, f"size {found.width} x {found.height}, expected width {expected.width}"
    row, close, worst = 3 * found.width, 0, 0.0
    for y in range(expected.height):
        a = found.data[y * row_step * row : (y * row_step + 1) * row]
        b = expected.data[y * row : (y + 1) * row]
        apart = [abs(min(1.0, max(0.0, p)) - min(1.0, max(0.0, q))) for p, q in zip(a, b)]
        apart = [d if d == d else math.inf for d in apart]  # not a number is as wrong as can be
        worst = max(worst, max(apart))
        close += sum(max(apart[i : i + 3]) <= TOLERANCE for i in range(0, row, 3))
    share = close / (expected.width * expected.height)
    return share >= SHARE, f"{100.0 * share:.3f} % within 1/255, largest difference {worst:.4f}"


def _centered(renderer: Renderer, scene: str, options: list[str], size: tuple[int, int]) -> Image:
    fixed = ["--integrator", "classic", "--disable-pixel-jitter", "--spp", "1", "--hard-shadows"]
    return renderer.render(scene, [*fixed, "--size", f"{size[0]}x{size[1]}", *options])


def check_phases(renderer: Renderer, plan: Plan) -> Iterator[Result]:
    """Every scene in its telling phases, pixel by pixel, hard shadows."""
    rows = [(s, p) for s in ("sphere", "square", "cornell") for p in (1, 2)]
    rows += [(s, p) for s in ("cornell", *scenes.OWN_SCENES, "cornell-as-given") for p in (3, 4)]
    rows += [("sphere-as-given", 2), ("sphere-as-given", 3), ("checker-mirror", 1), ("checker-glass", 2)]
    size = (plan.edge, plan.edge)
    for name, phase in rows:
        where = str(scenes.own_path(name)) if name in scenes.OWN_SCENES else name
        found = _centered(renderer, where, ["--phase", str(phase)], size)
        expected = rendering.render(scenes.load(name), phase, *size)
        yield Result(f"{name}, phase {phase}", *compare_images(found, expected))


def _camera_options(camera: Camera) -> list[str]:
    options = []
    for key in ("position", "target", "up"):
        numbers = ",".join(repr(c) for c in getattr(camera, key))
        options += ["--set", f"camera.{key}=[{numbers}]"]
    return options


def check_cameras(renderer: Renderer, plan: Plan) -> Iterator[Result]:
    """Near-plane trap, wide picture, turned cameras."""
    cornell: Scene = scenes.load("cornell")
    edge = (plan.edge, plan.edge)

    found = _centered(renderer, "cornell", ["--phase", "1", "--set", "camera.near=0"], edge)
    expected = rendering.render(replace(cornell, camera=replace(cornell.camera, near=0.0)), 1, *edge)
    white = all(c == 1.0 for c in expected.data)
    passed, figure = compare_images(found, expected)
    yield Result("near plane at 0 shows the front wall", passed and white, figure)

    wide = _centered(renderer, "cornell", ["--phase", "2"], (1920, 1080))
    expected = rendering.render(cornell, 2, 1920, 1080, plan.wide_row_step)
    yield Result("1920x1080, some rows", *compare_images(wide, expected, plan.wide_row_step))

    for axis, degrees in (("y", 30.0), ("y", -30.0), ("x", 30.0)):
        camera = cornell.camera.orbited(axis, degrees)
        found = _centered(renderer, "cornell", ["--phase", "4", *_camera_options(camera)], edge)
        expected = rendering.render(replace(cornell, camera=camera), 4, *edge)
        yield Result(f"world turned by {degrees:.0f} degrees about {axis}", *compare_images(found, expected))


def check_outlines(renderer: Renderer, _: Plan) -> Iterator[Result]:
    """Radius of the sphere and half-side of the square in pixels at 480 x 480, from the covered area."""
    options = ["--integrator", "classic", "--phase", "1", "--spp", "16", "--size", "480x480"]
    for name, color, expected in (("sphere", 1.0, 96.3), ("square", 0.8, 94.99)):
        area = sum(renderer.render(name, options).data[0::3]) / color
        found = math.sqrt(area / math.pi) if name == "sphere" else math.sqrt(area) / 2.0
        what = "radius" if name == "sphere" else "half-side"
        figure = f"{found:.3f} px, expected {expected} to 0.5"
        yield Result(f"{name}, {what}", abs(found - expected) <= 0.5, figure)


def check_soft(renderer: Renderer, plan: Plan) -> Iterator[Result]:
    """Soft shadows: block means against Monte Carlo, chi-squared by channel."""
    for line in compare_soft(renderer, plan.soft):
        yield Result(*line)


def _binary(argument: str | None) -> Path | None:
    named = argument or os.environ.get("PENOMBRE_BIN")
    path = Path(named) if named else Path(__file__).resolve().parents[2] / "target" / "release" / "penombre"
    return path.resolve() if path.is_file() else None


Check = Callable[[Renderer, Plan], Iterator[Result]]


def _run(checks: list[Check], renderer: Renderer, plan: Plan) -> list[Result]:
    results: list[Result] = []
    for check in checks:
        try:
            for result in check(renderer, plan):
                results.append(result)
                print(f"{'ok  ' if result.passed else 'FAIL'} {result.name}: {result.figure}", flush=True)
        except RendererError as error:
            results.append(Result(check.__name__, False, str(error)))
            print(f"FAIL {check.__name__}: {error}", flush=True)
    return results


def main() -> int:
    """Runs all checks."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("binary", nargs="?", help="default: $PENOMBRE_BIN, else target/release/penombre")
    parser.add_argument("--quick", action="store_true", help="every check, smaller pictures")
    parser.add_argument("--keep", type=Path, metavar="DIR", help="leave the renderer's images in this folder")
    arguments = parser.parse_args()
    binary = _binary(arguments.binary)
    if binary is None:
        print("error: no renderer: build it with `cargo build --release -p penombre-cli`", file=sys.stderr)
        return 2
    start = time.monotonic()
    folder = arguments.keep or Path(tempfile.mkdtemp(prefix="penombre-oracle-"))
    folder.mkdir(parents=True, exist_ok=True)
    try:
        checks = [check_phases, check_cameras, check_outlines, check_soft]
        results = _run(checks, Renderer(binary, folder), Plan.of(arguments.quick))
    finally:
        if arguments.keep is None:
            shutil.rmtree(folder)
    failed = sum(not r.passed for r in results)
    print(f"oracle: {len(results) - failed} passed, {failed} failed in {time.monotonic() - start:.0f} s")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
