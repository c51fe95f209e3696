"""Input at the wrong moment, broken files, impossible sizes, no screen, no driver: it goes on or says why not."""

from __future__ import annotations

import subprocess
import time
from pathlib import Path

from course import CENTER, differs
from pictures import Picture
from report import Report, Stage
from screen import wait_for, without_display
from viewer import COARSE, COMPLETE, FRAME_LIMIT_S, RASTER, Viewer

# A drag during a render must not wait for the render: a few software frames on a busy machine.
BACK_TO_RASTER_S = 3.0
# Less processor time than this in half a second is rest, seconds.
REST_S = 0.05
EXR_MAGIC = b"\x76\x2f\x31\x01"
# A render that nobody waits for.
ENDLESS = ["--set", "render.spp=100000"]
# Where the loaders of Vulkan, GL and EGL find no driver.
NO_DRIVER = dict.fromkeys(
    ("VK_DRIVER_FILES", "VK_ICD_FILENAMES", "LIBGL_DRIVERS_PATH", "__EGL_VENDOR_LIBRARY_FILENAMES"), "/nonexistent"
)
BROKEN = {
    "broken.toml": b'penombre = 1\n[shape.a]\ntype = "sfere"\nradius = "big"\n',
    "broken.obj": b"v 0 0 nothing\nf 1 2 3\n",
    "broken.off": bytes(range(256)),
}


def long_render(stage: Stage) -> None:
    """Drag, Esc, Ctrl-S and q during a render that would take hours."""
    with stage.run("long render", ["cornell", "--latency-marker", *ENDLESS]) as viewer:
        for part in (drag_it, resize_it, cancel_it, save_it):
            with stage.part(part.__name__, viewer):
                viewer.key("r")
                viewer.shows(COARSE, "a first image after r")
                part(stage.report, viewer)


def drag_it(report: Report, viewer: Viewer) -> None:
    """A drag shows the raster view at once."""
    viewer.screen.xdotool("mousemove", "--window", viewer.window, *CENTER, "mousedown", 1)
    start = time.monotonic()
    viewer.screen.xdotool("mousemove_relative", 20, 5)
    viewer.shows(RASTER, "the raster view during a drag", BACK_TO_RASTER_S)
    took = time.monotonic() - start
    viewer.screen.xdotool("mouseup", 1)
    report.check("a drag during a render shows the raster view", True, f"after {1000 * took:.0f} ms", viewer)


def resize_it(report: Report, viewer: Viewer) -> None:
    """Another size of the window shows the raster view in that size; the old size restores the old picture."""
    extent = viewer.extent()
    for size in ((extent[0] + 100, extent[1] - 80), extent):
        viewer.resize(*size)
        viewer.shows(RASTER, "the raster view after a resize", BACK_TO_RASTER_S)
        wait_for("the new size", FRAME_LIMIT_S, lambda size=size: viewer.extent() == size)
        viewer.at_rest()
    report.check("a resize during a render shows the raster view", viewer.lives(), "", viewer)


def cancel_it(report: Report, viewer: Viewer) -> None:
    """Esc ends the render and not the program."""
    viewer.key("Escape")
    viewer.shows(RASTER, "the raster view after Esc", BACK_TO_RASTER_S)
    wait_for("rest after Esc", FRAME_LIMIT_S, lambda: rests(viewer))
    report.check("Esc cancels a render, which then takes no time", viewer.lives(), "", viewer)
    report.check("a cancelled render writes nothing", not (viewer.folder / "rendu.ppm").exists())
    before = viewer.settled()
    for _ in range(2):
        viewer.key("w")
        viewer.changed(before, "wireframe after a cancelled render")
        before = viewer.settled()
    report.check("keys work after Esc", True, "", viewer)


def rests(viewer: Viewer) -> bool:
    """Whether the program uses no processor time, measured for half a second."""
    before = viewer.cpu_seconds()
    time.sleep(0.5)
    return viewer.cpu_seconds() - before <= REST_S


def save_it(report: Report, viewer: Viewer) -> None:
    """Ctrl-S, a path whose letters are keys of the program too, Return: an EXR file."""
    path = viewer.folder / "quwf+r.exr"
    viewer.answer("ctrl+s", str(path))
    wait_for(f"{path.name} after Ctrl-S", FRAME_LIMIT_S, path.exists)
    magic = path.read_bytes()[:4] == EXR_MAGIC
    report.check("Ctrl-S saves where one types", magic, f"{path.stat().st_size} bytes of EXR", viewer)


def broken_scenes(stage: Stage) -> None:
    """Scenes that are not there or broken: a message, and the program goes on."""
    folder = stage.folder("broken")
    for name, content in BROKEN.items():
        (folder / name).write_bytes(content)
    names = ["missing.toml", *BROKEN]
    for name in names:
        with stage.run(f"start with {name}", [str(folder / name)]) as viewer:
            named_at_start(stage.report, viewer, name)
    with stage.run("opened later", ["cornell"]) as viewer:
        with stage.part("open missing.toml", viewer):
            missing_later(stage.report, viewer, folder / "missing.toml")
        for name in BROKEN:
            with stage.part(f"open {name}", viewer):
                opened_later(stage.report, viewer, folder / name)


def named_at_start(report: Report, viewer: Viewer, name: str) -> None:
    """The window comes with a message, and `+` shows a scene of the course."""
    message = viewer.settled()
    report.check(f"start with {name}: the program lives", viewer.lives(), "", viewer)
    viewer.key("plus")
    scene = viewer.changed(message, f"a scene of the course after {name}")
    report.check(f"start with {name}: + shows a scene", *differs(message, scene), viewer)


def missing_later(report: Report, viewer: Viewer, path: Path) -> None:
    """The dialogue says that there is no such file and stays; Esc closes it and not the program."""
    before = viewer.settled()
    viewer.answer("ctrl+o", str(path))
    wait_for("a warning in the dialogue", FRAME_LIMIT_S, lambda: has_warning(viewer.whole()))
    report.check("open missing.toml: the dialogue says so", True, "", viewer)
    viewer.key("Escape")
    viewer.becomes(before, "the picture without the dialogue")
    report.check("open missing.toml: Esc closes the dialogue", viewer.lives(), "", viewer)


def has_warning(picture: Picture) -> bool:
    """Whether there is text in the orange of warnings."""
    pixels = zip(picture.data[0::3], picture.data[1::3], picture.data[2::3])
    return sum(red > 200 and 100 < green < 180 and blue < 60 for red, green, blue in pixels) >= 20


def opened_later(report: Report, viewer: Viewer, path: Path) -> None:
    """The old scene stays, with a message; `+` and `-` load anew and take the message away."""
    before = viewer.at_rest()
    viewer.answer("ctrl+o", str(path))
    message = viewer.at_rest()
    figure = f"{100.0 * before.share_different(message):.1f} % of the pixels differ"
    report.check(f"open {path.name}: there is a message", before != message, figure, viewer)
    for key in ("plus", "minus"):
        viewer.key(key)
        message = viewer.changed(message.part(0, 0, *viewer.size), f"another scene after {path.name}")
    wait_for(f"the box without a message after {path.name}", FRAME_LIMIT_S, lambda: viewer.whole() == before)
    report.check(f"open {path.name}: the program goes on", True, "", viewer)


def unwritable(stage: Stage) -> None:
    """`r` where its files cannot be written: the image stays, with a message."""
    with stage.run("unwritable", ["cornell", "--latency-marker", "--set", "render.spp=4"]) as viewer:
        files = [viewer.folder / name for name in ("rendu.ppm", "rendu.png")]
        viewer.key("r")
        wait_for("rendu.ppm and rendu.png", FRAME_LIMIT_S, lambda: all(f.exists() for f in files))
        image = below_marker(viewer)
        for file in files:
            file.unlink()
            file.mkdir()
        viewer.key("r")
        wait_for("the image under a message", FRAME_LIMIT_S, lambda: covered(viewer, image))
        stage.report.check("r where it cannot write: a message", viewer.lives(), "", viewer)


def covered(viewer: Viewer, image: Picture) -> bool:
    """Whether the complete image is shown with something over the smaller part of it."""
    return viewer.marker()[1] == COMPLETE and 0.01 < image.share_different(below_marker(viewer)) < 0.5


def below_marker(viewer: Viewer) -> Picture:
    """The picture at rest without its first rows, where the latency marker is."""
    return viewer.settled().part(0, 8, viewer.size[0], viewer.size[1] - 8)


def sizes(stage: Stage) -> None:
    """Windows too small for anything, and back."""
    with stage.run("sizes", ["cornell"]) as viewer:
        before, extent = viewer.settled(), viewer.extent()
        for size in ((1, 1), (300, 200), (1, 700), (1700, 20)):
            viewer.resize(*size)
            wait_for(f"a window of {size}", FRAME_LIMIT_S, lambda size=size: viewer.extent() == size)
            viewer.key("w", "w")
            viewer.at_rest()
            stage.report.check(f"a window of {size[0]} x {size[1]}: the program lives", viewer.lives(), "", viewer)
        viewer.resize(*extent)
        viewer.becomes(before, "the first picture in the first size")
        stage.report.check("the first size restores the picture", True, "exactly", viewer)


def refusals(stage: Stage) -> None:
    """Without a screen or a driver the program says so, in words of its own, and ends."""
    places = {"display": without_display(), "driver": {**stage.screen.environment(), **NO_DRIVER}}
    for name, environment in places.items():
        folder = stage.folder(name)
        command = [str(stage.view)]
        done = subprocess.run(
            command, env=environment, cwd=folder, capture_output=True, text=True, timeout=60, check=False
        )
        said = done.stderr.strip()
        clear = "error" in said and name in said and not any(word in said for word in ("panicked", ".cargo", "src/"))
        passed = clear and done.returncode in (1, 2)
        stage.report.check(f"no {name}: a message and an end", passed, f"exit status {done.returncode}, {said[:600]}")
