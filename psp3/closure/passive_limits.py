"""Limits of the joints that no motor drives."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from psp3.checks import Array
from psp3.errors import JointLimitExceeded


class PassiveLimits:
    """Limits of the joints that are not actuated.

    Trajectories and the simulation check the limits of the motors.

    Parameters
    ----------
    model : pinocchio.Model
        The tree.
    actuated : tuple of str
        Names of the actuated joints.
    """

    def __init__(self, model: pin.Model, actuated: tuple[str, ...]) -> None:
        # The universe is skipped: Pinocchio's placeholder for it claims the last coordinate of q.
        passive = [
            (str(name), joint.idx_q)
            for name, joint in zip(list(model.names)[1:], list(model.joints)[1:], strict=True)
            if joint.nq == 1 and name not in actuated
        ]
        self._names = [name for name, _ in passive]
        self._index = np.array([index for _, index in passive], dtype=np.int64)
        self._lower, self._upper = (
            model.lowerPositionLimit[self._index],
            model.upperPositionLimit[self._index],
        )

    def check(self, configurations: Array) -> None:
        """Raise :class:`JointLimitExceeded` for the first configuration (N, nq) beyond a limit."""
        values = configurations[:, self._index]
        # Written so that NaN counts as beyond.
        beyond = ~((self._lower <= values) & (values <= self._upper))
        if beyond.any():
            row, k = np.argwhere(beyond)[0]
            raise JointLimitExceeded(
                self._names[k], float(values[row, k]), float(self._lower[k]), float(self._upper[k])
            )
