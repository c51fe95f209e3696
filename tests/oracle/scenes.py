"""Scenes of the oracle: the course's built-in ones, and a reader for small scene files in TOML.

The reader takes spheres, quads, checker textures, the three classic materials and point and quad lights, and
refuses everything else, so that it can never leave out a part of a scene in silence.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

from model import BLACK, WHITE, Camera, Checker, Color, Light, Material, Quad, Scene, Shape, Sphere, Vec

HERE = Path(__file__).resolve().parent
COURSE_CAMERA = Camera(near=4.1, far=10000.0)
COURSE_POINT = Light((-5.0, 5.0, 5.0), WHITE)
OWN_SCENES = ("checker-mirror", "checker-glass")


class SceneError(Exception):
    """A scene that the oracle does not know or cannot express."""


def _sphere(as_given: bool) -> Scene:
    kind = "mirror" if as_given else "phong"
    material = Material(kind, WHITE, (0.2, 0.2, 0.2), shininess=20.0)
    return Scene([Sphere(BLACK, 1.0, material)], [COURSE_POINT], COURSE_CAMERA)


def _square() -> Scene:
    gray = (0.8, 0.8, 0.8)
    quad = Quad((-1.0, -1.0, 0.0), (2.0, 0.0, 0.0), (0.0, 2.0, 0.0), Material("phong", gray, gray, shininess=20.0))
    return Scene([quad], [COURSE_POINT], COURSE_CAMERA)


def _wall(origin: Vec, side1: Vec, side2: Vec, color: Vec) -> Quad:
    return Quad(origin, side1, side2, Material("phong", color, color, shininess=16.0))


def _cornell(as_given: bool) -> Scene:
    x, y, z = (4.0, 0.0, 0.0), (0.0, 4.0, 0.0), (0.0, 0.0, 4.0)
    red, green = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)
    walls: list[Shape] = [
        _wall((-2.0, -2.0, -2.0), x, y, WHITE),  # back, normal +z
        _wall((-2.0, -2.0, -2.0), y, z, red),  # left, normal +x
        _wall((2.0, -2.0, -2.0), z, y, green),  # right, normal -x
        _wall((-2.0, -2.0, -2.0), z, x, WHITE),  # floor, normal +y
        _wall((-2.0, 2.0, -2.0), x, z, WHITE),  # ceiling, normal -y
        _wall((-2.0, -2.0, 2.0), y, x, WHITE),  # front, normal -z
    ]
    # The base's types are swapped against its comments, and its glass has index 0, for which 1e-6 stands as limit.
    right = Material("mirror" if as_given else "glass", red, red, shininess=16.0, ior=1.4)
    left = Material("glass" if as_given else "mirror", WHITE, WHITE, shininess=16.0, ior=1e-6)
    balls: list[Shape] = [Sphere((1.0, -1.25, 0.5), 0.75, right), Sphere((-1.0, -1.25, -0.5), 0.75, left)]
    light = Light((-0.5, 1.5, -0.5), WHITE, ((1.0, 0.0, 0.0), (0.0, 0.0, 1.0)))
    return Scene(walls + balls, [light], COURSE_CAMERA)


def load(name: str) -> Scene:
    """A built-in scene, one of the oracle's own scenes, or a `.toml` file. Raises SceneError."""
    builtin = {
        "sphere": lambda: _sphere(False),
        "sphere-as-given": lambda: _sphere(True),
        "square": _square,
        "cornell": lambda: _cornell(False),
        "cornell-as-given": lambda: _cornell(True),
    }
    if name in builtin:
        return builtin[name]()
    if name in OWN_SCENES:
        return read_toml(own_path(name))
    if name.endswith(".toml"):
        return read_toml(Path(name))
    raise SceneError(f"unknown scene '{name}': {', '.join([*builtin, *OWN_SCENES])} or a .toml file")


def own_path(name: str) -> Path:
    """File of one of the oracle's own scenes."""
    return HERE / "scenes" / f"{name}.toml"


def read_toml(path: Path) -> Scene:
    """Reads the part of the native scene format that the oracle can express. Raises SceneError."""
    try:
        import tomllib
    except ImportError as error:
        raise SceneError("reading scene files needs Python 3.11 or newer (tomllib)") from error
    with open(path, "rb") as file:
        return _Reader(str(path), tomllib.load(file)).scene()


class _Reader:
    """Turns the tables of one file into a scene."""

    def __init__(self, path: str, tables: dict[str, Any]) -> None:
        self.path = path
        self.tables = tables

    def scene(self) -> Scene:
        known = {"penombre", "render", "integrator", "camera", "texture", "material", "shape", "light"}
        self._only("file", self.tables, known)
        textures = {n: self._checker(n, t) for n, t in self.tables.get("texture", {}).items()}
        materials = {n: self._material(n, t, textures) for n, t in self.tables.get("material", {}).items()}
        shapes = [self._shape(n, t, materials) for n, t in self.tables.get("shape", {}).items()]
        lights = [self._light(n, t) for n, t in self.tables.get("light", {}).items()]
        cameras = [self._camera(n, t) for n, t in self.tables.get("camera", {}).items()]
        if len(cameras) != 1:
            raise SceneError(f"{self.path}: expected one camera, found {len(cameras)}")
        classic = dict(self.tables.get("integrator", {}).get("classic", {}))
        self._only("classic", classic, {"phase", "hard_shadows", "ambient", "max_bounces"})
        return Scene(shapes, lights, cameras[0], _vec(classic.get("ambient", BLACK)), classic.get("max_bounces", 10))

    def _only(self, where: str, table: dict[str, Any], known: set[str]) -> None:
        unknown = set(table) - known
        if unknown:
            raise SceneError(f"{self.path}: {where}: the oracle does not know {', '.join(sorted(unknown))}")

    def _type(self, where: str, table: dict[str, Any], known: dict[str, set[str]]) -> str:
        kind = table.get("type")
        if kind not in known:
            raise SceneError(f"{self.path}: {where}: type {kind!r} is none of {', '.join(known)}")
        self._only(where, table, known[kind] | {"type"})
        return kind

    def _checker(self, name: str, table: dict[str, Any]) -> Checker:
        self._type(name, table, {"checker": {"scale", "a", "b"}})
        su, sv = table["scale"]
        return Checker((float(su), float(sv)), _vec(table["a"]), _vec(table["b"]))

    def _material(self, name: str, table: dict[str, Any], textures: dict[str, Checker]) -> Material:
        phong = {"diffuse", "specular", "ambient", "shininess"}
        kind = self._type(name, table, {"phong": phong, "mirror": phong, "glass": phong | {"ior"}})

        def color(key: str, default: Vec) -> Color:
            value = table.get(key, default)
            return textures[value["texture"]] if isinstance(value, dict) else _vec(value)

        made = Material(kind, color("diffuse", WHITE), color("specular", BLACK), color("ambient", BLACK))
        return replace(made, shininess=float(table.get("shininess", 16.0)), ior=float(table.get("ior", 1.4)))

    def _shape(self, name: str, table: dict[str, Any], materials: dict[str, Material]) -> Shape:
        known = {"sphere": {"center", "radius", "material"}, "quad": {"origin", "sides", "material"}}
        kind = self._type(name, table, known)
        material = materials[table["material"]]
        if kind == "quad":
            return Quad(_vec(table["origin"]), *map(_vec, table["sides"]), material)
        if any(isinstance(c, Checker) for c in (material.diffuse, material.specular, material.ambient)):
            raise SceneError(f"{self.path}: {name}: a textured sphere has no agreed texture coordinates here")
        return Sphere(_vec(table["center"]), float(table["radius"]), material)

    def _light(self, name: str, table: dict[str, Any]) -> Light:
        quad = {"origin", "sides", "color", "radiance", "shadow_samples"}
        kind = self._type(name, table, {"point": {"position", "color"}, "quad": quad})
        if kind == "point":
            return Light(_vec(table["position"]), _vec(table["color"]))
        side1, side2 = map(_vec, table["sides"])
        return Light(_vec(table["origin"]), _vec(table["color"]), (side1, side2))

    def _camera(self, name: str, table: dict[str, Any]) -> Camera:
        self._type(name, table, {"perspective": {"position", "target", "up", "fov", "near", "far"}})
        vectors = {k: _vec(table[k]) for k in ("position", "target", "up") if k in table}
        return Camera(**vectors, **{k: float(table[k]) for k in ("fov", "near", "far") if k in table})


def _vec(value: Any) -> Vec:
    if len(value) != 3:
        raise SceneError(f"expected three numbers, found {value!r}")
    return (float(value[0]), float(value[1]), float(value[2]))
