"""FMUs in FMPy, as plants and controllers of ``psp3.simulate``; those of both versions alike."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

PERIOD = 0.002
VERSIONS = ("2.0", "3.0")


class _Two:
    """An FMU of FMI 2.0, with the words of both versions."""

    def __init__(self, **options: Any) -> None:
        from fmpy.fmi2 import FMU2Slave

        self.fmu = FMU2Slave(**options)
        self.get, self.set = self.fmu.getReal, self.fmu.setReal
        self.none_of = self.fmu.getInteger
        self.save, self.restore = self.fmu.getFMUstate, self.fmu.setFMUstate
        self.pack, self.unpack = self.fmu.serializeFMUstate, self.fmu.deSerializeFMUstate
        self.forget = self.fmu.freeFMUstate

    def enter(self, time: float) -> None:
        """Begin the initialization."""
        self.fmu.setupExperiment(startTime=time)
        self.fmu.enterInitializationMode()


class _Three:
    """An FMU of FMI 3.0, with the words of both versions."""

    def __init__(self, **options: Any) -> None:
        from fmpy.fmi3 import FMU3Slave

        self.fmu = FMU3Slave(**options)
        self.get, self.set = self.fmu.getFloat64, self.fmu.setFloat64
        self.none_of = self.fmu.getInt32
        self.save, self.restore = self.fmu.getFMUState, self.fmu.setFMUState
        self.pack, self.unpack = self.fmu.serializeFMUState, self.fmu.deserializeFMUState
        self.forget = self.fmu.freeFMUState

    def enter(self, time: float) -> None:
        """Begin the initialization."""
        self.fmu.enterInitializationMode(startTime=time)


class Instance:
    """An FMU in FMPy; variables are got and set by their names."""

    def __init__(self, path: Path, folder: Path) -> None:
        fmpy = pytest.importorskip("fmpy", reason="FMPy is not installed")
        self.description = fmpy.read_model_description(str(path))
        kind: Callable[..., Any] = _Two if self.description.fmiVersion == "2.0" else _Three
        fmi = kind(
            guid=self.description.guid,
            unzipDirectory=fmpy.extract(str(path), str(folder / f"{path.stem}_unzipped")),
            modelIdentifier=self.description.coSimulation.modelIdentifier,
            instanceName=path.stem,
        )
        self.fmi, self.get, self.set = fmi, fmi.get, fmi.set
        self.step, self.finish, self.free = (
            fmi.fmu.doStep,
            fmi.fmu.exitInitializationMode,
            fmi.fmu.freeInstance,
        )
        fmi.fmu.instantiate()
        self.places = {v.name: v.valueReference for v in self.description.modelVariables}

    def of(self, *beginnings: str) -> list[int]:
        """Return value references of variables by what their names begin with."""
        return [
            place
            for beginning in beginnings
            for name, place in self.places.items()
            if name.startswith(f"{beginning}_")
        ]

    def enter(self, settings: dict[str, Any], time: float = 0.0) -> None:
        """Begin to initialize with settings: numbers for each beginning of names."""
        self.fmi.fmu.reset()
        for beginning, numbers in settings.items():
            self.set(self.of(beginning), list(numbers))
        self.fmi.enter(time)

    def begin(self, settings: dict[str, Any], time: float = 0.0) -> None:
        """Initialize with settings."""
        self.enter(settings, time)
        self.finish()


class Plant(Instance):
    """A plant of ``psp3.simulate``."""

    settings: dict[str, Any] | None = None

    def start(self, positions: Any, speeds: Any) -> None:
        """Begin with positions and speeds."""
        self.begin({"start_position": positions, "start_speed": speeds, **(self.settings or {})})
        self.steps = 0

    def advance(self, forces: Any, duration: float) -> tuple[Any, Any]:
        """Return positions and speeds after a step."""
        self.set(self.of("force"), list(forces))
        self.step(self.steps * duration, duration)
        self.steps += 1
        return self.state()

    def state(self) -> tuple[Any, Any]:
        """Return positions and speeds."""
        return np.array(self.get(self.of("position"))), np.array(self.get(self.of("speed")))


class Control(Instance):
    """A controller of ``psp3.simulate``."""

    is_new = True

    def reset(self) -> None:
        """Begin anew in the next step."""
        self.is_new = True

    def give(self, positions: Any, speeds: Any, desired: Any) -> None:
        """Hand over what the controller is to know."""
        names = ("position", "speed", "desired_position", "desired_speed", "desired_acceleration")
        numbers = (positions, speeds, *desired[:3])
        for name, values in zip(names, numbers, strict=True):
            self.set(self.of(name), list(values))

    def torque(self, t: float, positions: Any, speeds: Any, desired: Any) -> Any:
        """Return the forces of a step."""
        if self.is_new:
            self.is_new = False
            self.begin({}, t)
        self.give(positions, speeds, desired)
        self.step(t, PERIOD)
        return self.forces()

    def forces(self) -> Any:
        """Return the forces that are there."""
        names = [name for name in self.places if name.startswith("force_")]
        ends = tuple(f"force_{end}_" for end in ("low", "high", "mean", "deviation"))
        motors = [name for name in names if not name.startswith(ends)]
        return np.array(self.get([self.places[name] for name in motors]))
