r"""Systems whose rules ask how near clouds of data are, the AnYa of Angelov and Yager.

IEEE Std 1855-2016 has them as a rule base of its own: instead of a membership function a rule has a
cloud, data of one input, and fires by how dense they are about the input, relative to the other
rules.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from fuzzy2.errors import InvalidValue, ReadOnly
from fuzzy2.support.checks import Array, reals
from fuzzy2.systems.named_inputs import by_name, like_inputs
from fuzzy2.systems.system import FuzzySystem


class AnYaSystem:
    r"""System of rules whose antecedents are clouds of data.

    The density of the cloud :math:`d_1, \dots, d_m` about its input x, and the firing of antecedent
    i, which asks for cloud c(i), are

    .. math::

        \gamma = \frac{m}{m + \sum_k |d_k - x|}, \qquad
        \lambda_i = \frac{\gamma_{c(i)}}{\sum_j \gamma_{c(j)}}

    Parameters
    ----------
    clouds : sequence of sequence of float
        Data of each input, at least one.
    asked : sequence of R int
        For each antecedent the number of its cloud.
    consequents : FuzzySystem
        What becomes of the R firings, which are its inputs: one term each, whose grade is the
        firing itself, ``Trapezoidal(0.0, 1.0, inf, inf)``, and rules that ask for it or, as
        *else*, for its complement.
    input_names : sequence of str, optional
        Names of the inputs; ``"x1"``, ``"x2"``, … by default.

    Raises
    ------
    InvalidValue
        If a cloud is empty or not finite, or the numbers do not go together.

    References
    ----------
    P. Angelov and R. Yager, *Simplified fuzzy rule-based systems using non-parametric antecedents
    and relative data density*, IEEE Workshop on Evolving and Adaptive Intelligent Systems, 2011.
    """

    def __init__(
        self,
        clouds: Sequence[ArrayLike],
        asked: Sequence[int],
        consequents: FuzzySystem,
        input_names: Sequence[str] | None = None,
    ) -> None:
        self.clouds = tuple(np.array(reals("clouds", cloud)) for cloud in clouds)
        for cloud in self.clouds:
            if cloud.ndim != 1 or not cloud.size or not np.isfinite(cloud).all():
                raise InvalidValue("clouds", cloud, "finite numbers, at least one in each cloud")
            cloud.flags.writeable = False
        self.asked = tuple(int(one) for one in asked)
        if not all(0 <= one < len(self.clouds) for one in self.asked):
            raise InvalidValue("asked", asked, f"numbers of the {len(self.clouds)} clouds")
        if not isinstance(consequents, FuzzySystem) or len(consequents.inputs) != len(self.asked):
            raise InvalidValue(
                "consequents", consequents, f"a system of {len(self.asked)} inputs, the firings"
            )
        self.consequents = consequents
        self._named = input_names is not None
        self.input_names = tuple(input_names or (f"x{i + 1}" for i in range(len(self.clouds))))
        if len(set(self.input_names)) != len(self.clouds):
            raise InvalidValue(
                "input_names", input_names, f"{len(self.clouds)} names, each of another input"
            )

    def __setattr__(self, name: str, value: Any) -> None:
        if name in self.__dict__:
            raise ReadOnly("an AnYaSystem", name)
        object.__setattr__(self, name, value)

    @property
    def output_names(self) -> tuple[str, ...]:
        """Names of the outputs."""
        return tuple(self.consequents.output_names)

    def __repr__(self) -> str:
        return f"AnYaSystem({len(self.clouds)} clouds, {self.consequents!r})"

    def relative_densities(self, X: Any) -> Array:
        """Return the firing of the antecedents, which adds up to 1.

        Parameters
        ----------
        X : (..., p) array_like, mapping or data frame
            Inputs, one of each cloud.

        Returns
        -------
        (..., R) ndarray
            Relative densities.

        Raises
        ------
        InvalidValue
            If the inputs are not finite or of another shape.
        """
        x = reals("X", by_name(X, self.input_names, self._named))
        if x.shape[-1:] != (len(self.clouds),):
            raise InvalidValue("X", x.shape, f"of shape (..., {len(self.clouds)})")
        if not np.isfinite(x).all():
            raise InvalidValue("X", x, "finite")
        densities = np.empty(x.shape)
        for i, cloud in enumerate(self.clouds):
            distance = np.abs(x[..., i, np.newaxis] - cloud).mean(axis=-1)
            densities[..., i] = 1.0 / (1.0 + distance)
        chosen = densities[..., list(self.asked)]
        relative: Array = chosen / chosen.sum(axis=-1, keepdims=True)
        return relative

    def __call__(self, X: Any = None, /, **named: ArrayLike) -> Array:
        """Return the crisp outputs (..., m) of inputs (..., p), or of inputs by name.

        Parameters
        ----------
        X : (..., p) array_like, mapping or data frame
            Inputs.
        **named
            The same as keywords.

        Returns
        -------
        (..., m) ndarray
            Outputs. Of a DataFrame or Series of pandas the like, see :class:`fuzzy2.FuzzySystem`.

        Raises
        ------
        InvalidValue
            If the inputs are not finite or of another shape.
        """
        if named and X is not None:
            raise InvalidValue("X", X, "left out where inputs are given by name")
        given = named if X is None and named else X
        crisp = self.consequents(self.relative_densities(given))
        outputs: Array = like_inputs(crisp, given, self.output_names)
        return outputs
