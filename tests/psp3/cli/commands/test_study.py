"""``psp3 study`` as a user meets it: tables, files, wrong input, and Ctrl-C."""

from __future__ import annotations

import csv
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from multiprocessing.connection import Connection
from pathlib import Path

import pytest

from psp3.cli.commands import study as study_command
from psp3.study import Study, grid
from psp3.study.statistics import compare, summarize
from tests.processes import PROCESSES, answer_of, program
from tests.psp3.cli.answers import Answer, Run, words
from tests.study_helpers import count_rows

SMALL = ("--duration", "0.3", "--seeds", "3", "--snr", "20", "--snr", "10")


@pytest.fixture
def study(psp3_command: Run) -> Run:
    """Run ``psp3 study FILE`` in this process, in an empty directory, in 80 columns."""

    def run(*arguments: object, file: str = "study.sqlite") -> Answer:
        return psp3_command("study", file, *arguments)

    return run


def test_tables_hold_the_estimates_and_the_seeds(study: Run) -> None:
    """Against the library's statistics on the rows of the file, to three printed digits."""
    status, out, err = study(*SMALL, "--controller", "t1", "--controller", "it2")
    assert status == 0
    assert max(map(len, out.splitlines())) <= 80
    rows = Study("study.sqlite").rows()
    assert len(rows) == 2 * 2 * 3
    printed = " ".join(out.split())
    for summary in summarize(rows):
        for estimate in (summary.mean, summary.median):
            for number in (estimate.value, estimate.low, estimate.high):
                assert f"{number:.3g}" in printed
        assert summary.diverged.count == 3
    comparisons = compare(rows, "it2", "t1")
    assert len(comparisons) == 2
    for comparison in comparisons:
        assert f"{comparison.difference.value:.3g}" in printed
        assert f"{comparison.ratio.value:.3g}" in printed
        assert f"{comparison.ratio_of_geometric_means.value:.3g}" in printed
    assert "Type-2 beside type-1" in printed
    assert "seeds" in printed
    assert "in simulations of 10 such seeds they held the truth in 93.1 % (mean)" in printed
    assert "95.9 % (ratio of geometric means)." in printed
    assert "56.1)" in printed, "no run in three diverged: Wilson's interval ends at 56.1 %"
    assert err.splitlines()[0] == "[0/12]"
    assert err.splitlines()[-1].startswith("[12/12] ")
    assert "runs/s" in err


def test_same_command_does_nothing_again_and_more_seeds_only_those(study: Run) -> None:
    first = study(*SMALL, "--controller", "t1")
    second = study(*SMALL, "--controller", "t1")
    assert second[:2] == first[:2]
    assert second[2] == "[6/6]\n"
    status, out, err = study(*SMALL, "--seeds", 5, "--controller", "t1")
    assert (status, err.splitlines()[0]) == (0, "[6/10]")
    assert " 5" in out
    assert count_rows(Path("study.sqlite")) == 10


def test_defaults_are_those_of_table_6_3(study: Run) -> None:
    """PD and CTC once each.

    Type-1 and type-2 without noise once each, and at 20, 15 and 10 dB for every seed.
    """
    status, out, _ = study("--duration", 0.1, "--seeds", 2)
    assert status == 0
    rows = Study("study.sqlite").rows()
    assert len(rows) == 2 + 2 * (1 + 3 * 2)
    assert {row["snr_db"] for row in rows} == {10.0, 15.0, 20.0, float("inf")}
    assert "∞" in out


def test_every_option_reaches_the_runs(study: Run) -> None:
    arguments = (
        "--controller gt2 --reading plant --snr 15 --seeds 2 --trajectory line --learner strict "
        "--terms 3 --mean-variation 0.2 --defuzzify last"
    )
    status, out, _ = study(*arguments.split(), "--payload", 0.5, "--duration", 0.1, "--workers", 1)
    assert status == 0
    assert out.startswith("Sum of squared errors")
    runs = grid(
        controller="gt2",
        reading="plant",
        snr_db=15.0,
        seed=range(2),
        trajectory="line",
        learner="strict",
        n_terms=3,
        mean_variation=0.2,
        defuzzify="last",
        payload=0.5,
        duration=0.1,
    )
    assert len(Study("study.sqlite", runs).rows()) == 2
    assert count_rows(Path("study.sqlite")) == 2


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ("--payload 2", "no noise, trajectory helix, payload (kg) 2"),
        ("--reading plant", "no noise, trajectory helix"),
        ("--reading plant --snr 20 --delay 1", "reading plant, SNR (dB) 20, trajectory helix, de"),
        ("--reading plant --snr inf --snr 20", "reading plant, trajectory helix"),
        ("--reading plant --reading measurement --snr 20", "SNR (dB) 20, trajectory helix"),
    ],
)
def test_the_title_says_what_all_runs_have_in_common(study: Run, arguments: str, said: str) -> None:
    """And a column what they have not; without noise there is no reading of it."""
    snr = () if "--snr" in arguments else ("--snr", "inf")
    quick = ("--controller", "ctc", "--duration", 0.1, "--seeds", 1)
    _, out, _ = study(*arguments.split(), *snr, *quick)
    assert f"one sample per 0.05 s (m²), {said}" in words(out)
    assert ("reading" in words(out).split("controller")[1]) == (arguments.count("--reading") == 2)


def test_wide_studies_stay_within_80_columns_too(study: Run) -> None:
    arguments = (
        "--controller t1 --controller it2 --trajectory line --trajectory fast-helix --reading "
        "parameters --reading plant --seeds 2"
    )
    status, out, _ = study(
        *arguments.split(),
        "--snr",
        20,
        "--mean-variation",
        0.1,
        "--mean-variation",
        0.3,
        "--duration",
        0.1,
    )
    assert status == 0
    assert max(map(len, out.splitlines())) <= 80
    for heading in ("reading", "trajectory", "variation", "seeds"):
        assert heading in out


def test_csv_holds_every_run(study: Run) -> None:
    status, out, _ = study(*SMALL, "--controller", "t1", "--csv", "table.csv")
    assert status == 0
    assert out.splitlines()[-1] == "table.csv"
    with Path("table.csv").open(encoding="utf-8", newline="") as file:
        read = list(csv.DictReader(file))
    assert [float(row["effort"]) for row in read] == [
        row["effort"] for row in Study("study.sqlite").rows()
    ]


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ("--seeds 0", "--seeds"),
        ("--seeds many", "--seeds"),
        ("--snr loud", "--snr"),
        ("--snr nan", "--snr must be a number"),
        ("--controller t3", "unknown controller 't3'; known are feed-forward, pd"),
        ("--reading hearsay", "unknown reading 'hearsay'"),
        ("--trajectory spiral", "unknown trajectory 'spiral'"),
        ("--learner rote", "unknown learner 'rote'"),
        ("--terms 0", "--terms must be"),
        ("--mean-variation -1", "--mean-variation must be"),
        ("--payload -2", "payload must be finite and not negative"),
        ("--duration 0", "duration must be finite and positive"),
        ("--workers 0", "--workers"),
        ("--workers 2 --scheduler tcp://127.0.0.1:8786", "--workers does not apply to --scheduler"),
        (
            "--scheduler somewhere",
            "scheduler must be an address such as tcp://host:8786, got 'somewhere'",
        ),
        ("--csv study.sqlite", "study.sqlite: the name of a table must end in .csv"),
        ("--csv nowhere/table.csv", "there is no directory nowhere"),
    ],
)
def test_wrong_input_is_one_clear_line_and_no_run_is_done(
    study: Run, arguments: str, said: str
) -> None:
    status, out, err = study(*arguments.split())
    assert (status, out) == (2, "")
    message = err.splitlines()[-1]
    assert message.startswith("psp3")
    assert said in message
    assert len([line for line in err.splitlines() if not line.startswith("[0/")]) == 1
    # Only a scheduler is looked for when the file is there already.
    assert not Path("study.sqlite").exists() or "somewhere" in arguments


def test_a_table_does_not_overwrite_the_study(study: Run) -> None:
    status, _, err = study("--csv", "study.csv", file="study.csv")
    assert status == 2
    assert "--csv would overwrite FILE" in err
    assert not Path("study.csv").exists()


@pytest.mark.parametrize(
    ("file", "said"),
    [
        ("nowhere/study.sqlite", "there is no directory"),
        (".", "is a directory"),
        ("notes.txt", "is not the file of a study"),
        ("protected.sqlite", "is read-only"),
    ],
)
def test_files_that_cannot_hold_a_study(study: Run, file: str, said: str) -> None:
    Path("notes.txt").write_text("no database\n" * 100)
    Path("protected.sqlite").touch(mode=0o444)
    status, out, err = study(*SMALL, file=file)
    assert (status, out) == (2, "")
    assert said in err
    assert len(err.splitlines()) == 1


def test_file_of_another_study(study: Run) -> None:
    study("--duration", 0.1, "--controller", "pd")
    status, _, err = study("--duration", 0.2, "--controller", "pd")
    assert status == 2
    assert "holds another study: its duration [s] is 0.1, not 0.2" in err


def wait_for_an_interrupt(rows: int, begun: Connection) -> None:
    """Let the command say when it has so many results, and wait there to be interrupted."""
    shown = study_command.counted_progress

    @contextmanager
    def held(what: str) -> Iterator[Callable[[int, int, float], None]]:
        with shown(what) as progress:

            def hold(done: int, total: int, rate: float) -> None:
                progress(done, total, rate)
                if done >= rows:
                    begun.send(done)
                    while True:
                        time.sleep(0.01)

            yield hold

    study_command.counted_progress = held


@pytest.mark.slow
def test_interrupt_leaves_a_valid_file_and_says_how_to_go_on(study: Run, tmp_path: Path) -> None:
    """A real SIGINT to a real process, as soon as the first results are in."""
    arguments = ["--duration", "2", "--seeds", "200", "--controller", "t1", "--snr", "20"]
    ours, theirs = PROCESSES.Pipe(duplex=False)
    with program(
        "study",
        "study.sqlite",
        *arguments,
        folder=tmp_path,
        prepare=wait_for_an_interrupt,
        given=(3, theirs),
    ) as psp3:
        theirs.close()
        answer_of(psp3.process, ours)
        psp3.interrupt()
        status, out, err = psp3.end()
    assert status == 130, err
    assert out == ""
    kept = count_rows(tmp_path / "study.sqlite")
    assert 3 <= kept < 200
    assert err.splitlines()[-2:] == [
        f"{kept} of 200 runs are in study.sqlite; run the same command to continue",
        "psp3: interrupted",
    ]
    status, _, err = study(*arguments[2:], "--duration", 2, "--seeds", kept + 1)
    assert (status, err.splitlines()[-1].split()[0]) == (0, f"[{kept + 1}/{kept + 1}]")


def test_other_robots_are_named_after_the_file(study: Run) -> None:
    arguments = ("--controller", "ctc", "--controller", "pd", "--duration", "0.1", "--seeds", "1")
    status, out, _ = study("five_bar", "delta", *arguments, "--csv", "rows.csv")
    assert status == 0
    assert {row["robot"] for row in Study("study.sqlite").rows()} == {"five_bar", "delta"}
    assert "m² or rad²" in " ".join(out.split())
    with Path("rows.csv").open(encoding="utf-8") as file:
        assert {row["robot"] for row in csv.DictReader(file)} == {"five_bar", "delta"}


def test_a_robot_in_place_of_the_file_is_refused(study: Run) -> None:
    status, _, err = study(*SMALL, file="delta")
    assert status == 2
    assert "psp3 study delta.sqlite delta" in " ".join(err.split())
    assert not Path("delta").exists()
