"""Control law partitioning of chapter 4, term by term."""

from __future__ import annotations

import numpy as np
import pytest

from psp3.thesis.chapter_4 import Desired, PartitionedControl
from psp3.thesis.chapter_4_systems import MassSpringDamper


@pytest.mark.parametrize("seed", range(5))
def test_the_partitioned_system_is_a_unit_mass(seed: int) -> None:
    """Eq. 4.10 to 4.13, 4.16 and 4.17, with coefficients and states at random; 1e-12.

    The force is m f' + b x' + k x (4.10 with 4.12), the mass accelerates by f' (4.11, 4.13), and
    with it the error by -kv e' - kp e (4.17).
    """
    rng = np.random.default_rng(seed)
    mass, damping, stiffness, kp, kv = rng.uniform(0.5, 3.0, 5)
    x, speed, x_d, speed_d, acceleration_d = rng.normal(size=5)
    system = MassSpringDamper(mass, damping, stiffness).system()
    control = PartitionedControl.of(system, kp, kv)
    desired = Desired(x_d, speed_d, acceleration_d)
    servo = acceleration_d + kv * (speed_d - speed) + kp * (x_d - x)
    assert control.servo(desired, x, speed) == pytest.approx(servo, rel=1e-12)
    force = control.force(desired, x, speed)
    assert force == pytest.approx(mass * servo + damping * speed + stiffness * x, rel=1e-12)
    acceleration = system.acceleration(x, speed, force)
    assert acceleration == pytest.approx(servo, rel=1e-12, abs=1e-12)
    assert acceleration_d - acceleration == pytest.approx(
        -kv * (speed_d - speed) - kp * (x_d - x), rel=1e-12, abs=1e-12
    )
