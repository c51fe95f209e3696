"""Unit tests of the picture readers. Run: python3 -m unittest discover tests/window"""

from __future__ import annotations

import random
import struct
import sys
import tempfile
import unittest
import zlib
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))

from pictures import Picture, _chunk, _paeth, read_course_ppm, read_png, write_png  # noqa: E402


def noise(width: int, height: int) -> Picture:
    return Picture(width, height, random.Random(1).randbytes(3 * width * height))


def filtered(picture: Picture) -> bytes:
    """Rows with the five filters of PNG in turn, by the definition of the format."""
    row, body = 3 * picture.width, bytearray()
    for y in range(picture.height):
        kind = y % 5
        body.append(kind)
        for i in range(row):
            at = y * row + i
            left = picture.data[at - 3] if i >= 3 else 0
            above = picture.data[at - row] if y else 0
            corner = picture.data[at - row - 3] if y and i >= 3 else 0
            guess = (0, left, above, (left + above) // 2, _paeth(left, above, corner))[kind]
            body.append((picture.data[at] - guess) & 255)
    return bytes(body)


class Files(unittest.TestCase):
    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.path = Path(folder.name) / "picture"

    def test_png_comes_back(self) -> None:
        picture = noise(7, 5)
        write_png(self.path, picture)
        self.assertEqual(read_png(self.path), picture)

    def test_all_filters_of_png_are_undone(self) -> None:
        picture = noise(9, 11)
        write_png(self.path, picture)
        whole = self.path.read_bytes()
        body = zlib.compress(filtered(picture))
        split = len(body) // 2
        chunks = [_chunk(b"IDAT", body[:split]), _chunk(b"IDAT", body[split:]), _chunk(b"IEND", b"")]
        self.path.write_bytes(whole[:33] + b"".join(chunks))
        self.assertEqual(read_png(self.path), picture)

    def test_paeth_prefers_left_then_above(self) -> None:
        self.assertEqual([_paeth(10, 20, 20), _paeth(20, 10, 20), _paeth(10, 10, 10)], [10, 10, 10])
        self.assertEqual([_paeth(0, 10, 5), _paeth(1, 2, 0), _paeth(9, 1, 5)], [5, 2, 5])

    def test_broken_png_is_refused(self) -> None:
        write_png(self.path, noise(4, 4))
        whole = self.path.read_bytes()
        deeper = whole[:24] + struct.pack("B", 16) + whole[25:]
        for broken in (whole[:-1], whole[:40] + b"x" + whole[41:], b"P6", deeper):
            self.path.write_bytes(broken)
            with self.assertRaises(ValueError):
                read_png(self.path)

    def test_course_ppm_is_read_to_the_letter(self) -> None:
        self.path.write_text("P3\n2 1\n255\n1 2 3 4 5 255 \n")
        self.assertEqual(read_course_ppm(self.path), Picture(2, 1, bytes([1, 2, 3, 4, 5, 255])))
        departures = ["P3\n2 1\n255\n1 2 3 4 5 255\n", "P3\n2 1\n255\n1 2 3 4 5 \n", "P3\n2 1\n255\n1 2 3\n4 5 6 \n"]
        for text in [*departures, "P3\n2 1\n255\n1 2 3 4 5 6 ", "P3\n2 1\n255\n1 2 3 4 5 256 \n"]:
            self.path.write_text(text)
            with self.assertRaises(ValueError):
                read_course_ppm(self.path)


class Pixels(unittest.TestCase):
    def test_screens_have_blue_first_and_padded_rows(self) -> None:
        row = bytes([3, 2, 1, 0, 6, 5, 4, 0])
        expected = Picture(2, 2, bytes([1, 2, 3, 4, 5, 6]) * 2)
        self.assertEqual(Picture.of_bgrx(2, 2, row + row), expected)
        self.assertEqual(Picture.of_bgrx(2, 2, (row + b"pad!") * 2), expected)

    def test_parts(self) -> None:
        picture = Picture(3, 2, bytes(range(18)))
        self.assertEqual(picture.part(1, 1, 2, 1), Picture(2, 1, bytes(range(12, 18))))

    def test_differences(self) -> None:
        a, b = Picture(2, 1, bytes([0, 0, 0, 9, 9, 9])), Picture(2, 1, bytes([0, 0, 0, 9, 7, 9]))
        self.assertEqual((a.largest_difference(b), a.share_different(b)), (2, 0.5))
        self.assertEqual((a.largest_difference(a), a.share_different(a)), (0, 0.0))
        other = Picture(1, 2, a.data)
        self.assertEqual((a.largest_difference(other), a.share_different(other)), (256, 1.0))


if __name__ == "__main__":
    unittest.main()
