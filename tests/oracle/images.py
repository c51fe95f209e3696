"""Float images, and the two file formats that the oracle needs: PFM (exact) and PNG (to look at)."""

from __future__ import annotations

import struct
import sys
import zlib
from array import array
from dataclasses import dataclass
from pathlib import Path


@dataclass
class Image:
    """Linear RGB, rows from top to bottom, three numbers a pixel."""

    width: int
    height: int
    data: array

    def pixel(self, x: int, y: int) -> tuple[float, float, float]:
        """Colour of pixel (x, y), y = 0 at the top."""
        i = 3 * (y * self.width + x)
        return (self.data[i], self.data[i + 1], self.data[i + 2])


def write_pfm(path: Path, image: Image) -> None:
    """Writes 32-bit floats, little endian, rows from bottom to top as the format asks."""
    row = 3 * image.width
    with open(path, "wb") as file:
        file.write(f"PF\n{image.width} {image.height}\n-1.0\n".encode())
        for y in reversed(range(image.height)):
            floats = array("f", image.data[y * row : (y + 1) * row])
            if sys.byteorder == "big":
                floats.byteswap()
            file.write(floats.tobytes())


def read_pfm(path: Path) -> Image:
    """Reads a colour PFM of either byte order. Raises ValueError on anything else."""
    with open(path, "rb") as file:
        magic = file.readline().strip()
        width, height = map(int, file.readline().split())
        big_endian = float(file.readline()) > 0.0
        floats = array("f")
        floats.frombytes(file.read())
    if magic != b"PF" or len(floats) != 3 * width * height:
        raise ValueError(f"{path}: no colour PFM of {width} x {height}: {magic!r}, {len(floats)} numbers")
    if big_endian != (sys.byteorder == "big"):
        floats.byteswap()
    data, row = array("f"), 3 * width
    for y in reversed(range(height)):
        data.extend(floats[y * row : (y + 1) * row])
    return Image(width, height, data)


def write_png(path: Path, image: Image) -> None:
    """Writes 8 bits a channel, round(255 clamp(c)), no gamma: the look of the course's own files."""
    row = 3 * image.width
    body = bytearray()
    for y in range(image.height):
        body.append(0)  # filter type: none
        body.extend(int(255.0 * min(1.0, max(0.0, c)) + 0.5) for c in image.data[y * row : (y + 1) * row])

    def chunk(tag: bytes, content: bytes) -> bytes:
        return struct.pack(">I", len(content)) + tag + content + struct.pack(">I", zlib.crc32(tag + content))

    header = struct.pack(">IIBBBBB", image.width, image.height, 8, 2, 0, 0, 0)
    with open(path, "wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header))
        file.write(chunk(b"IDAT", zlib.compress(bytes(body), 6)) + chunk(b"IEND", b""))
