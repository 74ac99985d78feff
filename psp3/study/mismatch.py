r"""A grid of runs: controllers on robots that differ from the controllers' models.

Adaptive fuzzy controllers compete with exact models, integral action and regulators.

The model of every controller is the nominal robot, as designed. The robot that it steers carries a
payload, its masses and inertias are off by random factors, and its measurements are noisy. The
fuzzy controllers were trained on the nominal robot, from records that are exact or noisy.

=================  =================================================================================
controller         what it is
=================  =================================================================================
ctc                computed torque with the exact model of the nominal robot, gains of Table 6.1
ctc-integral       the same with an integral of the error
lqr                the forces of the desired motion and a linear-quadratic regulator as stiff as
                   computed torque is
lqr-stiff          the same, ten times as stiff
t1, it2            fuzzy computed torque as trained, :class:`psp3.FuzzyComputedTorque`
adaptive-t1, -it2  the same with rules that adapt, :class:`psp3.AdaptiveFuzzyComputedTorque`
=================  =================================================================================

Runs of one seed see the same robot, the same noise and the same records, whatever the controller,
so they are compared in pairs.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import product

from fuzzy2.learning.noise import mean_variation_from_snr
from psp3.checks import checked_count
from psp3.drives.drive import NO_DRIVE, Drive
from psp3.errors import InvalidValue
from psp3.fuzzy_control.computed_torque import checked_snr
from psp3.published import DURATION
from psp3.study.comparison import Comparison
from psp3.study.run import ADAPTIVE, Run
from psp3.study.study import results_of

CONTROLLERS = ("ctc", "ctc-integral", "lqr", "lqr-stiff", "t1", "it2", *ADAPTIVE)
"""Names of the controllers."""

PAIRS = (
    ("adaptive-t1", "ctc-integral"),
    ("adaptive-t1", "lqr-stiff"),
    ("adaptive-it2", "adaptive-t1"),
    ("it2", "t1"),
)
"""Pairs of controllers whose ratios are tabulated."""

MEASUREMENT_NOISE = (1e-5, 1e-3)
"""Standard deviations of white noise on measured positions [m or rad] and speeds."""

MASS_MISMATCH = 0.05
"""Masses and inertias are off by factors exp(0.05 ε), with ε standard normal. On the 3-PSP, a mass
of 0.25 kg · abs(ε) rides on the star besides the payload.
"""

UNCERTAINTY_SNR = 20.0
"""Signal-to-noise ratio [dB] that sets the mean variation of the type-2 terms if the records are
exact.
"""


def uncertainty(snr_db: float) -> float:
    """Return the mean variation of type-2 terms for records of a signal-to-noise ratio [dB]."""
    return float(mean_variation_from_snr(min(checked_snr(snr_db), UNCERTAINTY_SNR)))


def case(
    payload: float = 0.0,
    trajectory: str | None = None,
    snr_db: float = math.inf,
    drive: Drive = NO_DRIVE,
    robot: str = "psp3",
    duration: float = DURATION,
) -> Run:
    """Return a case: the fields that runs of different controllers and seeds share.

    Parameters
    ----------
    payload, trajectory, robot, duration
        Fields of :class:`psp3.study.run.Run`.
    snr_db : float
        Signal-to-noise ratio of the records that the rules are learned from [dB]; infinite for
        exact records.
    drive : Drive
        Friction and inertia of the motors, which no controller models.

    Raises
    ------
    InvalidValue
        If ``drive`` is not a drive, or the ratio is out of range.
    """
    if not isinstance(drive, Drive):
        raise InvalidValue("drive", drive, "a psp3.drives.Drive")
    position_noise, speed_noise = MEASUREMENT_NOISE
    return Run(
        "t1",
        snr_db=snr_db,
        trajectory=trajectory,
        mean_variation=uncertainty(snr_db),
        payload=payload,
        coulomb_friction=drive.coulomb_friction,
        viscous_friction=drive.viscous_friction,
        motor_inertia=drive.motor_inertia,
        lead=drive.lead,
        duration=duration,
        robot=robot,
        mass_mismatch=MASS_MISMATCH,
        position_noise=position_noise,
        speed_noise=speed_noise,
    )


def compare(
    payloads: Sequence[float] = (0.0, 1.0, 2.0, 5.0),
    trajectories: Sequence[str] = ("helix", "waypoints", "fast-helix"),
    snrs_db: Sequence[float] = (math.inf, 20.0),
    seeds: int = 8,
    controllers: Sequence[str] = CONTROLLERS,
    duration: float = DURATION,
    drive: Drive = NO_DRIVE,
    workers: int | None = None,
    robot: str = "psp3",
) -> Comparison:
    """Run all controllers in all cases with all seeds.

    Parameters
    ----------
    payloads, trajectories, snrs_db : sequence
        Fields of the cases; there is one case for every combination.
    seeds : int
        Number of seeds, at least 2.
    controllers : sequence of str
        Controller names that a :class:`psp3.study.run.Run` takes.
    duration : float
        Length of the runs [s].
    drive : Drive
        Drive of all cases, see :func:`case`.
    workers : int, optional
        Number of threads; the number of processors by default. The result does not depend on it.
    robot : str
        Robot of all cases.

    Returns
    -------
    Comparison

    Raises
    ------
    InvalidValue, UnknownName
        If an argument is invalid.
    StrokeExceeded
        If a trajectory leaves the joints' limits within the duration.
    """
    cases = [
        case(payload, path, snr, drive, robot, duration)
        for payload, path, snr in product(payloads, trajectories, snrs_db)
    ]
    count = checked_count("seeds", seeds, 2)
    # Controllers without rules do not use the records, so their runs are the same for every
    # ``snr_db`` and are done once.
    runs = [
        replace(one, controller=name, seed=seed)
        for one, name, seed in product(cases, controllers, range(count))
    ]
    return Comparison(cases, controllers, count, results_of(runs, workers))
