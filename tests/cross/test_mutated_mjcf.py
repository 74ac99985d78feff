"""MJCF files changed at random are read as MuJoCo reads them, or refused, or it is told.

What both read is compared: masses, inertias and places, loops and couplings, gravity, armature,
damping, friction, springs and limits. 5000 mutants by hand:
``MUTANTS=5000 pytest tests/cross/test_mutated_mjcf.py``.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from psp3.description.mjcf import read_mjcf
from psp3.description.mjcf_expansion import spelled_out
from psp3.description.mjcf_tree import plain_mjcf
from psp3.description.mujoco_opinion import mujoco_disagreements
from psp3.description.parts import RobotParts
from psp3.errors import PSP3Error
from tests.hostile.mutant import Mutant, faults, outcome
from tests.hostile.xml_mutants import mutants

mujoco = pytest.importorskip("mujoco", reason="MuJoCo is in the extras mujoco and test")

COUNT = int(os.environ.get("MUTANTS", "60"))

FILE = """<mujoco model="fingers">
  <compiler angle="degree" eulerseq="zxy" boundmass="0.01" boundinertia="0.001"/>
  <option gravity="1 -2 -9"/>
  <default><joint damping="0.1" armature="0.02"/>
    <default class="bar"><geom type="capsule" size="0.02" fromto="0 0 0 0.2 0 0" density="700"/>
    </default></default>
  <asset><mesh name="wedge" vertex="0 0 0 0.1 0 0 0 0.2 0 0 0 0.3" inertia="exact"/></asset>
  <worldbody>
    <frame pos="0 0 0.5" euler="10 20 30">
      <body name="crank" childclass="bar"><joint name="crank" axis="0 1 0.5" range="-60 70"/><geom/>
        <body name="coupler" pos="0.2 0 0" quat="1 0.1 0 0.2"><joint name="coupler" axis="0 1 0"
          stiffness="2" springref="15" frictionloss="0.3"/><geom/><site name="tip" pos="0.2 0 0"/>
        </body></body></frame>
    <body name="slider" pos="0.4 0 0.4" zaxis="0 1 2"><joint name="slider" type="slide" ref="0.1"
        range="-0.5 0.6"/>
      <inertial pos="0.01 0 0.02" mass="0.3" fullinertia="0.02 0.03 0.04 0.001 0.002 0.003"/>
      <site name="top" pos="0 0 0.05" axisangle="1 1 0 40"/>
      <body name="ball" pos="0 0.1 0"><joint name="ball" type="ball" pos="0 0 0.1"/>
        <geom type="mesh" mesh="wedge" pos="0.1 0 0" density="900"/></body></body>
    <replicate count="2" sep="-" offset="0 0.2 0" euler="0 0 15">
      <body name="finger" pos="1 0 0"><joint name="finger"/><geom type="box" size="0.1 0.05 0.02"/>
      </body></replicate>
  </worldbody>
  <tendon><fixed name="split"><joint joint="finger-0" coef="0.5"/>
    <joint joint="finger-1" coef="-0.5"/></fixed></tendon>
  <equality><connect name="loop" site1="tip" site2="top"/>
    <joint joint1="finger-0" joint2="finger-1" polycoef="0.1 1 0.2 0 0"/>
    <weld body1="ball" body2="crank" relpose="0.1 0 0 1 0 0.2 0" active="false"/></equality>
  <actuator><motor joint="crank"/><position tendon="split" kp="3"/></actuator>
</mujoco>"""


def of_joints(path: Path, parts: RobotParts, engine: Any) -> list[str]:
    """Return the joints of which numbers differ from MuJoCo's by more than rounding."""
    model, wrong = parts.model, []
    for number, item in enumerate(plain_mjcf(spelled_out(path)).joints):
        joint = model.joints[model.getJointId(item.name)]
        own, at = int(engine.jnt_dofadr[number]), joint.idx_v
        pairs = [
            (model.armature[at], engine.dof_armature[own]),
            (model.damping[at], np.ravel(engine.dof_damping.reshape(engine.nv, -1)[own])[0]),
            (model.upperDryFrictionLimit[at], engine.dof_frictionloss[own]),
        ]
        if joint.nq == 1:
            stiffness, rest = parts.springs.get(item.name, (0.0, 0.0))
            position = int(engine.jnt_qposadr[number])
            reference = engine.qpos0[position]
            pairs.append(
                (stiffness, np.ravel(engine.jnt_stiffness.reshape(engine.njnt, -1)[number])[0])
            )
            if stiffness:
                pairs.append((rest, engine.qpos_spring[position] - reference))
            ends = engine.jnt_range[number] - reference
            limits = ends if engine.jnt_limited[number] else np.array([-np.inf, np.inf])
            pairs += [
                (model.lowerPositionLimit[joint.idx_q], limits[0]),
                (model.upperPositionLimit[joint.idx_q], limits[1]),
            ]
        if not all(np.isclose(ours, theirs, rtol=1e-9, atol=1e-12) for ours, theirs in pairs):
            wrong.append(f"{item.name}: {pairs}")
    return wrong


def differences(path: Path, parts: RobotParts) -> list[str]:
    """Return what MuJoCo reads otherwise; nothing where it refuses the file."""
    try:
        engine = mujoco.MjModel.from_xml_path(str(path))
    except ValueError:
        return []
    found = [str(one) for one in mujoco_disagreements(path)]
    found += of_joints(path, parts, engine)
    gravity = (
        np.zeros(3)
        if engine.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_GRAVITY
        else engine.opt.gravity
    )
    if not np.allclose(parts.model.gravity.linear, gravity, rtol=1e-12):
        found.append(f"gravity {parts.model.gravity.linear}")
    active = [int(kind) for kind, on in zip(engine.eq_type, engine.eq_active0, strict=True) if on]
    couplings = active.count(int(mujoco.mjtEq.mjEQ_JOINT))
    if (len(parts.equations), len(parts.constraint_models)) != (couplings, len(active) - couplings):
        found.append(f"{len(parts.constraint_models)} loops and {len(parts.equations)} couplings")
    for ours, theirs in zip(parts.equations, engine.eq_data[engine.eq_type == 2], strict=False):
        # Of a joint that is held only the constant counts.
        count = 1 if not any(ours.coefficients[1:]) else 5
        if not np.allclose(ours.coefficients[:count], theirs[:count]):
            found.append(f"coupling {ours.coefficients}")
    return found


def check(mutant: Mutant, path: Path) -> tuple[bool, str]:
    """Return whether a mutant was read, and what is wrong with that; nothing if all is well."""
    found = outcome(mutant, path, read_mjcf, PSP3Error)
    fault = faults(found)
    if not fault and found.value is not None:
        fault = "; ".join(differences(path, found.value))
    return found.value is not None, fault


def test_changed_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """No mutant is read otherwise than by MuJoCo; no error but ours; no silent loss."""
    # MuJoCo writes its warnings into a file where it runs.
    monkeypatch.chdir(tmp_path)
    wrong, read = [], 0
    for mutant in mutants(FILE, COUNT):
        was_read, fault = check(mutant, tmp_path / "robot.xml")
        read += was_read
        if fault:
            wrong.append(f"{mutant.number} {mutant.what}: {fault[:300]}")
    assert not wrong, "\n".join(wrong)
    # Many changes are harmless, so that the comparison is not one of refusals alone.
    assert COUNT // 5 < read < COUNT


def test_the_file_itself_is_read(tmp_path: Path) -> None:
    path = tmp_path / "robot.xml"
    path.write_text(FILE)
    assert differences(path, read_mjcf(path)) == []


def test_words_of_no_meaning_are_told(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    path = tmp_path / "robot.xml"
    text = FILE.replace("stiffness=", "stifness=").replace("<tendon>", "<tendons/><tendon>")
    path.write_text(text)
    read_mjcf(path)
    assert "no words of MJCF, and not read: " in caplog.text
    assert "attribute 'stifness' of <joint name='coupler'>" in caplog.text
    assert "the section <tendons>" in caplog.text
    path.write_text(FILE.replace("<geom/>", "<geoms/>", 1))
    with pytest.raises(PSP3Error, match="<geoms> in body 'crank' is not read"):
        read_mjcf(path)
