"""Make the page to play with, ``docs/play/play.html``, and the motions that are shown beside it.

The page asks fuzzy systems that :func:`fuzzy2.export_c` has written as C99, compiled to
WebAssembly: the same kernels as in Python, and no second implementation. It is made by
``make pictures`` where clang has a linker for WebAssembly (Debian: clang, lld, wasi-libc). The
motions are MeshCat's commands; ``docs/conf.py`` makes pages of them.
"""

from __future__ import annotations

import base64
import hashlib
import json
import shutil
import subprocess
import tempfile
from pathlib import Path
from typing import Any

import fuzzy2
import psp3
from fuzzy2.support.markup import Markup, data_from_json, filled
from fuzzy2.support.text_files import write_text
from psp3.visualize import Scene

HERE = Path(__file__).resolve().parent
PAGE = HERE / "play.html"
DOUBTS = (0.0, 0.5, 1.0, 1.5, 2.0)
"""By how much people differ about where a word begins and ends, up and down."""

WORDS = {
    "service": {"poor": (-4.0, 0.0, 5.0), "good": (0.0, 5.0, 10.0), "excellent": (5.0, 10.0, 14.0)},
    "food": {"bad": (-4.0, 0.0, 7.0), "delicious": (3.0, 10.0, 14.0)},
}
RULES = """
IF service is poor or food is bad THEN tip is low
IF service is good THEN tip is medium
IF service is excellent or food is delicious THEN tip is high
"""
TIPS = {"low": 5.0, "medium": 15.0, "high": 25.0}

COMPILE = ("clang", "--target=wasm32-wasi", "-Os", "-std=c99", "-ffp-contract=off", "-nostdlib")
LINK = ("-Wl,--no-entry", "-Wl,--strip-all", "-L/usr/lib/wasm32-wasi", "-lc")
GLUE = """
static double x[2], out[1], ends[2];
__attribute__((export_name("x"))) double *x_at(void) { return x; }
__attribute__((export_name("out"))) double *out_at(void) { return out; }
__attribute__((export_name("ends"))) double *ends_at(void) { return ends; }
"""


def system_of(doubt: float) -> fuzzy2.IntervalType2System:
    """Return the tipper whose words are as unsure as is said."""

    def words(corners: dict[str, tuple[float, float, float]]) -> dict[str, Any]:
        return {
            word: fuzzy2.IntervalType2Set(
                fuzzy2.Triangular(left + doubt, top, right - doubt),
                fuzzy2.Triangular(left - doubt, top, right + doubt),
            )
            for word, (left, top, right) in corners.items()
        }

    return fuzzy2.IntervalType2System(
        {name: words(corners) for name, corners in WORDS.items()},
        RULES,
        {"tip": TIPS},
        "min",
        input_ranges=[(0.0, 10.0)] * len(WORDS),
    )


def sources(folder: Path) -> str:
    """Write the systems as C, with what hands numbers over; return a checksum of them."""
    glue = GLUE
    for number, doubt in enumerate(DOUBTS):
        name = f"tip{number}"
        fuzzy2.export_c(system_of(doubt), folder, name=name)
        glue = f'#include "{name}.h"\n{glue}'
        for asked, into in (("evaluate", "out"), ("interval", "ends")):
            export = f'__attribute__((export_name("{asked}{number}")))'
            glue += f"{export} int {asked}{number}(void) {{ return {name}_{asked}(x, {into}); }}\n"
    write_text(glue, folder / "glue.c")
    digest = hashlib.sha256()
    for path in sorted(folder.glob("*.[ch]")):
        digest.update(path.read_bytes())
    return digest.hexdigest()


def compiled(folder: Path) -> bytes:
    """Return the C of a folder as WebAssembly."""
    module = folder / "play.wasm"
    files = sorted(map(str, folder.glob("*.c")))
    subprocess.run([*COMPILE, *files, *LINK, "-o", str(module)], check=True)
    return module.read_bytes()


def page(module: bytes, checksum: str) -> str:
    """Return the page with the systems in it."""
    data = {
        "checksum": checksum,
        "doubts": DOUBTS,
        "words": WORDS,
        "tips": TIPS,
        "rules": [line for line in RULES.splitlines() if line],
    }
    return filled(
        (HERE / "template.html").read_text(encoding="utf-8"),
        {
            "DATA": data_from_json(json.dumps(data)),
            "MODULE": Markup(base64.b64encode(module).decode()),
        },
    )


def record_motions() -> None:
    """Write two controllers beside each other, and a Delta that sways."""
    robot = psp3.load("psp3")
    helix = psp3.trajectories.Circle(robot=robot)
    results = {
        "PD": psp3.simulate(robot, psp3.PD(), helix, duration=4.0),
        "computed torque": psp3.simulate(robot, psp3.ComputedTorque(robot), helix, duration=4.0),
    }
    delta = psp3.load("delta")
    sway = psp3.trajectories.Sway(robot=delta)
    for name, scene in (
        ("controllers", Scene(robot).animate(results)),
        ("delta", Scene(delta).animate(sway, sway.period)),
    ):
        write_text(scene._commands.as_json() + "\n", HERE / f"{name}.json")


if __name__ == "__main__":
    record_motions()
    if shutil.which("wasm-ld") is None:
        raise SystemExit("no linker for WebAssembly: apt-get install clang lld wasi-libc")
    with tempfile.TemporaryDirectory() as name:
        checksum = sources(Path(name))
        write_text(page(compiled(Path(name)), checksum), PAGE)
