"""Pictures and block statistics from the tracer, over rows in several processes."""

from __future__ import annotations

import multiprocessing
import random
from array import array
from dataclasses import asdict, dataclass

from images import Image
from model import Scene
from tracer import CENTER, Tracer, camera_frame

PROCESSES = 2
# Each camera ray of the Monte Carlo means sends shadow rays to one random point in each cell of a grid of this many
# cells a side: far less noise at the edge of a shadow than as many points anywhere.
LIGHT_GRID = 3


@dataclass(frozen=True)
class _Rows:
    """What a worker needs to know; `samples` = 0 means one ray through each pixel's centre."""

    scene: Scene
    phase: int
    width: int
    height: int
    samples: int = 0
    seed: int = 0


def render(scene: Scene, phase: int, width: int, height: int, row_step: int = 1) -> Image:
    """One ray through each pixel's centre, lights as points at their centres.

    With `row_step` above 1 only rows 0, row_step, 2 row_step, … are computed, and the image holds only these.
    """
    job = _Rows(scene, phase, width, height)
    rows = range(0, height, row_step)
    data = array("d")
    for row in _map(_center_row, [(job, y) for y in rows]):
        data.extend(row)
    return Image(width, len(rows), data)


@dataclass(frozen=True)
class Block:
    """Statistics of one block of pixels: mean by channel, variance of that mean, number of samples."""

    x: int
    y: int
    mean: list[float]
    variance: list[float]
    n: int


def soft_blocks(
    scene: Scene, phase: int, width: int, height: int, samples: int, block: int, seed: int
) -> list[Block]:
    """Monte Carlo means with area lights: `samples` rays a pixel, jittered, each with stratified random light points.

    The variance comes from the spread within each pixel (the pixels are strata), summed over the block.
    """
    job = _Rows(scene, phase, width, height, samples, seed)
    rows = _map(_soft_row, [(job, y) for y in range(height)])
    blocks = []
    for y0 in range(0, height, block):
        for x0 in range(0, width, block):
            blocks.append(_block(rows, x0, y0, block, width, height, samples))
    return blocks


def blocks_as_json(blocks: list[Block]) -> list[dict]:
    """Blocks as plain dictionaries."""
    return [asdict(b) for b in blocks]


def _map(function, jobs: list) -> list:
    with multiprocessing.Pool(PROCESSES) as pool:
        return pool.map(function, jobs, chunksize=8)


def _center_row(job_and_y: tuple[_Rows, int]) -> array:
    job, y = job_and_y
    tracer = Tracer(job.scene, job.phase)
    frame = camera_frame(job.scene.camera, job.width / job.height)
    row, v = array("d"), (y + 0.5) / job.height
    for x in range(job.width):
        row.extend(tracer.camera_ray(frame, (x + 0.5) / job.width, v, CENTER))
    return row


def _soft_row(job_and_y: tuple[_Rows, int]) -> array:
    """Per pixel six numbers: mean and variance of the mean, by channel."""
    job, y = job_and_y
    tracer = Tracer(job.scene, job.phase)
    frame = camera_frame(job.scene.camera, job.width / job.height)
    uniform = random.Random(job.seed * 1_000_003 + y).random
    n, row = job.samples, array("d")
    cells = [(i, j) for i in range(LIGHT_GRID) for j in range(LIGHT_GRID)]
    for x in range(job.width):
        colors = []
        for _ in range(n):
            u, v = (x + uniform()) / job.width, (y + uniform()) / job.height
            points = tuple(((i + uniform()) / LIGHT_GRID, (j + uniform()) / LIGHT_GRID) for i, j in cells)
            colors.append(tracer.camera_ray(frame, u, v, points))
        means = [sum(c[k] for c in colors) / n for k in range(3)]
        row.extend(means)
        row.extend(sum((c[k] - means[k]) ** 2 for c in colors) / ((n - 1) * n) for k in range(3))
    return row


def _block(rows: list[array], x0: int, y0: int, size: int, width: int, height: int, samples: int) -> Block:
    mean, variance, pixels = [0.0] * 3, [0.0] * 3, 0
    for y in range(y0, min(y0 + size, height)):
        for x in range(x0, min(x0 + size, width)):
            pixels += 1
            for k in range(3):
                mean[k] += rows[y][6 * x + k]
                variance[k] += rows[y][6 * x + 3 + k]
    means, variances = [m / pixels for m in mean], [v / pixels**2 for v in variance]
    return Block(x0, y0, means, variances, pixels * samples)
