"""The notebooks run from top to bottom, and what is committed is what they show.

Outputs, no errors, no traces of a machine.
"""

from __future__ import annotations

import base64
import hashlib
import math
import queue
import re
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest

from tests.processes import PROCESSES, answer_of, start

nbformat = pytest.importorskip(
    "nbformat", reason="nbformat, jupyter-client and ipykernel are in the extra test"
)
jupyter_client = pytest.importorskip(
    "jupyter_client", reason="nbformat, jupyter-client and ipykernel are in the extra test"
)

from tests.notebook_shell import run_cells  # noqa: E402 (IPython comes with ipykernel)

NOTEBOOKS = sorted((Path(__file__).resolve().parents[1] / "notebooks").glob("*.ipynb"))
LARGEST = 1_500_000
"""Bytes of a notebook with its outputs."""

FIGURE = re.compile(r"\*(Figure|Animation|3D view) \d+\. ")
TRACES = re.compile(r"(?<![\w.])/(tmp|home|root|work|Users|usr|var|opt|mnt|private)/|site-packages")


def read(path: Path) -> Any:
    notebook = nbformat.read(path, as_version=4)
    nbformat.validate(notebook)
    return notebook


def test_they_are_numbered() -> None:
    assert [path.name[:3] for path in NOTEBOOKS] == [f"{number:02d}_" for number in range(1, 14)]


@pytest.fixture(params=NOTEBOOKS, ids=lambda path: path.stem)
def path(request: pytest.FixtureRequest) -> Path:
    return Path(request.param)


def is_picture(cell: Any) -> bool:
    """Whether a cell shows a picture, a 3D view or an animation."""
    data = [name for output in cell.get("outputs", []) for name in output.get("data", {})]
    frames = [
        "<iframe" in "".join(output.get("data", {}).get("text/html", ""))
        for output in cell.get("outputs", [])
    ]
    return any(name.startswith("image/") for name in data) or any(frames)


def text_of(output: Any) -> str:
    """Return what an output says in words; pictures are left out."""
    data = output.get("data", {})
    words = [
        output.get("text", ""),
        *(data.get(kind, "") for kind in ("text/plain", "text/markdown")),
    ]
    if "<iframe" not in data.get("text/html", ""):
        words.append(data.get("text/html", ""))
    return "\n".join(words)


def test_committed_with_outputs(path: Path) -> None:
    """Every cell was run, in order and from a fresh kernel, and none failed or warned."""
    assert path.stat().st_size < LARGEST
    notebook = read(path)
    code = [cell for cell in notebook.cells if cell.cell_type == "code"]
    assert [cell.execution_count for cell in code] == list(range(1, len(code) + 1))
    assert sum(bool(cell.outputs) for cell in code) >= len(code) / 2
    for cell in code:
        for output in cell.outputs:
            assert output.output_type != "error"
            assert output.get("name") != "stderr", output.text
            assert not TRACES.search(text_of(output)), text_of(output)
    assert notebook.metadata.language_info == {"name": "python"}


def test_opens_with_what_the_reader_will_be_able_to_do_and_ends_with_two_exercises(
    path: Path,
) -> None:
    cells = read(path).cells
    assert cells[0].cell_type == cells[-1].cell_type == "markdown"
    assert re.match(
        r"# \d+ .+\n\n!\[[^\]]{80,}\]\(attachment:opening.png\)\n\n"
        r"After this notebook you will be able to\n\n(- .+\n)",
        cells[0].source,
    )
    # Imports come after what is seen and said, and are folded.
    assert cells[1].metadata.jupyter.source_hidden
    assert "hide-input" in cells[1].metadata.tags
    assert cells[-1].source.startswith("## Exercises\n")
    assert re.findall(r"^(\d+)\. \*\*", cells[-1].source, flags=re.MULTILINE) == ["1", "2"]


def test_the_picture_at_the_top_is_of_an_output_as_it_is_now(path: Path) -> None:
    """By the checksum of the output that it was made of, see ``docs/pictures/make_openings.py``."""
    cells = read(path).cells
    made_of = cells[0].metadata.opening
    assert base64.b64decode(cells[0].attachments["opening.png"]["image/png"])[1:4] == b"PNG"
    (outputs,) = (
        cell.outputs
        for cell, below in pairwise(cells)
        if below.source.startswith(f"*{made_of.shows}. ")
    )
    contents = [text for output in outputs for text in output.get("data", {}).values()]
    assert made_of.sha256 in {hashlib.sha256(text.encode()).hexdigest() for text in contents}, (
        "the output has changed: python docs/pictures/make_openings.py"
    )


def test_lines_of_code_fit_the_width_of_the_documentation(path: Path) -> None:
    lines = [line for source in code_of(read(path)) for line in source.splitlines()]
    assert max(map(len, lines)) <= 88


def test_every_picture_is_put_in_words(path: Path) -> None:
    """The text below a picture opens with its caption.

    It describes the picture, and the documentation gets the same as its alternative text.
    """
    cells = read(path).cells
    pictures = 0
    for cell, following in pairwise(cells):
        if is_picture(cell):
            pictures += 1
            assert FIGURE.match(following.source), following.source
            assert len(cell.metadata.mystnb.image.alt) > 80
            for output in cell.outputs:
                for kind in ("image/png", "image/gif"):
                    assert kind not in output.get("data", {}) or output.metadata[kind].alt
        else:
            assert not FIGURE.match(following.source), "a caption without a picture"
    assert pictures >= 2


def test_figures_are_numbered_in_order(path: Path) -> None:
    captions = [
        FIGURE.match(cell.source) for cell in read(path).cells if cell.cell_type == "markdown"
    ]
    numbers: dict[str, list[int]] = {}
    for caption in filter(None, captions):
        numbers.setdefault(caption[1], []).append(int(caption[0].split()[-1].rstrip(".")))
    for found in numbers.values():
        assert found == list(range(1, len(found) + 1))


def code_of(notebook: Any) -> list[str]:
    return [cell.source for cell in notebook.cells if cell.cell_type == "code"]


@pytest.mark.slow
def test_runs_from_top_to_bottom(path: Path, tmp_path: Path) -> None:
    """In a process and a directory of its own, with warnings as errors from the first cell on."""
    ours, theirs = PROCESSES.Pipe(duplex=False)
    process = start(run_cells, code_of(read(path)), tmp_path, theirs)
    cell, error, complaints = answer_of(process, ours)
    assert (cell, error, complaints) == (None, None, [])
    process.join()
    assert process.exitcode == 0
    assert list(tmp_path.iterdir()) == []


def run_in_kernel(cells: list[str], folder: Path) -> list[str]:
    """Run cells in a kernel as Jupyter does; return what is written to standard error.

    A message that has come is at times noticed only when it is looked for again.
    """
    manager, client = jupyter_client.manager.start_new_kernel(
        kernel_name="python3", startup_timeout=math.inf, cwd=str(folder)
    )

    def message(channel: Callable[..., dict[str, Any]], request: str) -> dict[str, Any]:
        while True:
            try:
                found = channel(timeout=1.0)
            except queue.Empty:
                assert manager.is_alive()
            else:
                if found["parent_header"].get("msg_id") == request:
                    return found

    complaints = []
    try:
        for number, cell in enumerate(cells):
            request = client.execute(cell)
            answer = message(client.get_shell_msg, request)["content"]
            assert answer["status"] == "ok", f"cell {number}: {answer}"
            while True:
                said = message(client.get_iopub_msg, request)["content"]
                if said.get("name") == "stderr":
                    complaints.append(said["text"])
                if said.get("execution_state") == "idle":
                    break
    finally:
        client.stop_channels()
        manager.shutdown_kernel(now=True)
    return complaints


# What the kernel's own packages are about to drop is not ours to repair.
@pytest.mark.filterwarnings("ignore::DeprecationWarning:(jupyter|traitlets|zmq|tornado).*")
@pytest.mark.filterwarnings("ignore:Proactor event loop:RuntimeWarning")
@pytest.mark.slow
def test_runs_in_a_kernel(tmp_path: Path) -> None:
    """One of them as Jupyter does it, with warnings as errors before anything is imported."""
    strict = 'import warnings\n\nwarnings.simplefilter("error")'
    assert run_in_kernel([strict, *code_of(read(NOTEBOOKS[0]))], tmp_path) == []
    assert list(tmp_path.iterdir()) == []
