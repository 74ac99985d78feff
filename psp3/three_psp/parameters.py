r"""Physical parameters of the 3-PSP robot.

They are those of the thesis's Table 3.1, with its different readings.

Three sets have names. They differ only in the inertia of the star and in gravity:

=============  ===================================  ========  ======================================
name           star inertia about (x, y, own axis)  g [m/s²]  what it is
=============  ===================================  ========  ======================================
``default``    0.06451, 0.06451, 0.12901            9.81      Table 3.1, star inertia divided by ten
``table_3_1``  0.6451, 0.6451, 1.2901               9.81      Table 3.1, moments as printed
``table_5_1``  0.06451, 0.12901, 0.06451            9.806     fitted to M and G of Table 5.1
=============  ===================================  ========  ======================================

The star inertia printed in Table 3.1 does not give the thesis's own Table 5.1; divided by ten it
does, provided that the large moment lies in the star's plane, perpendicular to arm 1. A star with
three equal arms cannot have that inertia, so ``default`` puts the large moment about the star's own
axis.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass, fields

import numpy as np
from numpy.typing import NDArray

from psp3.checks import as_floats
from psp3.errors import InvalidArray, InvalidValue, UnknownName


@dataclass(frozen=True)
class Parameters:
    r"""Geometry, masses, moments of inertia and gravity of a 3-PSP robot.

    See the thesis's Table 3.1. Units are SI.

    Parameters
    ----------
    screw_radius : float
        Distance :math:`d` from the center of the base to each screw [m].
    tool_length : float
        Length :math:`h` of the tool, from the star's center to the tip [m].
    nut_mass : float
        Mass of each nut, :math:`m_1 = m_2 = m_3` [kg].
    nut_inertia : (3,) tuple of float
        Moments of inertia of a nut [kg m²]. The printed ones violate the triangle inequality. A nut
        never rotates, so they do not enter the equation of motion.
    ball_mass : float
        Mass of each of the three bodies of a ball joint, :math:`m_4 = \dots = m_{12}` [kg].
    ball_axial_inertia, ball_transverse_inertia : float
        Moment of inertia of such a body about its own joint axis and about the two others [kg m²].
    star_mass : float
        Mass of the star, :math:`m_{13}` [kg].
    star_inertia : (3,) tuple of float
        Principal moments of the star about its center, along x (arm 1 at home), y and the star's
        own axis [kg m²].
    gravity : float
        Acceleration of free fall :math:`g`, along −z of the base [m/s²].

    Raises
    ------
    InvalidValue
        If a length or a mass is not positive, or a moment of inertia or gravity is negative or not
        finite.
    """

    screw_radius: float = 0.181
    tool_length: float = 0.070
    nut_mass: float = 7.175
    nut_inertia: tuple[float, float, float] = (0.003, 0.39, 0.3294)
    ball_mass: float = 0.357
    ball_axial_inertia: float = 0.1117e-3
    ball_transverse_inertia: float = 0.094e-3
    star_mass: float = 1.758
    star_inertia: tuple[float, float, float] = (0.06451, 0.06451, 0.12901)
    gravity: float = 9.81

    def __post_init__(self) -> None:
        positive = {"screw_radius", "tool_length", "nut_mass", "ball_mass", "star_mass"}
        for field in fields(self):
            value = getattr(self, field.name)
            shape = (3,) if field.name.endswith(("nut_inertia", "star_inertia")) else ()
            strict = field.name in positive
            requirement = (
                f"{'three numbers' if shape else 'a number'}, finite and "
                f"{'positive' if strict else 'not negative'}"
            )
            try:
                values = as_floats(field.name, value, str(shape)).reshape(np.shape(value))
            except InvalidArray as error:
                raise InvalidValue(field.name, value, requirement) from error
            if (
                values.shape != shape
                or not np.isfinite(values).all()
                or (values < 0).any()
                or (strict and (values == 0).any())
            ):
                raise InvalidValue(field.name, value, requirement)
            object.__setattr__(self, field.name, tuple(values.tolist()) if shape else float(values))

    @property
    def total_mass(self) -> float:
        """Mass of all moving bodies, 26.496 kg for Table 3.1 [kg]."""
        return 3.0 * (self.nut_mass + 3.0 * self.ball_mass) + self.star_mass

    def as_array(self) -> NDArray[np.float64]:
        r"""Return the numbers that the compiled closed form needs, as one array.

        Returns
        -------
        (10,) ndarray
            :math:`d`, :math:`h`, the mass that slides on one screw, the star's mass, its three
            moments plus those of the ball bodies that rotate with it, the sum of the moments for
            :math:`\dot\varphi_k` and :math:`\dot\theta_k`, the moment for :math:`\dot\theta_k`
            alone, and :math:`g`.
        """
        axial, transverse = self.ball_axial_inertia, self.ball_transverse_inertia
        ix, iy, iz = self.star_inertia
        return np.array(
            [
                self.screw_radius,
                self.tool_length,
                self.nut_mass + 3.0 * self.ball_mass,
                self.star_mass,
                # The third body of every ball joint rotates with the star.
                ix + 3.0 * transverse,
                iy + 3.0 * transverse,
                iz + 3.0 * axial,
                # The phi body rotates by phi only; the theta body by phi (across its axis) and by
                # theta (about it).
                axial + transverse,
                axial,
                self.gravity,
            ]
        )

    def as_dict(self) -> dict[str, float | tuple[float, float, float]]:
        """Return the parameters by name, ready for JSON."""
        return asdict(self)


PARAMETER_SETS: dict[str, Parameters] = {
    "default": Parameters(),
    "table_3_1": Parameters(star_inertia=(0.6451, 0.6451, 1.2901)),
    "table_5_1": Parameters(star_inertia=(0.06451, 0.12901, 0.06451), gravity=9.806),
}


def named_parameters(parameters: str | Parameters) -> Parameters:
    """Return the parameter set with a name.

    An instance of :class:`Parameters` is returned as it is.

    Raises
    ------
    UnknownName
        If there is no set of that name; the error lists the known ones.
    """
    if isinstance(parameters, Parameters):
        return parameters
    if not isinstance(parameters, str) or parameters not in PARAMETER_SETS:
        raise UnknownName("parameter set", parameters, list(PARAMETER_SETS))
    return PARAMETER_SETS[parameters]
