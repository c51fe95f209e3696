"""Plain data of the oracle: what a scene is, before anything is traced.

All vectors are tuples of three floats. Lengths are metres, angles degrees, colours linear Rec.709.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Union

Vec = tuple[float, float, float]

BLACK: Vec = (0.0, 0.0, 0.0)
WHITE: Vec = (1.0, 1.0, 1.0)


def add(a: Vec, b: Vec) -> Vec:
    """Sum of two vectors."""
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


def sub(a: Vec, b: Vec) -> Vec:
    """Difference `a - b`."""
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def scale(a: Vec, s: float) -> Vec:
    """Vector times number."""
    return (a[0] * s, a[1] * s, a[2] * s)


def dot(a: Vec, b: Vec) -> float:
    """Scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Vec, b: Vec) -> Vec:
    """Right-handed vector product."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def normalize(a: Vec) -> Vec:
    """Unit vector along `a`, which must not be zero."""
    return scale(a, 1.0 / math.sqrt(dot(a, a)))


@dataclass(frozen=True)
class Checker:
    """Chessboard over texture coordinates: an even cell shows `a`, an odd one `b`."""

    scale: tuple[float, float]
    a: Vec
    b: Vec

    def at(self, u: float, v: float) -> Vec:
        """Colour of the cell that holds (u, v)."""
        cell = math.floor(u * self.scale[0]) + math.floor(v * self.scale[1])
        return self.a if cell % 2 == 0 else self.b


Color = Union[Vec, Checker]


def color_at(color: Color, u: float, v: float) -> Vec:
    """Value of a constant or textured colour at texture coordinates (u, v)."""
    return color.at(u, v) if isinstance(color, Checker) else color


@dataclass(frozen=True)
class Material:
    """One material. `kind` is `phong`, `mirror` or `glass`; the Phong values hold for all three."""

    kind: str = "phong"
    diffuse: Color = WHITE
    specular: Color = BLACK
    ambient: Color = BLACK
    shininess: float = 16.0
    ior: float = 1.4


@dataclass(frozen=True)
class Sphere:
    """A closed sphere; its geometric normal points outward."""

    center: Vec
    radius: float
    material: Material


@dataclass(frozen=True)
class Quad:
    """The parallelogram origin + u side1 + v side2, u and v in [0, 1]; two-sided; normal side1 x side2."""

    origin: Vec
    side1: Vec
    side2: Vec
    material: Material


Shape = Union[Sphere, Quad]


@dataclass(frozen=True)
class Light:
    """A point light (`sides` is None) or a quad light. Never a surface, no falloff, shines all around."""

    origin: Vec
    color: Vec
    sides: tuple[Vec, Vec] | None = None

    def center(self) -> Vec:
        """The point that stands for the light in the Phong terms and in hard shadows."""
        if self.sides is None:
            return self.origin
        return add(self.origin, scale(add(self.sides[0], self.sides[1]), 0.5))

    def point(self, u: float, v: float) -> Vec:
        """Point of the light at (u, v) in the unit square."""
        if self.sides is None:
            return self.origin
        return add(self.origin, add(scale(self.sides[0], u), scale(self.sides[1], v)))


@dataclass(frozen=True)
class Camera:
    """Perspective camera. `fov` is vertical; `near` and `far` are depths along the viewing direction."""

    position: Vec = (0.0, 0.0, 6.1)
    target: Vec = BLACK
    up: Vec = (0.0, 1.0, 0.0)
    fov: float = 45.0
    near: float = 0.0
    far: float = math.inf

    def orbited(self, axis: str, degrees: float) -> Camera:
        """The camera after the world has been turned about the `x` or `y` axis through the origin.

        The course's view matrix is T(0, 0, -distance) R: turning the world by R moves the eye by R's inverse.
        """
        c, s = math.cos(math.radians(-degrees)), math.sin(math.radians(-degrees))

        def turn(p: Vec) -> Vec:
            if axis == "y":
                return (c * p[0] + s * p[2], p[1], -s * p[0] + c * p[2])
            return (p[0], c * p[1] - s * p[2], s * p[1] + c * p[2])

        return replace(self, position=turn(self.position), target=turn(self.target), up=turn(self.up))


@dataclass(frozen=True)
class Scene:
    """Everything that a picture depends on, apart from its size and the phase."""

    shapes: list[Shape]
    lights: list[Light]
    camera: Camera = field(default_factory=Camera)
    ambient: Vec = BLACK
    max_bounces: int = 10
