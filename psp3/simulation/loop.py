"""The loop of controller and plant: in Python for any, compiled if both have tables.

Both versions have the same parts: encoders, measurement noise, force limits, delay, drives, and
ends of the joints.
"""

from __future__ import annotations

import operator
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from psp3.checks import Array
from psp3.control.controller import Controller
from psp3.simulation import kernels
from psp3.simulation.arguments import checked_state
from psp3.simulation.encoder import Encoder
from psp3.simulation.kernels import BEYOND_LIMITS, LEFT_POSES, NO_FORCE, WHOLE, Track, Wires
from psp3.simulation.plant import Plant
from psp3.trajectories.motion import Motion

CHUNK = 8000
"""Number of steps times joints after which the compiled loop returns to Python, where Ctrl-C can
end it. This takes about 3 ms for the 3-PSP, and some tenths of a second for robots with many loops
and friction.
"""


@dataclass(frozen=True)
class Wiring:
    """The parts between controller and robot.

    Parameters
    ----------
    period : float
        Control period [s].
    low, high : (p,) ndarray
        Ends of the joints; the loop stops when a joint passes one.
    limit : (m,) ndarray
        Largest forces; infinite for none.
    resolution : (k,) ndarray
        Resolution of the encoders of the first k coordinates, 0 for perfect ones; the others are
        seen exactly.
    delay : int
        Number of periods by which forces are delayed.
    noise : (N, p + n) ndarray, optional
        Measurement noise on positions and speeds at each sample.
    """

    period: float
    low: Array
    high: Array
    limit: Array
    resolution: Array
    delay: int = 0
    noise: Array | None = None


def unbounded(
    period: float, resolution: Array, delay: int = 0, noise: Array | None = None
) -> Wiring:
    """Return a wiring without ends of the joints and without force limits."""
    infinite = np.full(len(resolution), np.inf)
    return Wiring(period, -infinite, infinite, infinite, resolution, delay, noise)


class Ended(NamedTuple):
    """How a loop ended.

    It holds the number of ``samples`` whose force is known, ``why`` it ended, the last ``state`` (p
    + n,), and the value that the controller ``returned`` last if that was not a force.
    """

    samples: int
    why: int
    state: Array
    returned: object = None


def new_track(
    t: Array, desired: Motion, numbers_said: int = 0, widths: tuple[int, int] | None = None
) -> Track:
    """Return an empty track for a loop, for a desired motion at times t (N,).

    ``widths`` are the sizes of a state and of the motors' forces, if they are not 2n and n.
    """
    count, n = desired.positions.shape
    state, motors = (2 * n, n) if widths is None else widths
    wanted = np.concatenate(desired[:3], axis=1)
    states = np.empty((count, state))
    asked, applied = np.empty((count, motors)), np.empty((count, motors))
    return Track(t, wanted, states, asked, applied, np.empty((count, motors + numbers_said)))


def new_wires(wiring: Wiring, width: int) -> Wires:
    """Return a wiring for compiled loops, whose encoders have no reading yet.

    ``width`` is the size of a state, p + n.
    """
    noise = np.empty((0, width)) if wiring.noise is None else wiring.noise
    return Wires(
        *(wiring.resolution, np.zeros(len(wiring.resolution)), noise),
        *(wiring.limit, wiring.low, wiring.high, np.zeros(width)),
    )


def compiled_loop(
    controller: Any,
    plant: Any,
    wiring: Wiring,
    track: Track,
    state: Array,
    first: int = 0,
    progress: Callable[[int], None] | None = None,
    every: int | None = None,
    last: int | None = None,
    wires: Wires | None = None,
) -> Ended:
    """Run a controller and a plant in the compiled loop.

    Parameters
    ----------
    controller : NamedTuple
        Table of a controller.
    plant : CompiledPlant
        A plant with ``robot``, a table, ``drives`` and ``steps``, as ``robot.compiled_steps`` makes
        it.
    wiring, track
        The parts between them, and the record to fill in.
    state : (p + n,) ndarray
        State of the robot at the first sample.
    first : int
        Index of the first sample; those before are already filled in.
    progress : callable, optional
        Called with the number of finished samples.
    every : int
        Number of samples between calls of ``progress``.
    last : int, optional
        The sample before which the loop pauses; ``state`` is then that of this sample.
    wires : Wires, optional
        Wires of a paused loop that continues; they hold the last encoder readings.
    """
    count, joints = len(track.t) if last is None else last, len(wiring.low)
    state, ending = np.array(state), np.array([WHOLE])
    wires = new_wires(wiring, len(state)) if wires is None else wires
    done, chunk = first, max(1, CHUNK // (joints * plant.steps))
    while done < count:
        end = min(done + chunk, count)
        if every is not None:
            end = min(end, (done // every + 1) * every)
        done = kernels.run(
            *(controller, plant.robot, plant.drives, state, wires, track),
            *(wiring.period, plant.steps, wiring.delay, done, end, ending),
        )
        if ending[0] != WHOLE:
            return Ended(done, int(ending[0]), state, wires.seen)
        if progress is not None:
            progress(done)
    return Ended(count, WHOLE, state)


def python_loop(
    controller: Controller,
    plant: Plant,
    wiring: Wiring,
    track: Track,
    desired: Motion,
    state: Array,
    finite_force: Callable[[object], Array | None],
    after: Callable[[int], None],
) -> Ended:
    """Run any controller and any plant in Python.

    Parameters
    ----------
    controller, plant, wiring, track, state
        As for :func:`compiled_loop`, but controller and plant are objects, and the controller's
        reports are not filled in.
    desired : Motion
        The desired motion, (N, n) each.
    finite_force : callable
        Converts a controller's return value to forces (n,), or to None if it is not a force.
    after : callable
        Called with each sample after its force is known.
    """
    p, count, low, high = len(wiring.low), len(track.t), wiring.low.tolist(), wiring.high.tolist()
    encoder, is_limited = Encoder(wiring.resolution, wiring.period), np.isfinite(wiring.limit).any()
    positions, speeds = state[:p], state[p:]
    plant.start(positions, speeds)
    times = track.t.tolist()
    for k, now in enumerate(map(Motion._make, zip(*desired, strict=True))):
        row = track.states[k]
        row[:p], row[p:] = positions, speeds
        seen = row if wiring.noise is None else row + wiring.noise[k]
        # The controller gets copies, which it may change.
        returned = controller.torque(times[k], *encoder.read(seen[:p], seen[p:]), now)
        force = finite_force(returned)
        if force is None:
            return Ended(k, NO_FORCE, row.copy(), returned)
        if is_limited:
            force = np.clip(force, -wiring.limit, wiring.limit)
        track.asked[k] = force
        force = track.applied[k] = track.asked[max(k - wiring.delay, 0)]
        after(k)
        if k + 1 == count:
            break
        reached = plant.advance(force, wiring.period)
        if reached is None:
            return Ended(k + 1, LEFT_POSES, row.copy())
        positions, speeds = checked_state(reached, p, len(speeds))
        if not _is_between(low, positions.tolist(), high):
            return Ended(k + 1, BEYOND_LIMITS, np.concatenate([positions, speeds]))
    return Ended(count, WHOLE, track.states[-1].copy())


def _is_between(low: list[float], values: list[float], high: list[float]) -> bool:
    """Return whether all values are within their limits and none is NaN.

    For three numbers this is faster than arrays.
    """
    return all(map(operator.le, low, values)) and all(map(operator.le, values, high))
