"""Rates of joint coordinates as a function of joint speeds, which may differ."""

from __future__ import annotations

from typing import Any

import numpy as np
import pinocchio as pin

from psp3.checks import Array


class RatesOfConfiguration:
    r"""The rates of a tree's configuration in Pinocchio's coordinates.

    For a quaternion :math:`h` they are :math:`\tfrac12 h \circ \omega` with the angular velocity in
    the body's axes. For the position of a floating base they are its velocity rotated into the axes
    of the parent. For an angle given as cosine and sine they are the speed times the perpendicular
    vector. All others are the speeds.

    Parameters
    ----------
    model : pinocchio.Model
        The tree.
    """

    def __init__(self, model: pin.Model) -> None:
        self._model = model
        self._others: list[Any] = []
        places: list[tuple[int, int]] = []
        for joint in list(model.joints)[1:]:
            if joint.nq == joint.nv:
                places += zip(
                    range(joint.idx_q, joint.idx_q + joint.nq),
                    range(joint.idx_v, joint.idx_v + joint.nv),
                    strict=True,
                )
            else:
                self._others.append(joint)
        self._q, self._v = np.array(places, dtype=np.int64).reshape(-1, 2).T

    def __call__(self, q: Array, v: Array) -> Array:
        """Return the rates (nq,) of a configuration (nq,) at velocities (nv,)."""
        rates = np.zeros(self._model.nq)
        rates[self._q] = v[self._v]
        for joint in self._others:
            at, speeds = joint.idx_q, v[joint.idx_v : joint.idx_v + joint.nv]
            if joint.nq == 7:
                rates[at : at + 3] = pin.Quaternion(q[at + 3 : at + 7]).matrix() @ speeds[:3]
                rates[at + 3 : at + 7] = _turning(q[at + 3 : at + 7], speeds[3:])
            elif joint.nq == 4 and "Planar" in joint.shortname():
                c, s = q[at + 2 : at + 4]
                rates[at : at + 2] = c * speeds[0] - s * speeds[1], s * speeds[0] + c * speeds[1]
                rates[at + 2 : at + 4] = -s * speeds[2], c * speeds[2]
            elif joint.nq == 4:
                rates[at : at + 4] = _turning(q[at : at + 4], speeds)
            else:
                rates[at : at + 2] = -q[at + 1] * speeds[0], q[at] * speeds[0]
        return rates

    def normalized(self, q: Array) -> Array:
        """Return the configuration with quaternions, cosines and sines of unit length."""
        return np.asarray(pin.normalize(self._model, q)) if self._others else q


def _turning(quaternion: Array, velocity: Array) -> Array:
    """Return the rate of a quaternion (x, y, z, w) at an angular velocity in body axes."""
    turned = pin.Quaternion(quaternion) * pin.Quaternion(0.0, *velocity)
    return 0.5 * np.asarray(turned.coeffs())
