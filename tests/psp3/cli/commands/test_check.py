"""``psp3 check``: what is in a robot file, and what to do about it."""

from __future__ import annotations

from tests.psp3.cli.answers import Run, words


def test_nothing_is_odd_about_a_robot_of_ours(psp3_command: Run) -> None:
    answer = psp3_command("check", "five_bar")
    text = words(answer.out)
    assert (answer.status, answer.err) == (0, "")
    for part in (
        "2 degrees of freedom",
        "tip-leg2_end (3d)",
        "redundant equations 1",
        "MuJoCo agrees to",
        "problems none",
    ):
        assert part in text


def test_inertia_of_the_thesis_is_odd(psp3_command: Run) -> None:
    """Table 3.1 gives a nut 0.003, 0.39 and 0.3294 kg m²: 0.39 is more than the other two."""
    (report,) = psp3_command("check", "psp3", "--json").json["files"]
    whats = [one["what"] for one in report["found"]["findings"]]
    assert any("exceeds the sum of the other two by 15 %" in what for what in whats)


def test_a_file_that_is_refused_does_not_hide_the_others(psp3_command: Run) -> None:
    answer = psp3_command("check", "nosuch", "five_bar", "--json")
    refused, found = answer.json["files"]
    assert answer.status == 2
    assert "nosuch" in refused["error"]
    assert found["found"]["title"] == "five_bar"
    assert "refused" in psp3_command("check", "nosuch").out
