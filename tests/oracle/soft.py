"""Soft shadows: the renderer's block means against the oracle's, as a statistical test.

Both sides estimate the same integral over pixel area and light, so the difference of two block means, squared,
over the sum of both variances follows a chi-squared law with one degree of freedom for every block. The oracle's
variance comes from the spread within its pixels, the renderer's from the spread of each pixel over runs with different seeds. Were
the renderer's pixels correlated, the means of whole blocks would spread more from run to run than their pixels say:
that ratio is measured, and a ratio above 1 scales the variance up.

The oracle's few samples may miss a rare event altogether (a sliver of another wall at a block's edge) and then claim
no variance. The spread of many one-sample pictures of the renderer, with as many samples a pixel as the oracle took, is
therefore a lower bound of the oracle's variance.

Measured power of the quick size: a light moved by 1 cm or a tenth smaller fails, one a twentieth smaller passes.
"""

from __future__ import annotations

import math
from array import array
from collections.abc import Iterator
from dataclasses import dataclass

import rendering
import scenes
from chi2 import chi2_tail
from images import Image
from renderer import Renderer

ALPHA = 0.01
# Pictures of one sample a pixel whose spread bounds the oracle's variance from below.
SINGLE_RUNS = 24
# Added to every variance: rounding to 32 bits, and events too rare to be seen in any run (1/100 of an 8-bit step).
FLOOR = 4e-5**2
# Blocks whose variance is below the floor (black, or evenly lit) must simply be equal to this.
STILL = 1e-3


@dataclass(frozen=True)
class SoftCheck:
    """Size of the test: image edge, oracle's rays a pixel, runs of the renderer, their samples, one long run's.

    `blocks` are edges of blocks in pixels. Those of 16 are smaller than a penumbra is wide: what a wrong light adds on
    one side of a shadow's edge it takes away on the other, and a block that covers both sees nothing.
    """

    edge: int
    oracle_samples: int
    seeds: int
    spp: int
    long_spp: int
    blocks: tuple[int, ...]

    @property
    def tests(self) -> int:
        """Number of chi-squared tests: three channels, short runs and a long one, every size of block."""
        return 6 * len(self.blocks)


@dataclass
class _Estimate:
    """Mean by block, and the variance of that mean."""

    mean: list[float]
    variance: list[float]


def compare_soft(renderer: Renderer, check: SoftCheck) -> Iterator[tuple[str, bool, str]]:
    """Name, verdict and figure for each channel: many short runs with different seeds, then one long run."""
    runs = [_run(renderer, check, seed, check.spp) for seed in range(1, check.seeds + 1)]
    long = _run(renderer, check, 99, check.long_spp)
    single = [_run(renderer, check, 100 + seed, 1) for seed in range(SINGLE_RUNS)]
    for block in check.blocks:
        yield from _compare_blocks(runs, long, single, check, block)


def _compare_blocks(
    runs: list[Image], long: Image, single: list[Image], check: SoftCheck, block: int
) -> Iterator[tuple[str, bool, str]]:
    scene = scenes.load("cornell")
    blocks = rendering.soft_blocks(scene, 2, check.edge, check.edge, check.oracle_samples, block, seed=1)
    for channel, color in enumerate(("red", "green", "blue")):
        spread, _ = _from_runs(single, channel, check.edge, block)
        least = [v * SINGLE_RUNS / check.oracle_samples for v in spread.variance]
        variance = [max(b.variance[channel], v) for b, v in zip(blocks, least)]
        oracle = _Estimate([b.mean[channel] for b in blocks], variance)
        short, ratio = _from_runs(runs, channel, check.edge, block)
        verdict, figure = _chi2(short, oracle, check.tests)
        name = f"soft shadows, {block} x {block} blocks, {color}, {check.seeds} x {check.spp} samples"
        yield name, verdict, f"{figure}, spread of blocks {ratio:.2f} of their pixels'"
        # A longer run of the same estimator spreads at most as much as the mean of as many separate samples.
        share = check.seeds * check.spp / check.long_spp
        longer = _Estimate(_block_means(long, channel, check.edge, block), [v * share for v in short.variance])
        yield f"soft shadows, {block} x {block} blocks, {color}, 1 x {check.long_spp} samples", *_chi2(longer, oracle, check.tests)


def _run(renderer: Renderer, check: SoftCheck, seed: int, spp: int) -> Image:
    size = f"{check.edge}x{check.edge}"
    options = ["--integrator", "classic", "--phase", "2", "--size", size, "--spp", str(spp), "--seed", str(seed)]
    return renderer.render("cornell", options)


def _blocks_of(values: array, edge: int, block: int) -> list[float]:
    """Sums of one value a pixel over the blocks, row by row of blocks."""
    across = -(-edge // block)
    sums = [0.0] * (across * across)
    for y in range(edge):
        row = values[y * edge : (y + 1) * edge]
        for i in range(across):
            sums[y // block * across + i] += sum(row[i * block : (i + 1) * block])
    return sums


def _pixels_of(edge: int, block: int) -> list[float]:
    return _blocks_of(array("d", [1.0]) * (edge * edge), edge, block)


def _block_means(image: Image, channel: int, edge: int, block: int) -> list[float]:
    sums = _blocks_of(image.data[channel::3], edge, block)
    return [s / n for s, n in zip(sums, _pixels_of(edge, block))]


def _from_runs(runs: list[Image], channel: int, edge: int, block: int) -> tuple[_Estimate, float]:
    """Mean over the runs with its variance, and how much more the blocks spread than their pixels say."""
    n = len(runs)
    spreads = array("d")
    for values in zip(*(r.data[channel::3] for r in runs)):
        mean = sum(values) / n
        spreads.append(sum((v - mean) ** 2 for v in values) / (n - 1))
    by_pixels = [s / m**2 for s, m in zip(_blocks_of(spreads, edge, block), _pixels_of(edge, block))]
    by_run = list(zip(*(_block_means(r, channel, edge, block) for r in runs)))
    means = [sum(b) / n for b in by_run]
    by_blocks = [sum((v - m) ** 2 for v in b) / (n - 1) for b, m in zip(by_run, means)]
    ratios = [b / p for b, p in zip(by_blocks, by_pixels) if p > FLOOR / 100.0]
    ratio = sum(ratios) / len(ratios) if ratios else 1.0
    return _Estimate(means, [v * max(1.0, ratio) / n for v in by_pixels]), ratio


def _chi2(found: _Estimate, expected: _Estimate, tests: int) -> tuple[bool, str]:
    """Verdict at the level that Šidák's rule gives each of the tests, and its figure."""
    statistic, degrees, still_worst = 0.0, 0, 0.0
    for a, b, va, vb in zip(found.mean, expected.mean, found.variance, expected.variance):
        if va + vb < FLOOR:
            still_worst = max(still_worst, abs(a - b))
        else:
            statistic += (a - b) ** 2 / (va + vb + FLOOR)
            degrees += 1
    level = 1.0 - (1.0 - ALPHA) ** (1.0 / tests)
    p = chi2_tail(statistic, degrees) if degrees else 1.0
    finite = all(math.isfinite(v) for v in found.mean)
    figure = f"chi2 {statistic:.1f} on {degrees} blocks, p = {p:.4f} (limit {level:.4f})"
    if degrees < len(found.mean):
        figure += f", {len(found.mean) - degrees} still blocks apart by {still_worst:.1e}"
    return finite and p >= level and still_worst <= STILL, figure
