"""Numbers printed in the thesis, for comparison only: nothing is computed from them.

Source: H. R. Hassanzadeh, "A New Type-II Fuzzy Logic Based Controller for Non-linear Dynamical
Systems with Application to a 3-PSP Parallel Robot", Master's thesis, Ferdowsi University of
Mashhad; Tables 5.1, 5.2 and 6.1 to 6.3.
"""

from __future__ import annotations

import math
from types import MappingProxyType

import numpy as np

TABLE_5_1_HEIGHTS = np.array([[0.10, 0.20, 0.05], [0.15, 0.25, 0.15], [0.05, 0.15, 0.05]])
"""Nut heights of the three configurations as printed [m]. The third heights of the last two
contradict Table 5.2, but the printed M and G fit them.
"""

TABLE_5_1_SPEEDS = np.array([[0.15, 0.12, 0.10], [0.25, 0.22, 0.20], [0.25, 0.22, 0.20]])
"""Nut speeds of the three configurations [m/s]."""

TABLE_5_1_MASS = np.array(
    [[10.0161, -0.5288, -0.6026], [-0.5288, 9.2516, 0.0091], [-0.6026, 0.0091, 9.4782]]
)
"""Mass matrix of Table 5.1 [kg]; entry 21 is printed as −0.528."""

TABLE_5_1_CORIOLIS = np.array(
    [[10.0159, 0.0004, -0.0163], [0.0481, -0.0247, -0.0234], [0.0346, 0.0124, -0.0560]]
)
"""Coriolis matrix of Table 5.1 as printed [kg/s]; entry 11 must be 0.0159 and entry 31 0.0436 for
its rows to sum to zero.
"""

TABLE_5_1_GRAVITY = np.array([87.1237, 85.6256, 87.1237])
"""Gravity vector of Table 5.1 [N]."""

TABLE_5_2 = MappingProxyType(
    {"Δq12": -0.10, "Δq̇12": 0.03, "Δq13": 0.05, "Δq̇13": 0.05, "Δq23": 0.15, "Δq̇23": 0.02}
)
"""Differences of Table 5.2, the same for all three configurations [m, m/s]."""

TABLE_6_1 = MappingProxyType(
    {
        "PD": (1000.0, 100.0),
        "CTC": (10.0, 1.0),
        "T1 fuzzy CTC": (10.0, 1.0),
        "T2 fuzzy CTC": (10.0, 1.0),
    }
)
"""Proportional and derivative gains of Table 6.1."""

TABLE_6_1_TERMS = 2
"""Terms of each input of the fuzzy controllers in Table 6.1."""

TABLE_6_1_SNR = (10.0, 15.0, 20.0, math.inf)
"""Signal-to-noise ratios of Table 6.1 [dB]."""

TABLE_6_2 = MappingProxyType(
    {"PD": 0.1e-3, "CTC": 255e-3, "T1 fuzzy CTC": 0.15e-3, "T2 fuzzy CTC": 1.5e-3}
)
"""Time of one step in Table 6.2, on a Pentium 4 of 3 GHz [s]; that of PD is printed as less than
this.
"""

STEP_BUDGET = 2e-3
"""Longest response time that section "Comparisons" of chapter 6 allows a controller [s]."""

TABLE_6_3 = MappingProxyType({"PD": 4.6339, "CTC": 0.0241})
"""Sums of squared errors of the two classical controllers in Table 6.3 [m²]."""

TABLE_6_3_FUZZY = MappingProxyType(
    {
        math.inf: (0.0684, 0.0684),
        20.0: (0.5543, 0.2816),
        15.0: (1.9421, 0.5530),
        10.0: (5.6517, 1.3930),
    }
)
"""Sums of squared errors of the type-1 and the type-2 controller in Table 6.3 [m²], by
signal-to-noise ratio [dB].
"""

THESIS_SAMPLING_PERIOD = 0.05
"""Sampling period at which a sum of squared errors compares with Table 6.3 [s]; the thesis does not
state its own.
"""

DURATION = 10.4
"""Length of the thesis's runs [s], which follows from its PD row: Σ‖e‖² = 4.48 (T − 0.106 s)/10 s
is 4.6339 for this T.
"""
