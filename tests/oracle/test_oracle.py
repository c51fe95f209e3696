"""Unit tests of the oracle itself, against closed forms. Run: python3 -m unittest discover tests/oracle"""

from __future__ import annotations

import math
import sys
import tempfile
import unittest
from array import array
from dataclasses import replace
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))

import rendering  # noqa: E402
import scenes  # noqa: E402
from chi2 import chi2_tail  # noqa: E402
from images import Image, read_pfm, write_pfm, write_png  # noqa: E402
from model import BLACK, WHITE, Camera, Checker, Light, Material, Quad, Scene, Sphere, dot, sub  # noqa: E402
from tracer import CENTER, Tracer, camera_frame, fresnel, reflect, refract  # noqa: E402


class Optics(unittest.TestCase):
    def test_fresnel_at_normal_incidence(self) -> None:
        for n in (1.1, 1.33, 1.5, 2.4):
            expected = ((n - 1.0) / (n + 1.0)) ** 2
            self.assertAlmostEqual(fresnel(1.0, 1.0, n).reflectance, expected, delta=1e-14)
            self.assertAlmostEqual(fresnel(1.0, n, 1.0).reflectance, expected, delta=1e-14)

    def test_brewster_angle_reflects_only_one_polarisation(self) -> None:
        n = 1.5
        angle = math.atan(n)
        # At Brewster's angle the reflected and the refracted ray are perpendicular; only "across" is left.
        across = math.cos(2.0 * angle) ** 2
        self.assertAlmostEqual(fresnel(math.cos(angle), 1.0, n).reflectance, 0.5 * across, delta=1e-14)

    def test_total_reflection_begins_at_the_critical_angle(self) -> None:
        critical = math.asin(1.0 / 1.4)
        self.assertLess(fresnel(math.cos(critical - 1e-4), 1.4, 1.0).reflectance, 1.0)
        self.assertEqual(fresnel(math.cos(critical + 1e-4), 1.4, 1.0), (1.0, 0.0))

    def test_snell_and_unit_length(self) -> None:
        n = (0.0, 1.0, 0.0)
        for degrees in (0.0, 20.0, 45.0, 80.0):
            sine, cosine = math.sin(math.radians(degrees)), math.cos(math.radians(degrees))
            d = (sine, -cosine, 0.0)
            through = refract(d, n, 1.0 / 1.4, cosine, fresnel(cosine, 1.0, 1.4).cos_t)
            self.assertAlmostEqual(through[0], sine / 1.4, delta=1e-14)
            self.assertLess(through[1], 0.0)
            self.assertAlmostEqual(dot(through, through), 1.0, delta=1e-14)
            back = reflect(d, n)
            self.assertAlmostEqual(back[0], sine, delta=1e-15)
            self.assertAlmostEqual(back[1], cosine, delta=1e-15)

    def test_index_next_to_zero_is_a_perfect_mirror(self) -> None:
        self.assertEqual(fresnel(0.9999, 1.0, 1e-6).reflectance, 1.0)


class Geometry(unittest.TestCase):
    def test_outlines_of_sphere_and_square(self) -> None:
        # Area of the silhouette at 480 x 480: radius 96.3 px, half-side 94.99 px.
        for name, radius in (("sphere", True), ("square", False)):
            image = rendering.render(scenes.load(name), 1, 480, 480)
            area = sum(1 for c in image.data[0::3] if c > 0.0)
            if radius:
                self.assertAlmostEqual(math.sqrt(area / math.pi), 96.3, delta=0.1)
            else:
                self.assertAlmostEqual(math.sqrt(area) / 2.0, 94.99, delta=0.5)

    def test_silhouette_radius_in_closed_form(self) -> None:
        tracer = Tracer(scenes.load("sphere"), 1)
        frame = camera_frame(tracer.scene.camera, 1.0)
        radius = math.tan(math.asin(1.0 / 6.1)) / math.tan(math.radians(22.5)) / 2.0
        self.assertAlmostEqual(480.0 * radius, 96.3, delta=0.05)
        self.assertEqual(tracer.camera_ray(frame, 0.5 + radius - 1e-6, 0.5, CENTER), WHITE)
        self.assertEqual(tracer.camera_ray(frame, 0.5 + radius + 1e-6, 0.5, CENTER), BLACK)

    def test_the_near_plane_cuts_the_front_wall_away_at_every_angle(self) -> None:
        scene = scenes.load("cornell")
        for near, cut in ((4.1, True), (0.0, False)):
            moved = replace(scene, camera=replace(scene.camera, near=near))
            frame = camera_frame(moved.camera, 1.0)
            for u, v in ((0.5, 0.5), (0.1, 0.9), (0.97, 0.03)):
                d = frame.direction(u, v)
                depth = dot(d, frame.forward)
                hit = Tracer(moved, 1).closest(frame.eye, d, near * (1.0 + 1e-5) / depth, math.inf)
                assert hit is not None
                self.assertEqual(abs(hit.point[2] - 2.0) > 1e-9, cut)

    def test_quad_texture_coordinates_on_slanted_sides(self) -> None:
        quad = Quad((1.0, 2.0, 3.0), (2.0, 0.0, 0.0), (1.0, 3.0, 0.0), Material())
        at = (1.0 + 0.25 * 2.0 + 0.5 * 1.0, 2.0 + 0.5 * 3.0, 9.0)
        hit = Tracer(Scene([quad], []), 1).closest(at, (0.0, 0.0, -1.0), 0.0, math.inf)
        assert hit is not None
        self.assertAlmostEqual(hit.u, 0.25, delta=1e-14)
        self.assertAlmostEqual(hit.v, 0.5, delta=1e-14)
        self.assertAlmostEqual(hit.point[2], 3.0, delta=1e-14)

    def test_checker_cells(self) -> None:
        checker = Checker((2.0, 2.0), WHITE, BLACK)
        self.assertEqual(checker.at(0.1, 0.1), WHITE)
        self.assertEqual(checker.at(0.6, 0.1), BLACK)
        self.assertEqual(checker.at(0.6, 0.6), WHITE)
        self.assertEqual(checker.at(-0.1, 0.1), BLACK)

    def test_orbit_turns_the_world_not_the_eye(self) -> None:
        camera = Camera().orbited("y", 90.0)
        # Turning the world by 90 degrees about y brings its -x side before the eye.
        for found, expected in zip(camera.position, (-6.1, 0.0, 0.0)):
            self.assertAlmostEqual(found, expected, delta=1e-12)
        camera = Camera().orbited("x", 90.0)
        for found, expected in zip(camera.position + camera.up, (0.0, 6.1, 0.0, 0.0, 0.0, -1.0)):
            self.assertAlmostEqual(found, expected, delta=1e-12)


class Shading(unittest.TestCase):
    def test_phong_head_on_and_oblique(self) -> None:
        white = Quad((-1.0, -1.0, 0.0), (2.0, 0.0, 0.0), (0.0, 2.0, 0.0), Material("phong", WHITE, WHITE, BLACK, 3.0))
        light = Light((0.0, 0.0, 5.0), (0.5, 0.5, 0.5))
        tracer = Tracer(Scene([white], [light]), 2)
        down = (0.0, 0.0, -1.0)
        head_on = tracer.shade(down, tracer.closest((0.0, 0.0, 1.0), down, 0.0, math.inf), 0, CENTER)
        self.assertAlmostEqual(head_on[0], 0.5 * (1.0 + 1.0), delta=1e-14)
        off = tracer.shade(down, tracer.closest((0.75, 0.0, 1.0), down, 0.0, math.inf), 0, CENTER)
        cosine = 5.0 / math.hypot(0.75, 5.0)
        self.assertAlmostEqual(off[0], 0.5 * (cosine + cosine**3), delta=1e-14)

    def test_shadow_is_cast_by_glass_but_not_by_the_light(self) -> None:
        floor = Quad((-2.0, 0.0, 2.0), (4.0, 0.0, 0.0), (0.0, 0.0, -4.0), Material("phong", WHITE))
        light = Light((-0.5, 3.0, -0.5), WHITE, ((1.0, 0.0, 0.0), (0.0, 0.0, 1.0)))
        ball = Sphere((0.0, 1.0, 0.0), 0.5, Material("glass"))
        for shapes, hidden in (([floor], False), ([floor, ball], True)):
            self.assertEqual(Tracer(Scene(shapes, [light]), 2).hidden((0.0, 0.0, 0.0), light.center()), hidden)

    def test_facing_mirrors_end_black_after_ten_bounces(self) -> None:
        mirrors = [
            Quad((-1.0, -1.0, z), (2.0, 0.0, 0.0), (0.0, 2.0, 0.0), Material("mirror")) for z in (0.0, 1.0)
        ]
        tracer = Tracer(Scene(mirrors, []), 3)
        down = (0.0, 0.0, -1.0)
        hit = tracer.closest((0.0, 0.0, 0.5), down, 0.0, math.inf)
        self.assertEqual(tracer.shade(down, hit, 0, CENTER), BLACK)

    def test_phong_is_still_shaded_at_bounce_ten(self) -> None:
        # A staircase: each mirror hit moves along x; the opposite wall turns Phong where the eleventh hit lands.
        glow = Material("phong", BLACK, BLACK, WHITE)
        for count, expected in ((10, WHITE), (11, BLACK)):
            shapes = []
            for i in range(count):
                shapes.append(Quad((i + 0.1, -1.0, float(i % 2)), (0.8, 0.0, 0.0), (0.0, 2.0, 0.0), Material("mirror")))
            shapes.append(Quad((count + 0.1, -1.0, float(count % 2)), (0.8, 0.0, 0.0), (0.0, 2.0, 0.0), glow))
            tracer = Tracer(Scene(shapes, [], ambient=WHITE), 3)
            d = (math.sqrt(0.5), 0.0, -math.sqrt(0.5))
            hit = tracer.closest((0.0, 0.0, 0.5), d, 0.0, math.inf)
            self.assertEqual(tracer.shade(d, hit, 0, CENTER), expected, f"{count} mirrors")

    def test_glass_slab_shares_light_as_the_series_of_reflections(self) -> None:
        # White all round: whatever is lost is lost to the eleventh bounce only, at most R^5.
        slab = [
            Quad((-1.0, -1.0, 0.0), (0.0, 2.0, 0.0), (2.0, 0.0, 0.0), Material("glass", ior=1.5)),
            Quad((-1.0, -1.0, 1.0), (2.0, 0.0, 0.0), (0.0, 2.0, 0.0), Material("glass", ior=1.5)),
        ]
        behind = Quad((-1.0, -1.0, -5.0), (2.0, 0.0, 0.0), (0.0, 2.0, 0.0), Material("phong", BLACK, BLACK, WHITE))
        tracer = Tracer(Scene([*slab, behind], [], ambient=WHITE), 4)
        down = (0.0, 0.0, -1.0)
        seen = tracer.shade(down, tracer.closest((0.0, 0.0, 3.0), down, 0.0, math.inf), 0, CENTER)
        r = 0.04
        self.assertAlmostEqual(seen[0], (1.0 - r) / (1.0 + r), delta=1e-6)  # T = (1-R)/(1+R) for a plate

    def test_half_plane_hides_the_known_part_of_a_quad_light(self) -> None:
        # From the origin, light points (x, 2, z) cross the blind at (x/2, 1, z/2): hidden where x/2 < 0.125.
        blind = Quad((-5.0, 1.0, -5.0), (5.125, 0.0, 0.0), (0.0, 0.0, 10.0), Material())
        light = Light((-0.5, 2.0, -0.5), WHITE, ((1.0, 0.0, 0.0), (0.0, 0.0, 1.0)))
        tracer = Tracer(Scene([blind], [light]), 2)
        points = [light.point((i + 0.5) / 40.0, (j + 0.5) / 40.0) for i in range(40) for j in range(40)]
        self.assertEqual(sum(not tracer.hidden(BLACK, p) for p in points), 400)

    def test_soft_blocks_agree_with_hard_shadows_where_nothing_hides(self) -> None:
        scene = scenes.load("square")
        small = Light((-5.0, 5.0, 5.0), WHITE, ((1e-9, 0.0, 0.0), (0.0, 1e-9, 0.0)))
        blocks = rendering.soft_blocks(replace(scene, lights=[small]), 2, 128, 128, 4, 16, 3)
        block = next(b for b in blocks if (b.x, b.y) == (48, 48))  # wholly inside the square
        hard = rendering.render(scene, 2, 128, 128)
        mean = sum(hard.pixel(x, y)[0] for y in range(48, 64) for x in range(48, 64)) / 256
        self.assertEqual(block.n, 1024)
        self.assertGreater(block.variance[0], 0.0)
        self.assertLess(abs(block.mean[0] - mean), 5.0 * math.sqrt(block.variance[0]) + 1e-4)


class Files(unittest.TestCase):
    def test_pfm_round_trip_and_png_header(self) -> None:
        image = Image(3, 2, array("d", [float(i) / 4.0 for i in range(18)]))
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "x.pfm"
            write_pfm(path, image)
            back = read_pfm(path)
            self.assertEqual((back.width, back.height, list(back.data)), (3, 2, list(image.data)))
            write_png(Path(folder) / "x.png", image)
            self.assertEqual((Path(folder) / "x.png").read_bytes()[:8], b"\x89PNG\r\n\x1a\n")
            path.write_bytes(b"Pf\n3 2\n-1.0\n")
            with self.assertRaises(ValueError):
                read_pfm(path)

    def test_scene_reader_refuses_what_it_cannot_express(self) -> None:
        text = scenes.own_path("checker-glass").read_text()
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "x.toml"
            path.write_text(text)
            self.assertEqual(len(scenes.load(str(path)).shapes), 4)
            path.write_text(text + '\n[light.extra]\ntype = "distant"\n')
            with self.assertRaisesRegex(scenes.SceneError, "extra: type 'distant'"):
                scenes.load(str(path))
        with self.assertRaisesRegex(scenes.SceneError, "unknown scene 'teapot'"):
            scenes.load("teapot")


class Statistics(unittest.TestCase):
    def test_chi2_tail_against_known_values(self) -> None:
        # Two degrees of freedom: exp(-x/2). Tables: 3.841 at one degree and 124.342 at 100 leave 5 %.
        for x in (0.1, 1.0, 5.0, 30.0):
            self.assertAlmostEqual(chi2_tail(x, 2), math.exp(-x / 2.0), delta=1e-12)
        self.assertAlmostEqual(chi2_tail(3.841458820694124, 1), 0.05, delta=1e-9)
        self.assertAlmostEqual(chi2_tail(124.34211340400407, 100), 0.05, delta=1e-9)
        self.assertAlmostEqual(chi2_tail(225.0, 225), 0.4875, delta=2e-3)

    def test_orbited_camera_still_looks_at_the_origin(self) -> None:
        camera = Camera().orbited("y", 30.0)
        self.assertAlmostEqual(math.dist(camera.position, camera.target), 6.1, delta=1e-12)
        self.assertAlmostEqual(dot(sub(camera.target, camera.position), camera.up), 0.0, delta=1e-12)


if __name__ == "__main__":
    unittest.main()
