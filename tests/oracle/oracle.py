#!/usr/bin/env python3
"""Independent brute-force evaluation of the course's classic ray tracer (standard library only).

    python3 tests/oracle/oracle.py cornell --phase 4 --out cornell.png
    python3 tests/oracle/oracle.py cornell --phase 2 --soft --samples 2 --blocks 32 --out blocks.json

Scenes: sphere, square, cornell, sphere-as-given, cornell-as-given, checker-mirror, checker-glass, or a `.toml`
file. Without --soft one ray goes through each pixel's centre and every light is a point at its centre (hard shadows).
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from dataclasses import replace
from pathlib import Path

import rendering
import scenes
from images import write_pfm, write_png
from model import Scene, Vec


def _size(text: str) -> tuple[int, int]:
    width, height = map(int, text.lower().split("x"))
    return width, height


def _vector(text: str) -> Vec:
    x, y, z = map(float, text.split(","))
    return (x, y, z)


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene", help="name of a scene, or a .toml file")
    parser.add_argument("--phase", type=int, choices=(1, 2, 3, 4), default=4)
    parser.add_argument("--hard-shadows", action="store_true", help="the rule without --soft; said for clarity")
    parser.add_argument("--size", type=_size, default=(480, 480), metavar="WxH")
    for name in ("position", "target", "up"):
        parser.add_argument(f"--{name}", type=_vector, metavar="X,Y,Z", help=f"overrides the camera's {name}")
    for name in ("fov", "near", "far"):
        parser.add_argument(f"--{name}", type=float, help=f"overrides the camera's {name}")
    parser.add_argument("--soft", action="store_true", help="random points of the lights, means of blocks as JSON")
    parser.add_argument("--samples", type=int, default=2, help="rays a pixel with --soft, 2 or more")
    parser.add_argument("--blocks", type=int, default=32, help="edge of a block in pixels, with --soft")
    parser.add_argument("--seed", type=int, default=1, help="of --soft")
    parser.add_argument("--out", type=Path, required=True, help=".pfm (exact), .png (to look at); .json with --soft")
    arguments = parser.parse_args()
    if arguments.soft and (arguments.samples < 2 or arguments.hard_shadows):
        parser.error("--soft needs 2 samples or more and excludes --hard-shadows")
    if arguments.out.suffix not in ([".json"] if arguments.soft else [".pfm", ".png"]):
        parser.error(f"{arguments.out}: expected .json with --soft, else .pfm or .png")
    return arguments


def _scene(arguments: argparse.Namespace) -> Scene:
    scene = scenes.load(arguments.scene)
    names = ("position", "target", "up", "fov", "near", "far")
    changes = {n: getattr(arguments, n) for n in names if getattr(arguments, n) is not None}
    return replace(scene, camera=replace(scene.camera, **changes))


def main() -> int:
    """Runs the command line; exit status 2 for a scene that the oracle cannot read."""
    arguments = _arguments()
    try:
        scene = _scene(arguments)
    except (scenes.SceneError, OSError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    width, height = arguments.size
    start = time.monotonic()
    if arguments.soft:
        blocks = rendering.soft_blocks(
            scene, arguments.phase, width, height, arguments.samples, arguments.blocks, arguments.seed
        )
        arguments.out.write_text(json.dumps(rendering.blocks_as_json(blocks)))
    else:
        image = rendering.render(scene, arguments.phase, width, height)
        (write_png if arguments.out.suffix == ".png" else write_pfm)(arguments.out, image)
    print(f"{arguments.out}: {width} x {height} in {time.monotonic() - start:.1f} s", file=sys.stderr)
    return 0


if __name__ == "__main__":
    sys.exit(main())
