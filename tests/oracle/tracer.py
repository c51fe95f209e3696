"""Brute-force evaluation of the classic system in double precision: every ray meets every object.

Written from the description of the course system alone, on purpose the plainest possible way, so that it can judge
the renderer. Nothing here is shared with it.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from model import BLACK, Camera, Light, Material, Quad, Scene, Sphere, Vec, add, color_at, cross, dot, normalize
from model import scale, sub

# Camera rays accept depths beyond near * (1 + this): a wall that coincides with the near plane is cut away.
NEAR_SLACK = 1e-5
# Other rays ignore hits nearer than this, relative to the size of the coordinates.
SELF_HIT = 1e-9


# Points of the unit square, for each of which every light gets one shadow ray; the visible share is their mean.
LightPoints = tuple[tuple[float, float], ...]
CENTER: LightPoints = ((0.5, 0.5),)


class Fresnel(NamedTuple):
    """What a smooth boundary does to unpolarised light: share reflected, cosine of the refracted ray."""

    reflectance: float
    cos_t: float


def fresnel(cos_i: float, n_i: float, n_t: float) -> Fresnel:
    """Exact Fresnel equations. Under total internal reflection the share is 1 and `cos_t` 0."""
    sin2_t = (n_i / n_t) ** 2 * (1.0 - cos_i * cos_i)
    if sin2_t >= 1.0:
        return Fresnel(1.0, 0.0)
    cos_t = math.sqrt(1.0 - sin2_t)
    parallel = (n_t * cos_i - n_i * cos_t) / (n_t * cos_i + n_i * cos_t)
    across = (n_i * cos_i - n_t * cos_t) / (n_i * cos_i + n_t * cos_t)
    return Fresnel(0.5 * (parallel * parallel + across * across), cos_t)


def reflect(d: Vec, n: Vec) -> Vec:
    """Mirror direction of the travelling direction `d` at unit normal `n`."""
    return sub(d, scale(n, 2.0 * dot(d, n)))


def refract(d: Vec, n: Vec, eta: float, cos_i: float, cos_t: float) -> Vec:
    """Snell's law for the travelling direction `d`, `n` against it, eta = n_i / n_t."""
    return normalize(add(scale(d, eta), scale(n, eta * cos_i - cos_t)))


class CameraFrame(NamedTuple):
    """Camera in the form in which rays are made; right and up hold the half extent of the image at depth 1."""

    eye: Vec
    forward: Vec
    right: Vec
    up: Vec

    def direction(self, u: float, v: float) -> Vec:
        """Unit direction through image point (u, v), both in [0, 1], v = 0 at the top."""
        across, upward = 2.0 * u - 1.0, 1.0 - 2.0 * v
        return normalize(add(self.forward, add(scale(self.right, across), scale(self.up, upward))))


def camera_frame(camera: Camera, aspect: float) -> CameraFrame:
    """Frame of a perspective camera for an image of `aspect` = width / height."""
    forward = normalize(sub(camera.target, camera.position))
    right = normalize(cross(forward, camera.up))
    half = math.tan(math.radians(camera.fov) / 2.0)
    return CameraFrame(camera.position, forward, scale(right, half * aspect), scale(cross(right, forward), half))


class Hit(NamedTuple):
    """Nearest hit: point, unit geometric normal, texture coordinates, material."""

    point: Vec
    normal: Vec
    u: float
    v: float
    material: Material


class Tracer:
    """One scene in one phase (1 to 4), ready to be asked for colours of rays."""

    def __init__(self, scene: Scene, phase: int) -> None:
        self.scene = scene
        self.phase = phase
        # (centre, squared radius, index) and (normal, offset, row for u, row for v, index), all flat for speed.
        self.spheres = [
            (*s.center, s.radius**2, i) for i, s in enumerate(scene.shapes) if isinstance(s, Sphere)
        ]
        self.quads = [(*_quad_rows(s), i) for i, s in enumerate(scene.shapes) if isinstance(s, Quad)]

    def closest(self, o: Vec, d: Vec, t_min: float, t_max: float) -> Hit | None:
        """Nearest hit with t_min < t < t_max."""
        ox, oy, oz = o
        dx, dy, dz = d
        best, index, best_u, best_v = t_max, -1, 0.0, 0.0
        for cx, cy, cz, r2, i in self.spheres:
            t = _sphere_hit(ox - cx, oy - cy, oz - cz, dx, dy, dz, r2, t_min)
            if t < best:
                best, index = t, i
        for nx, ny, nz, n0, ax, ay, az, a0, bx, by, bz, b0, i in self.quads:
            facing = nx * dx + ny * dy + nz * dz
            if facing == 0.0:
                continue
            t = (n0 - nx * ox - ny * oy - nz * oz) / facing
            if t <= t_min or t >= best:
                continue
            x, y, z = ox + t * dx, oy + t * dy, oz + t * dz
            u = ax * x + ay * y + az * z - a0
            if 0.0 <= u <= 1.0:
                v = bx * x + by * y + bz * z - b0
                if 0.0 <= v <= 1.0:
                    best, index, best_u, best_v = t, i, u, v
        if index < 0:
            return None
        return self._hit(index, add(o, scale(d, best)), best_u, best_v)

    def _hit(self, index: int, point: Vec, u: float, v: float) -> Hit:
        shape = self.scene.shapes[index]
        if isinstance(shape, Sphere):
            return Hit(point, normalize(sub(point, shape.center)), u, v, shape.material)
        return Hit(point, normalize(cross(shape.side1, shape.side2)), u, v, shape.material)

    def hidden(self, p: Vec, q: Vec) -> bool:
        """Whether any surface lies between the surface point `p` and the light's point `q`."""
        ox, oy, oz = p
        dx, dy, dz = q[0] - ox, q[1] - oy, q[2] - oz
        t_min = self_hit(p) / math.sqrt(dx * dx + dy * dy + dz * dz)
        for cx, cy, cz, r2, _ in self.spheres:
            if _sphere_hit(ox - cx, oy - cy, oz - cz, dx, dy, dz, r2, t_min) < 1.0:
                return True
        for nx, ny, nz, n0, ax, ay, az, a0, bx, by, bz, b0, _ in self.quads:
            facing = nx * dx + ny * dy + nz * dz
            if facing == 0.0:
                continue
            t = (n0 - nx * ox - ny * oy - nz * oz) / facing
            if t <= t_min or t >= 1.0:
                continue
            x, y, z = ox + t * dx, oy + t * dy, oz + t * dz
            if 0.0 <= ax * x + ay * y + az * z - a0 <= 1.0 and 0.0 <= bx * x + by * y + bz * z - b0 <= 1.0:
                return True
        return False

    def camera_ray(self, frame: CameraFrame, u: float, v: float, light_at: LightPoints) -> Vec:
        """Colour seen through image point (u, v); shadow rays go to the points `light_at` of each light."""
        d = frame.direction(u, v)
        depth = dot(d, frame.forward)
        camera = self.scene.camera
        hit = self.closest(frame.eye, d, camera.near * (1.0 + NEAR_SLACK) / depth, camera.far / depth)
        return self.shade(d, hit, 0, light_at)

    def shade(self, d: Vec, hit: Hit | None, bounces: int, light_at: LightPoints) -> Vec:
        """Colour that a ray in direction `d`, which has bounced `bounces` times, brings from its hit."""
        if hit is None:
            return BLACK
        if self.phase == 1:
            return color_at(hit.material.diffuse, hit.u, hit.v)
        if self.phase >= 3 and hit.material.kind == "mirror":
            return self._mirror(d, hit, bounces, light_at)
        if self.phase >= 4 and hit.material.kind == "glass":
            return self._glass(d, hit, bounces, light_at)
        return self._phong(d, hit, light_at)

    def _follow(self, hit: Hit, d: Vec, bounces: int, light_at: LightPoints) -> Vec:
        return self.shade(d, self.closest(hit.point, d, self_hit(hit.point), math.inf), bounces + 1, light_at)

    def _mirror(self, d: Vec, hit: Hit, bounces: int, light_at: LightPoints) -> Vec:
        if bounces >= self.scene.max_bounces:
            return BLACK
        return self._follow(hit, reflect(d, hit.normal), bounces, light_at)

    def _glass(self, d: Vec, hit: Hit, bounces: int, light_at: LightPoints) -> Vec:
        if bounces >= self.scene.max_bounces:
            return BLACK
        entering = dot(d, hit.normal) < 0.0
        n = hit.normal if entering else scale(hit.normal, -1.0)
        n_i, n_t = (1.0, hit.material.ior) if entering else (hit.material.ior, 1.0)
        cos_i = min(1.0, -dot(d, n))
        share, cos_t = fresnel(cos_i, n_i, n_t)
        color = scale(self._follow(hit, reflect(d, n), bounces, light_at), share)
        if share < 1.0:
            through = self._follow(hit, refract(d, n, n_i / n_t, cos_i, cos_t), bounces, light_at)
            color = add(color, scale(through, 1.0 - share))
        return color

    def _phong(self, d: Vec, hit: Hit, light_at: LightPoints) -> Vec:
        material = hit.material
        n = hit.normal if dot(d, hit.normal) < 0.0 else scale(hit.normal, -1.0)
        kd = color_at(material.diffuse, hit.u, hit.v)
        ks = color_at(material.specular, hit.u, hit.v)
        ka = color_at(material.ambient, hit.u, hit.v)
        ia = self.scene.ambient
        r, g, b = ka[0] * ia[0], ka[1] * ia[1], ka[2] * ia[2]
        for light in self.scene.lights:
            to_light = normalize(sub(light.center(), hit.point))
            cosine = dot(n, to_light)
            if cosine <= 0.0:
                continue
            visible = sum(not self.hidden(hit.point, light.point(*at)) for at in light_at) / len(light_at)
            mirrored = sub(scale(n, 2.0 * cosine), to_light)
            lobe = max(0.0, -dot(mirrored, d)) ** material.shininess
            r += visible * light.color[0] * (kd[0] * cosine + ks[0] * lobe)
            g += visible * light.color[1] * (kd[1] * cosine + ks[1] * lobe)
            b += visible * light.color[2] * (kd[2] * cosine + ks[2] * lobe)
        return (r, g, b)


def self_hit(p: Vec) -> float:
    """Distance below which a ray that starts at `p` is taken to hit its own surface."""
    return SELF_HIT * (1.0 + max(abs(p[0]), abs(p[1]), abs(p[2])))


def _sphere_hit(
    ox: float, oy: float, oz: float, dx: float, dy: float, dz: float, r2: float, t_min: float
) -> float:
    """First t > t_min on a sphere about the origin, or infinity. The direction may have any length."""
    a = dx * dx + dy * dy + dz * dz
    half_b = ox * dx + oy * dy + oz * dz
    inside = half_b * half_b - a * (ox * ox + oy * oy + oz * oz - r2)
    if inside < 0.0:
        return math.inf
    root = math.sqrt(inside)
    t = (-half_b - root) / a
    if t > t_min:
        return t
    t = (-half_b + root) / a
    return t if t > t_min else math.inf


def _quad_rows(quad: Quad) -> tuple[float, ...]:
    """Plane n.p = n0 and the dual basis: u = a.p - a0, v = b.p - b0 for points of the plane."""
    n = cross(quad.side1, quad.side2)
    size2 = dot(n, n)
    a = scale(cross(quad.side2, n), 1.0 / size2)
    b = scale(cross(n, quad.side1), 1.0 / size2)
    return (*n, dot(n, quad.origin), *a, dot(a, quad.origin), *b, dot(b, quad.origin))
