"""penombre's adapter for benchmarks against other renderers.

`render(scene, args)` takes a scene in neutral terms (a dict of materials, shapes, an environment and a camera), writes it
as a scene file of penombre, runs the command and returns the image and its figures. Files that the scene names are found
by `scenes.asset`. `$PENOMBRE` names the command; else the release build of this folder's project is taken.
"""
import json
import os
import subprocess
import tempfile


def command():
    """Path of the `penombre` command."""
    given = os.environ.get("PENOMBRE")
    if given:
        return given
    here = os.path.dirname(os.path.abspath(__file__))
    root = os.path.dirname(os.path.dirname(here))
    target = os.environ.get("CARGO_TARGET_DIR", os.path.join(root, "target"))
    path = os.path.join(target, "release", "penombre")
    if not os.path.exists(path):
        raise SystemExit("build it first: cargo build --release -p penombre-cli")
    return path


def numbers(values):
    return "[" + ", ".join(repr(float(v)) for v in values) + "]"


def material(name, m, out):
    """A material table."""
    out.append("[material.%s]" % quoted(name))
    kind = m["type"]
    if kind == "diffuse":
        out += ['type = "diffuse"', "color = " + numbers(m["reflectance"])]
    elif kind == "mirror":
        out += ['type = "mirror"', "reflectance = " + numbers(m["reflectance"])]
    elif kind == "dielectric":
        out += ['type = "glass"', "ior = %r" % float(m["ior"])]
    elif kind == "rough_dielectric":
        out += ['type = "rough_glass"', "ior = %r" % float(m["ior"])] + microfacets(m)
    elif kind == "rough_conductor":
        out += ['type = "metal"', "n = " + numbers(m["eta"]), "k = " + numbers(m["k"])] + microfacets(m)
    else:
        raise SystemExit("material %s: unknown type %s" % (name, kind))


def microfacets(m):
    """The peers' model: single scattering with separable masking."""
    return ["alpha = %r" % float(m["alpha"]), 'masking = "separable"', "compensate = false"]


def quoted(name):
    return json.dumps(str(name))


def shape(index, s, folder, out):
    """A shape's table, or that of the light that it is."""
    emission = s.get("emission")
    kind = s["type"]
    name = quoted("s%d" % index)
    if kind == "quad":
        v = s["vertices"]
        sides = [[b - a for a, b in zip(v[0], v[i])] for i in (1, 3)]
        what = ["origin = " + numbers(v[0]), "sides = [%s, %s]" % tuple(numbers(e) for e in sides)]
    elif kind == "sphere":
        what = ["center = " + numbers(s["center"]), "radius = %r" % float(s["radius"])]
    else:
        kind = "mesh"
        what = ["file = " + quoted(mesh(s["file"], folder)), "crease_angle = 0"]
    if emission and kind != "mesh":
        out.append("[light.%s]" % name)
        out += ["type = " + quoted(kind)] + what + ["radiance = " + numbers(emission)]
        return
    if emission:
        out += ["[material.%s]" % quoted("glow%d" % index), 'type = "emissive"', "radiance = " + numbers(emission)]
    out.append("[shape.%s]" % name)
    out += ["type = " + quoted(kind)] + what
    out.append("material = " + quoted("glow%d" % index if emission else s["material"]))


def mesh(name, folder):
    """A mesh file as OFF, beside the scene: made once from a PLY file."""
    import numpy as np
    import scenes
    source = scenes.asset(name)
    if not source.endswith(".ply"):
        return link(source, folder)
    made = os.path.join(scenes.cache_dir(), os.path.basename(source)[:-4] + ".off")
    if not os.path.exists(made):
        v, f = scenes.read_ply(source)
        part = made + ".part"
        with open(part, "w") as o:
            o.write("OFF\n%d %d 0\n" % (len(v), len(f)))
            np.savetxt(o, v, fmt="%.9g")
            np.savetxt(o, np.concatenate([np.full((len(f), 1), 3, "i4"), f], 1), fmt="%d")
        os.replace(part, made)
    return link(made, folder)


def link(path, folder):
    name = os.path.basename(path)
    place = os.path.join(folder, name)
    if not os.path.exists(place):
        os.symlink(os.path.abspath(path), place)
    return name


def environment(e, folder, out):
    if not e:
        return
    import scenes
    out += ["[light.environment]", 'type = "environment"']
    if e["type"] == "constant":
        out.append("radiance = " + numbers(e["radiance"]))
    else:
        # The neutral image begins at -z; penombre's has -z in its middle.
        out += ["file = " + quoted(link(scenes.asset(e["file"]), folder)), "rotate = 180"]


def scene_file(sc, a, folder):
    """Writes the scene as TOML and returns its path."""
    c = sc["camera"]
    out = ["penombre = 1", "[render]", 'integrator = "path"', "size = [%d, %d]" % (a.res, a.res),
           "max_depth = %d" % a.max_segments, "[integrator.path]"]
    if a.no_rr:
        out.append("roulette_depth = 65536")
    out += ["[camera.main]", 'type = "perspective"', "position = " + numbers(c["origin"]),
            "target = " + numbers(c["target"]), "up = " + numbers(c["up"]), "fov = %r" % float(c["vfov_deg"])]
    if c.get("near"):
        out.append("near = %r" % float(c["near"]))
    for name, m in sc["materials"].items():
        material(name, m, out)
    for i, s in enumerate(sc["shapes"]):
        shape(i, s, folder, out)
    environment(sc["environment"], folder, out)
    path = os.path.join(folder, "scene.toml")
    with open(path, "w") as o:
        o.write("\n".join(out) + "\n")
    return path


def render(sc, a):
    import scenes
    with tempfile.TemporaryDirectory() as folder:
        scene = scene_file(sc, a, folder)
        image = os.path.join(folder, "image.exr")
        cmd = [command(), "render", scene, "--spp", str(a.spp), "--seed", str(a.seed), "--threads", str(a.threads),
               "--json", "--no-progress", "-o", image, "--asset-root", "/"]
        run = subprocess.run(cmd, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        if run.returncode != 0:
            raise SystemExit(run.stderr)
        d = json.loads(run.stdout.splitlines()[-1])
        return scenes.read_exr(image), {
            "version": subprocess.run([command(), "--version"], stdout=subprocess.PIPE, text=True).stdout.strip(),
            "spp": d["spp"], "load_s": d["load_s"], "build_s": d["build_s"], "render_s": d["render_s"],
            "render_cpu_s": d["cpu_s"], "rays": d["rays"], "error": d["error"]}


def main():
    """Writes a scene as TOML with what belongs to it: peer_penombre.py SCENE FOLDER [RESOLUTION]."""
    import argparse
    import scenes
    p = argparse.ArgumentParser(description=main.__doc__)
    p.add_argument("scene", help="cornell, course, mesh, materials, or a JSON file of the same form")
    p.add_argument("folder")
    p.add_argument("res", type=int, nargs="?", default=256)
    a = p.parse_args()
    a.max_segments, a.no_rr = scenes.MAX_SEGMENTS, False
    print(scene_file(scenes.get(a.scene), a, a.folder))


if __name__ == "__main__":
    main()
