#!/usr/bin/env python3
"""Makes sky.hdr, the small sky of the scenes in this folder: sky.py > sky.hdr

64 × 32 texels, equirectangular, Radiance RGBE without run lengths. A late afternoon: blue above, warm at the horizon, brown
ground, a broad bright cloud and a sun of a few texels.
"""
import math
import sys

WIDTH, HEIGHT = 64, 32
SUN = (-0.55, 0.6, 0.58)
CLOUD = (0.8, 0.45, 0.4)


def radiance(d):
    """W/(sr·m²) by channel from the unit direction d, y up."""
    up = d[1]
    if up < 0:
        return (0.16, 0.13, 0.11)
    share = math.sqrt(up)
    color = [a + (b - a) * share for a, b in zip((1.0, 0.82, 0.66), (0.22, 0.38, 0.8))]
    for axis, width, light in ((SUN, 0.995, (260, 215, 150)), (CLOUD, 0.9, (1.6, 1.5, 1.45))):
        length = math.sqrt(sum(a * a for a in axis))
        cosine = sum(a * b for a, b in zip(axis, d)) / length
        edge = min(max((cosine - width) / (1 - width) * 2, 0.0), 1.0)
        smooth = edge * edge * (3 - 2 * edge)
        color = [c + smooth * l for c, l in zip(color, light)]
    return color


def rgbe(color):
    most = max(color)
    mantissa, exponent = math.frexp(most)
    scale = mantissa * 256 / most
    return bytes([int(c * scale) for c in color] + [exponent + 128])


def main():
    out = sys.stdout.buffer
    out.write(b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y %d +X %d\n" % (HEIGHT, WIDTH))
    for j in range(HEIGHT):
        theta = (j + 0.5) / HEIGHT * math.pi
        for i in range(WIDTH):
            phi = ((i + 0.5) / WIDTH - 0.5) * 2 * math.pi
            d = (math.sin(theta) * math.sin(phi), math.cos(theta), -math.sin(theta) * math.cos(phi))
            out.write(rgbe(radiance(d)))


main()
