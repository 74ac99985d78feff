"""Options that the commands ``psp3 export ...`` share: what to write, and its robot."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from psp3.cli.options import Numbers, file_path, numbers, one_or_each, option_of, usage_error
from psp3.cli.robot_options import (
    ROBOT,
    ActuatedOption,
    FreeOption,
    ParametersOption,
    RobotOptions,
)

if TYPE_CHECKING:
    from psp3.drives.drive import Drive
    from psp3.robots.closed_loop_robot import ClosedLoopRobot
    from psp3.robots.robot import Robot

DRIVES = "Drives of a robot: one number for all motors, or one each"
ROBOT_OR_CONTROLLER = (
    "A robot of the package (psp3 info lists them); or a file: of a robot (.urdf, .xml or .sdf), "
    "of a controller that psp3 train wrote (.json)"
)


@dataclass(frozen=True, kw_only=True)
class ThingOptions:
    """What is written: a robot, or a controller or fuzzy system and its robot."""

    thing: Annotated[
        str,
        typer.Argument(metavar="THING", help=f"{ROBOT_OR_CONTROLLER}.", show_default=False),
    ]
    robot: Annotated[
        str | None,
        typer.Argument(
            metavar="ROBOT",
            help="The robot of a controller that is read from a file.",
            show_default=False,
        ),
    ] = None
    loops: Annotated[
        Path | None,
        typer.Option(
            parser=file_path,
            metavar="FILE",
            rich_help_panel=ROBOT,
            help="Loop file (.yaml) of a URDF; default the file of the same name beside it.",
        ),
    ] = None
    actuated: ActuatedOption = None
    free: FreeOption = None
    parameters: ParametersOption = None

    def open(self) -> tuple[Any, ClosedLoopRobot | None]:
        """Return what to write and, unless that is a robot, its robot if there is one.

        Raises
        ------
        typer.BadParameter
            If an option is given that does not apply.
        """
        from psp3.export.project import is_robot, opened

        if is_robot(self.thing):
            if self.robot is not None:
                raise usage_error(
                    f"ROBOT is for controllers, but {self.thing} is a robot: leave out "
                    f"{self.robot}, or give a loop file as --loops"
                )
            return self._robot(self.thing), None
        if self.robot is not None:
            robot = self._robot(self.robot)
            thing = opened(self.thing, robot)
            if not hasattr(thing, "torque"):
                raise usage_error(f"ROBOT is for controllers, but {self.thing} is not a controller")
            return thing, robot
        for name, value in self._of_the_robot().items():
            if value is not None:
                raise usage_error(
                    f"{option_of(name)} is an option of a robot: give the robot of {self.thing} "
                    "as ROBOT"
                )
        return opened(self.thing), None

    def _of_the_robot(self) -> dict[str, Any]:
        names = ("loops", "actuated", "free", "parameters")
        return {name: getattr(self, name) for name in names}

    def _robot(self, name: str) -> ClosedLoopRobot:
        return RobotOptions(robot=name, **self._of_the_robot()).load()


@dataclass(frozen=True, kw_only=True)
class DriveOptions:
    """Friction and motor inertia of a robot's motors."""

    coulomb_friction: Annotated[
        Numbers | None,
        typer.Option(
            parser=numbers, metavar="N", rich_help_panel=DRIVES, help="Dry friction (N, N m)."
        ),
    ] = None
    viscous_friction: Annotated[
        Numbers | None,
        typer.Option(
            parser=numbers,
            metavar="N*S/M",
            rich_help_panel=DRIVES,
            help="Viscous friction (N s/m, N m s/rad).",
        ),
    ] = None
    motor_inertia: Annotated[
        Numbers | None,
        typer.Option(
            parser=numbers,
            metavar="KG*M2",
            rich_help_panel=DRIVES,
            help="Inertia of the parts that turn with the motor (kg m²); needs --lead.",
        ),
    ] = None
    lead: Annotated[
        Numbers | None,
        typer.Option(
            parser=numbers,
            metavar="M",
            rich_help_panel=DRIVES,
            help="Travel of the joint in one turn of its motor (m, rad).",
        ),
    ] = None

    def drives(self, robot: Robot) -> list[Drive]:
        """Return a drive for each motor of a robot."""
        from psp3.drives.drive import Drive

        given = {
            name: one_or_each(option_of(name), value, robot.actuated)
            for name, value in vars(self).items()
            if value is not None
        }
        return [
            Drive(**{name: values[i] for name, values in given.items()})
            for i in range(len(robot.actuated))
        ]
