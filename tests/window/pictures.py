"""8-bit pictures, and the two file formats that the window writes at `r`: PPM as the course does, and PNG."""

from __future__ import annotations

import struct
import zlib
from dataclasses import dataclass
from pathlib import Path

_PNG_MAGIC = b"\x89PNG\r\n\x1a\n"
_RGB_HEADER = (8, 2, 0, 0, 0)  # bits a channel, colour type RGB, compression, filter, no interlace
_CHANNELS = 3


@dataclass(frozen=True)
class Picture:
    """RGB, rows from top to bottom, three bytes a pixel."""

    width: int
    height: int
    data: bytes

    @staticmethod
    def of_bgrx(width: int, height: int, raw: bytes) -> Picture:
        """A picture of rows of four bytes a pixel: blue, green, red, nothing."""
        rgb = bytearray(_CHANNELS * width * height)
        row = len(raw) // height
        packed = raw if row == 4 * width else b"".join(raw[y * row :][: 4 * width] for y in range(height))
        rgb[0::3], rgb[1::3], rgb[2::3] = packed[2::4], packed[1::4], packed[0::4]
        return Picture(width, height, bytes(rgb))

    def part(self, x: int, y: int, width: int, height: int) -> Picture:
        """A rectangle of the picture, which must lie inside it."""
        row = _CHANNELS * self.width
        start, length = _CHANNELS * x, _CHANNELS * width
        rows = (self.data[line * row + start :][:length] for line in range(y, y + height))
        return Picture(width, height, b"".join(rows))

    def largest_difference(self, other: Picture) -> int:
        """Of all channels; 256 if the sizes differ."""
        if (self.width, self.height) != (other.width, other.height):
            return 256
        return max((abs(a - b) for a, b in zip(self.data, other.data)), default=0)

    def share_different(self, other: Picture) -> float:
        """Share of the pixels that differ, 0 to 1; 1 if the sizes differ."""
        if (self.width, self.height) != (other.width, other.height):
            return 1.0
        if self.data == other.data:
            return 0.0
        pixels = range(0, len(self.data), _CHANNELS)
        different = sum(self.data[i : i + _CHANNELS] != other.data[i : i + _CHANNELS] for i in pixels)
        return different / (self.width * self.height)


def read_course_ppm(path: Path) -> Picture:
    """Reads the course's PPM, to the letter: three lines of header, then all numbers on one line, each with a blank
    behind it. Raises ValueError if the file departs from that or is not complete."""
    lines = path.read_text(encoding="ascii").split("\n")
    if len(lines) != 5 or lines[0] != "P3" or lines[2] != "255" or lines[4] != "":
        raise ValueError(f"{path}: {len(lines)} lines that begin with {lines[:3]}: not the course's PPM")
    width, height = map(int, lines[1].split(" "))
    numbers = lines[3].split(" ")
    if numbers.pop() != "" or len(numbers) != _CHANNELS * width * height:
        raise ValueError(f"{path}: {len(numbers)} numbers for {width} x {height} pixels")
    return Picture(width, height, bytes(map(int, numbers)))


def write_png(path: Path, picture: Picture) -> None:
    """Writes a picture to look at."""
    row = _CHANNELS * picture.width
    body = b"".join(b"\0" + picture.data[i : i + row] for i in range(0, len(picture.data), row))
    header = struct.pack(">IIBBBBB", picture.width, picture.height, *_RGB_HEADER)
    chunks = [(b"IHDR", header), (b"IDAT", zlib.compress(body, 6)), (b"IEND", b"")]
    path.write_bytes(_PNG_MAGIC + b"".join(_chunk(tag, content) for tag, content in chunks))


def read_png(path: Path) -> Picture:
    """Reads a PNG of 8 bits a channel, RGB, not interlaced. Raises ValueError on anything else or a broken file."""
    raw = path.read_bytes()
    chunks = _chunks(path, raw)
    if not chunks or chunks[0][0] != b"IHDR" or chunks[-1][0] != b"IEND":
        raise ValueError(f"{path}: no complete PNG")
    width, height, *rest = struct.unpack(">IIBBBBB", chunks[0][1])
    if tuple(rest) != _RGB_HEADER:
        raise ValueError(f"{path}: not plain RGB of 8 bits: {rest}")
    body = zlib.decompress(b"".join(content for tag, content in chunks if tag == b"IDAT"))
    row = _CHANNELS * width
    if len(body) != height * (row + 1):
        raise ValueError(f"{path}: {len(body)} bytes for {width} x {height} pixels")
    above, data = bytes(row), bytearray()
    for y in range(height):
        line = body[y * (row + 1) : (y + 1) * (row + 1)]
        above = _unfiltered(line[0], line[1:], above)
        data += above
    return Picture(width, height, bytes(data))


def _chunk(tag: bytes, content: bytes) -> bytes:
    return struct.pack(">I", len(content)) + tag + content + struct.pack(">I", zlib.crc32(tag + content))


def _chunks(path: Path, raw: bytes) -> list[tuple[bytes, bytes]]:
    if not raw.startswith(_PNG_MAGIC):
        raise ValueError(f"{path}: no PNG")
    found, at = [], len(_PNG_MAGIC)
    while at + 12 <= len(raw):
        (length,) = struct.unpack_from(">I", raw, at)
        tag, content = raw[at + 4 : at + 8], raw[at + 8 : at + 8 + length]
        if raw[at : at + 12 + length] != _chunk(tag, content):
            raise ValueError(f"{path}: chunk {tag!r} is broken")
        found.append((tag, content))
        at += 12 + length
    return found


def _unfiltered(kind: int, line: bytes, above: bytes) -> bytes:
    """Undoes the filter of one row; `above` is the row before, undone."""
    if kind == 0:
        return line
    out = bytearray(line)
    for i, byte in enumerate(line):
        left, corner = (out[i - _CHANNELS], above[i - _CHANNELS]) if i >= _CHANNELS else (0, 0)
        guess = (left, above[i], (left + above[i]) // 2, _paeth(left, above[i], corner))[kind - 1]
        out[i] = (byte + guess) & 255
    return bytes(out)


def _paeth(left: int, above: int, corner: int) -> int:
    """Of the three neighbours, the one nearest to left + above - corner."""
    estimate = left + above - corner
    return min((left, above, corner), key=lambda value: abs(estimate - value))
