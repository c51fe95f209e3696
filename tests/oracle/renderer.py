"""The renderer under test, as a command that writes PFM files."""

from __future__ import annotations

import subprocess
from pathlib import Path

from images import Image, read_pfm

LIMIT_S = 300


class RendererError(Exception):
    """The command failed, ran too long or wrote no readable image."""


class Renderer:
    """The `penombre` command and the folder that takes its images."""

    def __init__(self, binary: Path, folder: Path) -> None:
        self.binary = binary
        self.folder = folder
        self.count = 0

    def render(self, scene: str, options: list[str]) -> Image:
        """Image of `penombre render SCENE options`. Raises RendererError with the command in its text."""
        self.count += 1
        output = self.folder / f"{self.count:03}-{Path(scene).stem}.pfm"
        command = [str(self.binary), "render", scene, *options, "--no-progress", "-o", str(output)]
        said = " ".join(command)
        try:
            done = subprocess.run(command, capture_output=True, text=True, timeout=LIMIT_S, check=False)
        except (OSError, subprocess.TimeoutExpired) as error:
            raise RendererError(f"{said}: {error}") from error
        if done.returncode != 0:
            raise RendererError(f"{said}: exit status {done.returncode}: {done.stderr.strip()[-800:]}")
        try:
            return read_pfm(output)
        except (OSError, ValueError) as error:
            raise RendererError(f"{said}: {error}") from error
