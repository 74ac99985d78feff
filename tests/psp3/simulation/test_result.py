"""Results in files: they come back bit for bit, and what is no result is refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import psp3
from psp3.errors import InvalidResultFile, SimulationDiverged
from psp3.trajectories import Helix
from tests.psp3.simulation.controllers import Recording

ROBOT = psp3.load("psp3")

HELIX = Helix(robot=ROBOT)


def test_results_come_back_from_a_file_bit_for_bit(tmp_path: Path) -> None:
    result = psp3.simulate(ROBOT, psp3.PD(), HELIX, 0.1)
    path = result.save(tmp_path / "run.npz")
    loaded = psp3.load_result(path)
    for name in ("t", "heights", "speeds", "torque", "tip"):
        np.testing.assert_array_equal(getattr(loaded, name), getattr(result, name))
    for mine, other in zip(result.desired, loaded.desired, strict=True):
        np.testing.assert_array_equal(mine, other)
    assert [file.name for file in tmp_path.iterdir()] == ["run.npz"]


@pytest.mark.parametrize("share", [0.0, 0.1, 0.5, 0.9, 0.999])
def test_a_truncated_file_is_refused(tmp_path: Path, share: float) -> None:
    path = psp3.simulate(ROBOT, psp3.PD(), HELIX, 0.1).save(tmp_path / "run.npz")
    content = path.read_bytes()
    path.write_bytes(content[: int(share * len(content))])
    with pytest.raises(InvalidResultFile, match=r"run\.npz"):
        psp3.load_result(path)


def test_a_damaged_file_is_refused(tmp_path: Path) -> None:
    """One flipped byte in the data of any array is seen by the checksum or the decompressor."""
    path = psp3.simulate(ROBOT, psp3.PD(), HELIX, 0.1).save(tmp_path / "run.npz")
    content = bytearray(path.read_bytes())
    for place in range(1000, len(content) - 2000, 3001):
        damaged = content.copy()
        damaged[place] ^= 0xFF
        path.write_bytes(bytes(damaged))
        with pytest.raises(InvalidResultFile):
            psp3.load_result(path)


def test_files_of_another_kind_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "other.npz"
    np.savez(path, t=np.zeros(3))
    with pytest.raises(InvalidResultFile, match="format 'none'"):
        psp3.load_result(path)
    np.savez(path, format=np.array("psp3-result-2"), t=np.zeros(3))
    with pytest.raises(InvalidResultFile, match="must hold"):
        psp3.load_result(path)
    names = [
        "t",
        "heights",
        "speeds",
        "torque",
        "tip",
        *(f"desired_{name}" for name in ("heights", "speeds", "accelerations", "tip")),
    ]
    np.savez(path, format=np.array("psp3-result-2"), **{name: np.zeros(3) for name in names})
    with pytest.raises(InvalidResultFile, match="shape"):
        psp3.load_result(path)
    np.savez(path, allow_pickle=True, t=np.array([{}]))
    with pytest.raises(InvalidResultFile):
        psp3.load_result(path)
    with pytest.raises(InvalidResultFile):
        psp3.load_result(tmp_path / "missing.npz")
    np.save(tmp_path / "array.npy", np.zeros(3))
    with pytest.raises(InvalidResultFile):
        psp3.load_result(tmp_path / "array.npy")


def test_positions_have_the_name_of_the_3_psp_too(tmp_path: Path) -> None:
    """Users' code asks for heights, and their files hold them."""
    result = psp3.simulate(ROBOT, psp3.PD(), HELIX, 0.01)
    assert result.heights is result.positions
    assert result.desired.heights is result.desired.positions
    with np.load(result.save(tmp_path / "run.npz")) as file:
        assert {"heights", "desired_heights"} <= set(file.files)
        np.testing.assert_array_equal(file["desired_heights"], result.desired.positions)
    with pytest.raises(SimulationDiverged) as caught:
        psp3.simulate(ROBOT, Recording((500.0, 500.0, 500.0)), HELIX, 5.0)
    assert caught.value.heights is caught.value.positions
