"""The page to play with answers as fuzzy2 does, to the last bit.

It is one file with WebAssembly in it, made by ``docs/play/make_play.py`` from exported C.
"""

from __future__ import annotations

import importlib.util
import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from selenium import webdriver

from tests.page_helpers import complaints, open_file, picture_of, set_size, wait_for

FOLDER = Path(__file__).resolve().parents[1] / "docs" / "play"
PAGE = FOLDER / "play.html"


@pytest.fixture(scope="module")
def making() -> Any:
    spec = importlib.util.spec_from_file_location("make_play", FOLDER / "make_play.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_page_is_made_from_the_c_that_is_exported_now(making: Any, tmp_path: Path) -> None:
    """Else run ``make pictures``: rules or kernels have changed since."""
    text = PAGE.read_text(encoding="utf-8")
    data = re.search(r'<script type="application/json" id="data">(.*?)</script>', text)
    assert data is not None
    assert json.loads(data[1])["checksum"] == making.sources(tmp_path)
    assert making.page(b"", "").split("<body>")[0] == text.split("<body>")[0]
    script = "<script>\n"
    assert making.page(b"", "").split(script)[1] == text.split(script)[1]


def test_every_answer_is_that_of_python_to_the_last_bit(
    browser: webdriver.Chrome, making: Any
) -> None:
    """Words are triangles, and so no function of the C library is asked, which might differ."""
    rng = np.random.default_rng(0)
    corners = np.array([[0.0, 0.0], [10.0, 10.0], [0.0, 10.0], [5.0, 5.0]])
    inputs = np.concatenate([corners, rng.uniform(0.0, 10.0, (60, 2))])
    open_file(browser, PAGE)
    wait_for(browser, "'ready' in document.body.dataset")
    asked = "return arguments[0].map(([service, food]) => ask(arguments[1], service, food))"
    for number, doubt in enumerate(making.DOUBTS):
        system = making.system_of(doubt)
        answers = np.array(browser.execute_script(asked, inputs.tolist(), number), float)
        expected = np.concatenate([system(inputs), system.type_reduced(inputs)[:, 0]], axis=1)
        assert np.array_equal(answers, expected)
        assert (np.ptp(answers[:, 1:], axis=1).max() > 0.1) == (doubt > 0.0)


def test_a_person_moves_a_slider_and_reads_the_answer(
    browser: webdriver.Chrome, making: Any
) -> None:
    open_file(browser, PAGE)
    set_size(browser, 900, 1000)
    wait_for(browser, "'ready' in document.body.dataset")
    browser.execute_script(
        """for (const [id, value] of [["in0", 8.0], ["in1", 3.0], ["doubt", 3]]) {
          document.getElementById(id).value = value;
          document.getElementById(id).dispatchEvent(new Event("input"));
        }"""
    )
    system = making.system_of(making.DOUBTS[3])
    tip, (left, right) = system([8.0, 3.0])[0], system.type_reduced([8.0, 3.0])[0]
    said = browser.execute_script("return document.getElementById('answer').textContent")
    assert said == f"tip {tip:.2f} %, between {left:.2f} and {right:.2f} %"
    picture_of(browser, "play")
    assert complaints(browser) == []


@pytest.mark.parametrize("name", ["controllers", "delta"])
def test_recorded_motions_are_whole(name: str) -> None:
    """Every part that moves is drawn, and what moves goes on for seconds."""
    commands = json.loads((FOLDER / f"{name}.json").read_text(encoding="utf-8"))
    drawn = {one["path"] for one in commands if one["type"] == "set_object"}
    (animation,) = (one for one in commands if one["type"] == "set_animation")
    moved = {one["path"] for one in animation["animations"]}
    assert len(moved) > 3
    assert all(any(path.startswith(node) for path in drawn) for node in moved)
    times = [
        track["times"][-1] for one in animation["animations"] for track in one["clip"]["tracks"]
    ]
    assert min(times) >= 2.0
