"""What the course's program can do: scenes, mouse, keys, render, files."""

from __future__ import annotations

import shlex
import subprocess
import time
from collections.abc import Callable
from pathlib import Path

from pictures import Picture, read_course_ppm, read_png
from report import Report, Stage
from screen import wait_for
from viewer import Viewer

RENDER_LIMIT_S = 300.0
CENTER = (240, 240)
# Pixels, from the centre.
TURN = [(12, 3)] * 5


def course(stage: Stage) -> None:
    """The session of a student."""
    start = time.monotonic()
    with stage.run("course", []) as viewer:
        took = time.monotonic() - start
        stage.report.check("the window appears", True, f"{took:.1f} s to a picture at rest", viewer)
        title = viewer.title()
        stage.report.check("its title", title.startswith("penombre"), title)
        for part in (mouse, scenes, fingers, keys):
            with stage.part(part.__name__, viewer):
                part(stage.report, viewer)
        render(stage, viewer)


def differs(a: Picture, b: Picture) -> tuple[bool, str]:
    """Whether more than a hundredth of the pixels differ, and how many."""
    share = a.share_different(b)
    return share > 0.01, f"{100.0 * share:.1f} % of the pixels differ"


def mouse(report: Report, viewer: Viewer) -> None:
    """Right drag, middle drag and wheel move the sphere; Home takes it back, pixel for pixel."""
    home = viewer.settled()
    moves: list[tuple[str, Callable[[], None]]] = [
        ("right drag", lambda: viewer.drag("right", CENTER, [(15, 10)] * 4)),
        ("middle drag", lambda: viewer.drag("middle", CENTER, [(0, 20)] * 4)),
        ("wheel", lambda: viewer.wheel(3, CENTER)),
    ]
    for name, move in moves:
        move()
        moved = viewer.changed(home, f"{name} to change the picture")
        report.check(f"{name} changes the picture", *differs(home, moved), viewer)
        viewer.key("Home")
        viewer.becomes(home, f"the first picture after {name} and Home")
    report.check("Home restores the picture", True, "exactly", viewer)


def scenes(report: Report, viewer: Viewer) -> None:
    """`+` and `-` go through the course's scenes, and left drag turns them. Leaves the box."""
    first = [viewer.settled()]
    last = first[0]
    for name in ("square", "cornell"):
        viewer.key("plus")
        first.append(viewer.changed(last, f"the scene {name} after +"))
        report.check(f"+ shows {name}", *differs(last, first[-1]), viewer)
        report.check(f"the title names {name}", name in viewer.title(), viewer.title())
        viewer.drag("left", CENTER, TURN)
        last = viewer.changed(first[-1], "left drag to change the picture")
        report.check(f"left drag turns {name}", *differs(first[-1], last), viewer)
    for key, at, name in (("minus", 1, "square"), ("plus", 2, "box"), ("plus", 0, "sphere"), ("minus", 2, "box")):
        viewer.key(key)
        viewer.becomes(first[at], f"the {name} again after {key}")
    report.check("- goes back, + begins anew after the last", True, "exactly", viewer)


def fingers(report: Report, viewer: Viewer) -> None:
    """`+` is Shift and another key: whichever of the two is let go first, each press is one scene. Leaves the box."""
    last = viewer.settled()
    for order in (("equal", "Shift_L"), ("Shift_L", "equal")):
        for name in ("sphere", "square", "cornell"):
            words = ["keydown", "Shift_L", "keydown", "equal"]
            for key in order:
                words += ["sleep", "0.05", "keyup", key]
            viewer.screen.xdotool(*words)
            last = viewer.changed(last, f"the next scene after +, {order[0]} let go first")
            report.check(f"+, {order[0]} let go first, shows {name}", name in viewer.title(), viewer.title(), viewer)


def keys(report: Report, viewer: Viewer) -> None:
    """Keys that change what is shown and, pressed again, restore it pixel for pixel."""
    plain = viewer.settled()
    for key, name in (("w", "wireframe"), ("question", "help"), ("g", "help by an unknown key")):
        viewer.key(key)
        other = viewer.changed(plain, f"{name} to show")
        report.check(f"{name} shows", *differs(plain, other), viewer)
        viewer.key(key)
        viewer.becomes(plain, f"{name} to go")
        report.check(f"{name} goes", True, "exactly", viewer)
    for key in ("Shift_L", "Control_L", "Alt_L", "Tab"):
        viewer.key(key)
        same = viewer.settled() == plain
        report.check(f"{key} alone changes nothing in the picture", same, "", viewer)
    extent = viewer.extent()
    for word in ("on", "off"):
        viewer.key("f")
        viewer.at_rest()
        report.check(f"full screen {word}: the program lives", viewer.lives(), f"{viewer.extent()}", viewer)
    viewer.becomes(plain, "the picture after full screen")
    report.check("full screen off restores the window", viewer.extent() == extent, f"{viewer.extent()}", viewer)


def render(stage: Stage, viewer: Viewer) -> None:
    """`r` from a turned camera gives the files, the printed command gives the same files, the screen shows them."""
    report, folder = stage.report, viewer.folder
    before = viewer.settled()
    viewer.drag("left", CENTER, TURN)
    raster, start = viewer.changed(before, "left drag to turn the box"), time.monotonic()
    viewer.key("r")
    files = [folder / "rendu.ppm", folder / "rendu.png"]
    wait_for("rendu.ppm and rendu.png", RENDER_LIMIT_S, lambda: all(f.exists() for f in files), poll_s=0.05)
    line = wait_for("the printed command", 10.0, lambda: printed_command(viewer))
    report.check("r renders and prints its command", True, f"{time.monotonic() - start:.1f} s, {line}", viewer)
    references = [folder / "reference.ppm", folder / "reference.png"]
    render_again(stage.penombre, line, references, folder)
    same = files[0].read_bytes() == references[0].read_bytes()
    report.check("rendu.ppm is that of the printed command, byte for byte", same)
    same = read_png(files[1]) == read_png(references[1])
    report.check("rendu.png is that of the printed command, pixel for pixel", same)
    compare(report, viewer, *files)
    viewer.drag("left", CENTER, TURN)
    back = viewer.changed(read_png(files[1]), "a drag to leave the image")
    report.check("a drag leaves the image for the raster view", *differs(raster, back), viewer)


def printed_command(viewer: Viewer) -> str | None:
    """The last command that the program has printed."""
    lines = [line for line in viewer.lines if line.startswith("penombre render ")]
    return lines[-1] if lines else None


def render_again(penombre: Path, line: str, outputs: list[Path], folder: Path) -> None:
    """Runs a printed command with outputs added, in the folder in which it was printed."""
    words = [str(penombre), *shlex.split(line)[1:], "--quiet", "--no-progress", "--course-ppm"]
    for output in outputs:
        words += ["-o", str(output)]
    subprocess.run(words, cwd=folder, check=True, timeout=RENDER_LIMIT_S)


def compare(report: Report, viewer: Viewer, ppm: Path, png: Path) -> None:
    """Both files and the screen hold the same picture. The course truncates where PNG and screen round."""
    truncated, rounded = read_course_ppm(ppm), read_png(png)
    size = (truncated.width, truncated.height)
    report.check("rendu.ppm has the size of the picture", size == viewer.size, f"{size}")
    worst = truncated.largest_difference(rounded)
    report.check("rendu.png shows what rendu.ppm shows", worst <= 1, f"largest difference {worst}")
    worst = viewer.settled().largest_difference(rounded)
    report.check("the screen shows rendu.png", worst == 0, f"largest difference {worst}", viewer)
