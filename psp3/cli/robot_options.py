"""The options that choose a command's robot: one of the package, or a file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, cast

import typer

from psp3.cli.options import ParametersName, file_path, option_of, usage_error

if TYPE_CHECKING:
    from psp3.robots.closed_loop_robot import ClosedLoopRobot
    from psp3.three_psp.robot import PSP3

ROBOT = "Robot"
THESIS_ROBOT = "psp3"


ParametersOption = Annotated[
    ParametersName | None,
    typer.Option(
        metavar="NAME",
        rich_help_panel=ROBOT,
        help=(
            "Parameter set of the 3-PSP: default (used if none is given), table_3_1 or table_5_1; "
            "see psp3 info."
        ),
    ),
]


class Free(StrEnum):
    """Treatment of motions that no motor commands."""

    LOCK = "lock"
    KEEP = "keep"
    REFUSE = "refuse"


ActuatedOption = Annotated[
    str | None,
    typer.Option(
        metavar="NAME,NAME",
        rich_help_panel=ROBOT,
        help="Motors of a robot from a file; default those that the file names.",
    ),
]
FreeOption = Annotated[
    Free | None,
    typer.Option(
        metavar="NAME",
        rich_help_panel=ROBOT,
        help=(
            "Motions that no motor commands: lock (default) holds them, keep makes them "
            "coordinates, refuse refuses the robot."
        ),
    ),
]


@dataclass(frozen=True, kw_only=True)
class RobotOptions:
    """The robot of a command; by default the 3-PSP of the thesis."""

    robot: Annotated[
        str,
        typer.Argument(
            metavar="ROBOT",
            help=(
                "A robot of the package (psp3 info lists them) or a file: .urdf, .xml (MJCF) or "
                ".sdf; default the 3-PSP."
            ),
            show_default=False,
        ),
    ] = THESIS_ROBOT
    loops: Annotated[
        Path | None,
        typer.Argument(
            parser=file_path,
            metavar="LOOPS",
            help="Loop file (.yaml) of a URDF.",
            show_default=False,
        ),
    ] = None
    actuated: ActuatedOption = None
    free: FreeOption = None
    parameters: ParametersOption = None

    @property
    def is_of_thesis(self) -> bool:
        """Whether the robot is the 3-PSP, which has motions and numbers of its own."""
        return self.robot == THESIS_ROBOT

    @property
    def parameter_set(self) -> str:
        """Name of the parameter set of the 3-PSP."""
        return (self.parameters or ParametersName.DEFAULT).value

    def load(self) -> ClosedLoopRobot:
        """Return the robot.

        Raises
        ------
        typer.BadParameter
            If an option is given that this robot does not have.
        """
        from psp3.loading import load

        given: dict[str, Any] = {}
        if self.loops is not None:
            given["loops"] = self.loops
        if self.actuated is not None:
            given["actuated"] = tuple(name.strip() for name in self.actuated.split(","))
        if self.free is not None:
            given["free"] = self.free.value
        if self.is_of_thesis:
            for name in given:
                called = "LOOPS" if name == "loops" else option_of(name)
                raise usage_error(f"{called} does not apply to the 3-PSP, whose motors are known")
            return load(THESIS_ROBOT, parameters=self.parameter_set)
        self.refuse({"parameters": self.parameters})
        return load(self.robot, **given)

    def identity(self, robot: ClosedLoopRobot) -> dict[str, str]:
        """Return what identifies the robot in JSON: its parameter set, or its name."""
        if self.is_of_thesis:
            return {"parameters": self.parameter_set}
        return {"robot": robot.title}

    def load_of_thesis(self) -> PSP3:
        """Return the 3-PSP, for a command that has checked :attr:`is_of_thesis`."""
        return cast("PSP3", self.load())

    def refuse(self, options: Mapping[str, Any], instead: str = "") -> None:
        """Refuse options that only the 3-PSP has if another robot is named.

        Raises
        ------
        typer.BadParameter
            If one of the options is not None.
        """
        for name, value in options.items():
            if value is not None:
                raise usage_error(
                    f"{option_of(name)} is an option of the 3-PSP and does not apply to "
                    f"{self.robot}{instead}"
                )
