"""A pose of a robot with closed loops, and the effect of its actuated joints on the others."""

from __future__ import annotations

import functools
from collections.abc import Callable

from psp3.checks import Array


class ClosedPose:
    """A closed configuration: ``configuration`` q (nq,) and ``complement`` L (nv, n) of eq. 3.17.

    Parameters
    ----------
    configuration : (nq,) ndarray
        Joint positions that close the loops.
    complement : (nv, n) ndarray
        All joint velocities per unit of actuated speed.
    dependent_inverse : callable
        Returns :attr:`dependent_inverse` at a configuration.
    """

    def __init__(
        self,
        configuration: Array,
        complement: Array,
        dependent_inverse: Callable[[Array], Array],
    ) -> None:
        self.configuration, self.complement = configuration, complement
        self._solver = dependent_inverse

    @functools.cached_property
    def dependent_inverse(self) -> Array:
        """The (pseudo-)inverse of the un-actuated columns of the constraint Jacobian, (nv − n, m).

        It solves the closure equations for the un-actuated joints, see
        :func:`psp3.closure.rank.dependent_solver`; it is computed at the first access.
        """
        return self._solver(self.configuration)
