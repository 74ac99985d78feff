"""Finishes for the 3D view, and shapes that MeshCat does not have.

All modules that draw import MeshCat from here.
"""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from psp3.checks import Array

with warnings.catch_warnings():
    # MeshCat 0.3.2 imports a module of pyzmq that is deprecated.
    warnings.simplefilter("ignore", DeprecationWarning)
    import meshcat
    from meshcat import geometry

__all__ = [
    "Column",
    "Flat",
    "Glass",
    "Satin",
    "Tube",
    "geometry",
    "meshcat",
    "meshcat_script",
    "rgb",
]

_ALONG_Z = np.array(
    [[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, -1.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]]
)
"""Rotation that takes the axis of a three.js cylinder, y, to z."""


class _Finish(geometry.Material):  # type: ignore[misc]
    """A material of three.js by its properties.

    MeshCat's own materials repeat every default, which makes files of many small shapes large.
    """

    kind: str

    def __init__(self, **properties: Any) -> None:
        super().__init__()
        self.properties = properties

    def lower(self, object_data: Any) -> dict[str, Any]:
        """Return the data in three.js's format."""
        return {"uuid": self.uuid, "type": self.kind, **self.properties}


class Satin(_Finish):
    """Machined, anodized or painted metal.

    Every part of the robot has this finish, in its own color.
    """

    kind = "MeshPhongMaterial"

    def __init__(self, color: ArrayLike) -> None:
        super().__init__(color=_hexadecimal(color), specular=0x303030, shininess=50)


class Flat(_Finish):
    """A color that does not depend on light, given as ``#rrggbb``."""

    kind = "MeshBasicMaterial"

    def __init__(self, color: str, opacity: float = 1.0) -> None:
        super().__init__(color=_hexadecimal(rgb(color)), opacity=opacity, transparent=opacity < 1.0)


class Glass(_Finish):
    """A translucent color, given as ``#rrggbb``, with shading."""

    kind = "MeshLambertMaterial"

    def __init__(self, color: str, opacity: float) -> None:
        super().__init__(color=_hexadecimal(rgb(color)), opacity=opacity, transparent=True)


class Tube(geometry.Geometry):  # type: ignore[misc]
    """A tube along a path of shape (n, 3)."""

    def __init__(self, path: Array, radius: float) -> None:
        super().__init__()
        self.path, self.radius = path, radius

    def lower(self, object_data: Any) -> dict[str, Any]:
        """Return the data in three.js's format."""
        segments = len(self.path)
        curve = {
            "type": "CatmullRomCurve3",
            "curveType": "centripetal",
            "tension": 0.5,
            "closed": False,
            "arcLengthDivisions": segments,
            "points": self.path.tolist(),
        }
        return {
            "uuid": self.uuid,
            "type": "TubeGeometry",
            "path": curve,
            "tubularSegments": segments,
            "radius": self.radius,
            "radialSegments": 8,
            "closed": False,
        }


class Column(geometry.Cylinder):  # type: ignore[misc]
    """A cylinder or cone on z, from the origin to ``height``."""

    def __init__(
        self, height: float, radius: float, radius_at_the_top: float | None = None
    ) -> None:
        super().__init__(
            height,
            radiusBottom=radius,
            radiusTop=radius if radius_at_the_top is None else radius_at_the_top,
        )
        self.radialSegments = 24

    def intrinsic_transform(self) -> Array:
        """Return the transform from the axes of three.js, transposed.

        MeshCat writes rows where three.js reads columns.
        """
        lifted = _ALONG_Z.copy()
        lifted[2, 3] = 0.5 * self.height
        return lifted.T


def meshcat_script() -> str:
    """Return MeshCat's program for the browser."""
    return (Path(meshcat.__file__).with_name("viewer") / "dist" / "main.min.js").read_text(
        encoding="utf-8"
    )


def rgb(color: str) -> list[float]:
    """Return the three numbers in [0, 1] of ``#rrggbb``."""
    return [int(color[i : i + 2], 16) / 255.0 for i in (1, 3, 5)]


def _hexadecimal(color: ArrayLike) -> int:
    """Return an sRGB color, given by numbers in [0, 1], as three.js wants it.

    In linear light, 0xRRGGBB.
    """
    red, green, blue = (
        int(np.rint(255.0 * value**2.2)) for value in np.asarray(color, dtype=float)[:3]
    )
    return (red << 16) + (green << 8) + blue
