"""Loads a mesh of 2 million triangles from a binary PLY file and from its OBJ twin, with penombre and with Mitsuba in turns.

Each run is a process of its own. Told are the medians of wall time and processor time of the loading alone, of the peak of
resident memory of the whole process, and of that beyond what the process had before loading. Both programs hold positions,
normals and indices in memory when the clock stops; penombre has also hashed the file. Hierarchies for rays are not built.
"""

import argparse
import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
VARIANTS = ["scalar_rgb", "llvm_ad_rgb"]


def write_meshes(folder, edge):
    """A torus with waves: 2 x edge x edge triangles with vertex normals."""
    import numpy as np

    u, v = np.meshgrid(*2 * [np.arange(edge) / edge * 2 * np.pi], indexing="ij")
    radius = 0.4 + 0.05 * np.sin(7 * u + 5 * v)
    ring = 1 + radius * np.cos(v)
    points = np.stack([ring * np.cos(u), ring * np.sin(u), radius * np.sin(v)], -1)
    along = np.roll(points, -1, 0) - np.roll(points, 1, 0)
    across = np.roll(points, -1, 1) - np.roll(points, 1, 1)
    normals = np.cross(along, across)
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    points, normals = (a.reshape(-1, 3).astype("<f4") for a in (points, normals))
    i, j = np.meshgrid(*2 * [np.arange(edge)], indexing="ij")
    index = lambda a, b: a % edge * edge + b % edge
    quads = np.stack([index(i, j), index(i + 1, j), index(i + 1, j + 1), index(i, j + 1)], -1).reshape(-1, 4)
    triangles = quads[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3).astype("<i4")

    names = "".join(f"property float {n}\n" for n in ("x", "y", "z", "nx", "ny", "nz"))
    header = (
        f"ply\nformat binary_little_endian 1.0\nelement vertex {len(points)}\n{names}"
        f"element face {len(triangles)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    faces = np.zeros(len(triangles), dtype=[("n", "u1"), ("i", "<i4", 3)])
    faces["n"], faces["i"] = 3, triangles
    with open(folder / "mesh.ply", "wb") as file:
        file.write(header.encode())
        np.hstack([points, normals]).tofile(file)
        faces.tofile(file)
    with open(folder / "mesh.obj", "w") as file:
        file.writelines("v %.9g %.9g %.9g\n" % tuple(p) for p in points)
        file.writelines("vn %.9g %.9g %.9g\n" % tuple(n) for n in normals)
        file.writelines("f %d//%d %d//%d %d//%d\n" % (a, a, b, b, c, c) for a, b, c in triangles + 1)
    for ending in ("ply", "obj"):
        scene = f'penombre = 1\n[shape.mesh]\ntype = "mesh"\nfile = "mesh.{ending}"\n'
        (folder / f"{ending}.toml").write_text(scene)


def mitsuba(variant, file):
    """Loads a file in this process and prints what it took."""
    import mitsuba as mi

    mi.set_variant(variant)
    peak = lambda: int(Path("/proc/self/status").read_text().split("VmHWM:")[1].split()[0]) * 1024
    base, cpu, start = peak(), time.process_time(), time.perf_counter()
    shape = mi.load_dict({"type": Path(file).suffix[1:], "filename": file})
    triangles = shape.face_count()
    if variant.startswith("llvm"):
        import drjit as dr

        dr.eval(shape.vertex_positions_buffer(), shape.faces_buffer())
        dr.sync_thread()
    seconds, cpu = time.perf_counter() - start, time.process_time() - cpu
    said = {"triangles": triangles, "load_s": seconds, "cpu_s": cpu, "base_rss": base, "peak_rss": peak()}
    print(json.dumps(said | {"version": mi.__version__}))


def run(words, where=ROOT):
    done = subprocess.run(words, cwd=where, capture_output=True, text=True, check=False)
    if done.returncode:
        sys.exit(f"{' '.join(words)}\n{done.stderr}")
    return json.loads(done.stdout.strip().splitlines()[-1])


def main():
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--reps", type=int, default=7)
    options.add_argument("--edge", type=int, default=1000, help="2 x edge x edge triangles")
    options.add_argument("--one", nargs=2, metavar=("VARIANT", "FILE"), help=argparse.SUPPRESS)
    options = options.parse_args()
    if options.one:
        return mitsuba(*options.one)
    ours = ["cargo", "bench", "-q", "-p", "penombre-scene", "--bench", "load", "--"]
    with tempfile.TemporaryDirectory(prefix="penombre-load-") as folder:
        folder = Path(folder)
        write_meshes(folder, options.edge)
        for ending in ("ply", "obj"):
            found = {}
            for _ in range(options.reps):
                found.setdefault("penombre", []).append(run([*ours, str(folder / f"{ending}.toml")]))
                for variant in VARIANTS:
                    words = [sys.executable, __file__, "--one", variant, str(folder / f"mesh.{ending}")]
                    found.setdefault(f"mitsuba {variant}", []).append(run(words))
            tell(ending, folder / f"mesh.{ending}", found)


def tell(ending, file, found):
    version = next(r["version"] for runs in found.values() for r in runs if "version" in r)
    triangles = {r["triangles"] for runs in found.values() for r in runs}
    assert len(triangles) == 1, f"they do not read the same mesh: {triangles}"
    size = os.path.getsize(file) / 1e6
    print(f"{ending.upper()}: {triangles.pop()} triangles, {size:.0f} MB; Mitsuba {version}")
    for name, runs in found.items():
        middle = lambda of: statistics.median(of(r) for r in runs)
        wall, cpu = middle(lambda r: r["load_s"]), middle(lambda r: r["cpu_s"])
        peak, own = middle(lambda r: r["peak_rss"]), middle(lambda r: r["peak_rss"] - r["base_rss"])
        print(f"  {name:20} {wall:.3f} s wall, {cpu:.3f} s cpu, peak {peak / 1e6:.0f} MB, {own / 1e6:.0f} MB of it by loading")


if __name__ == "__main__":
    main()
