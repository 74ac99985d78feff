r"""Drives of the actuated joints.

A drive relates the motor's torque to the force that moves the joint.

A motor turns a screw, and the nut moves by the lead :math:`l` in each revolution. Without losses
the power is the same on both sides, :math:`\tau_m \omega_m = f \dot a` with :math:`\omega_m =
(2\pi/l)\, \dot a`, so a motor torque :math:`\tau_m` gives a force

.. math:: f = \frac{2\pi}{l}\, \tau_m,

and the rotor, with everything that turns with it, acts on the joint like a mass :math:`J = J_m
(2\pi/l)^2`. The equation of motion is then

.. math:: (M + J)\, \ddot a + C\, \dot a + G + B\, \dot a + \varphi = f, \qquad
          \varphi_i \in F_i \operatorname{Sgn}(\dot a_i),

with viscous friction :math:`B` and dry (Coulomb) friction :math:`\varphi`. Sgn is the set-valued
sign: 1 or −1 for a joint that slips either way, and all of [−1, 1] for one at rest. So a joint at
rest stays exactly at rest while a friction of at most :math:`F_i` can hold it: there is no
regularization, no creep, and no additional time scale. Which of the joints at rest begin to slip
follows from Gauss's principle of least constraint with friction, a strictly convex problem with one
solution,

.. math:: \ddot a = \arg\min_x\; \tfrac12 (x - a_0)^T (M + J)\, (x - a_0)
          + \sum_{i:\, \dot a_i \ne 0} \varphi_i x_i
          + \sum_{i:\, \dot a_i = 0} F_i \lvert x_i \rvert,

where :math:`a_0` is the acceleration without dry friction. All friction acts at the joint. Static
and sliding friction are the same number, and neither depends on the load. A screw's efficiency is
not a separate parameter, because its losses are modeled as friction.

Sources: J.-J. Moreau, "Unilateral contact and dry friction in finite freedom dynamics", in
Nonsmooth Mechanics and Applications, 1988 (friction as a set-valued law; least constraint); F.
Pfeiffer and C. Glocker, Multibody Dynamics with Unilateral Contacts, 1996 (stick and slip in
coupled systems).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from psp3.checks import Array, checked_count, checked_not_negative, checked_positive, finite_array
from psp3.errors import InvalidValue


@dataclass(frozen=True)
class Drive:
    r"""Friction, motor inertia and lead of one actuated joint; by default an ideal drive.

    Parameters
    ----------
    coulomb_friction : float
        Dry friction :math:`F` [N], at a revolute joint [N m].
    viscous_friction : float
        Viscous friction :math:`B` [N s/m], at a revolute joint [N m s/rad].
    motor_inertia : float
        Moment of inertia :math:`J_m` of the motor and all parts that turn with it [kg m²].
    lead : float, optional
        Travel :math:`l` of the joint in one revolution of the motor [m]. For a revolute joint it is
        :math:`2\pi` over the gear ratio [rad]. None if no motor is modeled.

    Raises
    ------
    InvalidValue
        If a number is negative or not finite, or if the motor has inertia but no lead is given.
    """

    coulomb_friction: float = 0.0
    viscous_friction: float = 0.0
    motor_inertia: float = 0.0
    lead: float | None = None

    def __post_init__(self) -> None:
        for name in ("coulomb_friction", "viscous_friction", "motor_inertia"):
            object.__setattr__(self, name, checked_not_negative(name, getattr(self, name)))
        if self.lead is not None:
            object.__setattr__(self, "lead", checked_positive("lead", self.lead))
        elif self.motor_inertia > 0.0:
            raise InvalidValue("lead", None, "given where the motor has inertia")

    @property
    def reflected_inertia(self) -> float:
        r"""Inertia of the motor as the joint feels it, :math:`J = J_m (2\pi/l)^2`.

        It is in kg, or in kg m² at a revolute joint.
        """
        return 0.0 if self.motor_inertia == 0.0 else self.motor_inertia * self._motor_turn**2

    @property
    def _motor_turn(self) -> float:
        """Angle of the motor per travel of the joint [rad/m]."""
        if self.lead is None:
            raise InvalidValue(
                "lead", None, "given to the drive, to tell forces from motor torques"
            )
        return 2.0 * math.pi / self.lead

    def motor_torque(self, force: ArrayLike) -> Array:
        r"""Return the motor torque of a force, :math:`\tau_m = f\, l / 2\pi`.

        Parameters
        ----------
        force : (...) array_like
            Force at the joint, such as ``result.torque`` [N].

        Returns
        -------
        (...) ndarray
            Torque of the motor [N m].

        Raises
        ------
        InvalidValue
            If the drive has no lead.
        InvalidArray
            If the forces are not finite numbers.
        """
        return finite_array("force", force) / self._motor_turn

    def force(self, motor_torque: ArrayLike) -> Array:
        r"""Return the force of a motor torque, :math:`f = \tau_m\, 2\pi / l`.

        Parameters
        ----------
        motor_torque : (...) array_like
            Torque of the motor [N m], for example of a limit: ``simulate(...,
            torque_limit=drive.force(1.27))``.

        Returns
        -------
        (...) ndarray
            Force at the joint [N].

        Raises
        ------
        InvalidValue
            If the drive has no lead.
        InvalidArray
            If the torques are not finite numbers.
        """
        return finite_array("motor_torque", motor_torque) * self._motor_turn


NO_DRIVE = Drive()
"""A drive that adds nothing to the robot."""


def drive_table(drive: Drive | Sequence[Drive], joints: int) -> Array:
    """Return the numbers that the equation of motion needs.

    Parameters
    ----------
    drive : Drive or sequence of Drive
        One for all actuated joints, or one for each.
    joints : int
        Number n of actuated joints.

    Returns
    -------
    (n, 3) ndarray
        Reflected inertia [kg], viscous friction [N s/m] and dry friction [N] of every joint.

    Raises
    ------
    InvalidValue
        If it is neither a drive nor one for each joint.
    """
    joints = checked_count("joints", joints, 0)
    drives = (
        [drive] * joints
        if isinstance(drive, Drive)
        else list(drive)
        if isinstance(drive, Sequence)
        else []
    )
    if len(drives) != joints or not all(isinstance(one, Drive) for one in drives):
        raise InvalidValue(
            "drive", drive, f"a Drive, or one for each of the {joints} actuated joints"
        )
    return np.array(
        [[one.reflected_inertia, one.viscous_friction, one.coulomb_friction] for one in drives]
    ).reshape(joints, 3)
