"""Trace the border of a workspace along the edges of the region with usable poses."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from psp3.checks import Array, finite_rows
from psp3.kinematics.pose_map import KinematicMap, Status

EDGE_ACCURACY = 1e-3
"""Accuracy of a border point on an edge of the grid, as a share of the edge. The error is small
compared with that of straight lines between the points.
"""


class Boundary(NamedTuple):
    """Border of a region of a map.

    ``segments`` (N, 2, 2) are pairs of points on the border, and ``area`` is the area inside, in
    the units of the grid.
    """

    segments: Array
    area: float

    def distance(self, points: ArrayLike) -> Array:
        """Return the distance of points (..., 2) from the border, (...,), in the units of the grid.

        It is infinite if there is no border.

        Raises
        ------
        InvalidArray
            If the points are not finite or of another shape.
        """
        p = finite_rows("points", points, 2)
        start, way = self.segments[:, 0], self.segments[:, 1] - self.segments[:, 0]
        from_start = p[..., np.newaxis, :] - start
        share = np.clip(
            (from_start * way).sum(axis=-1) / np.maximum((way**2).sum(axis=-1), 1e-300), 0.0, 1.0
        )
        gap = from_start - share[..., np.newaxis] * way
        distance: Array = np.hypot(gap[..., 0], gap[..., 1]).min(axis=-1, initial=np.inf)
        return distance


AlongEdge = Callable[[Array, Array, Array], float]
"""Function of a point of the grid, the vector to its neighbor, and the configuration at the point.
It returns the share of the vector along which poses have the status.
"""


class Tracer:
    """Follows the border of a region through the cells of a grid.

    Parameters
    ----------
    poses : KinematicMap
        The map, over two coordinates.
    at_least : Status
        The poses in the region have this status or a better one.
    along : callable
        Follows an edge from a node inside and returns the share of it that is inside, see
        :data:`AlongEdge`.
    """

    def __init__(self, poses: KinematicMap, at_least: Status, along: AlongEdge) -> None:
        self._poses, self._along = poses, along
        self._inside = poses.status >= at_least
        self._crossings: dict[tuple[tuple[int, int], tuple[int, int]], Array] = {}
        self._axes = list(poses.grid.values())

    def trace(self) -> Boundary:
        """Return the border and the area inside."""
        segments, area = [], 0.0
        rows, columns = self._inside.shape
        for i in range(rows - 1):
            for j in range(columns - 1):
                corners = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)]
                inside = [bool(self._inside[corner]) for corner in corners]
                if not any(inside):
                    continue
                outline: list[Array] = []
                crossed: list[tuple[int, bool]] = []
                for k, corner in enumerate(corners):
                    following = corners[(k + 1) % 4]
                    if inside[k]:
                        outline.append(self._at(corner))
                    if inside[k] != inside[(k + 1) % 4]:
                        crossed.append((len(outline), inside[k]))
                        outline.append(
                            self._crossing(
                                *((corner, following) if inside[k] else (following, corner))
                            )
                        )
                x, y = np.array(outline).T
                area += 0.5 * float(x @ np.roll(y, -1) - y @ np.roll(x, -1))
                # Join the point where the outline leaves the region with the point where it
                # returns.
                for number, (place, leaves) in enumerate(crossed):
                    if leaves:
                        back = crossed[(number + 1) % len(crossed)][0]
                        segments.append([outline[place], outline[back]])
        return Boundary(np.array(segments).reshape(-1, 2, 2), area)

    def _at(self, node: tuple[int, int]) -> Array:
        return np.array([self._axes[0][node[0]], self._axes[1][node[1]]])

    def _crossing(self, inner: tuple[int, int], outer: tuple[int, int]) -> Array:
        """Return the point where the edge from a node inside to one outside crosses the border."""
        if (inner, outer) not in self._crossings:
            self._crossings[inner, outer] = self._found(inner, outer)
        return self._crossings[inner, outer]

    def _found(self, inner: tuple[int, int], outer: tuple[int, int]) -> Array:
        start = self._at(inner)
        way = self._at(outer) - start
        return start + self._along(start, way, self._poses.configuration[inner]) * way
