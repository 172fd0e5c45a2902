"""Other people's simulators, which fly a unit by FMI 2.0: as packages of Python have them."""

import ctypes
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Final, Protocol

import pytest

from helpers.fmu import Unit

NANOSECONDS: Final = 10**9  # in a second
TBB_LIBRARY: Final = "libtbb.so.12"  # that ecospy wants; Debian's libtbb12, or the package tbb
PLAIN_TYPES: Final = {"Real": float, "Integer": int, "Boolean": bool}


class Judge(Protocol):
    """A simulator with one boat."""

    def set(self, name: str, value: float) -> None:
        """Set an input from the next step on."""

    def fly_step(self) -> None:
        """Fly one step."""

    def numbers(self, names: Sequence[str]) -> list[float]:
        """Return real variables."""


class CosimJudge:
    """The Open Simulation Platform's libcosim, which sets an input at each step from then on."""

    def __init__(self, file: Path, unit: Unit, step: float, start: Mapping[str, int]) -> None:
        """Load a unit, and set whole numbers before it begins."""
        execution: Any = pytest.importorskip("libcosimpy.CosimExecution")
        slave: Any = pytest.importorskip("libcosimpy.CosimSlave")
        manipulator: Any = pytest.importorskip("libcosimpy.CosimManipulator")
        observer: Any = pytest.importorskip("libcosimpy.CosimObserver")
        log: Any = pytest.importorskip("libcosimpy.CosimLogging")
        log.log_output_level(log.CosimLogLevel.FATAL)
        self.variables = unit.variables
        self.execution = execution.CosimExecution.from_step_size(step * NANOSECONDS)
        self.boat = self.execution.add_local_slave(slave.CosimLocalSlave(str(file), "boat"))
        for name, value in start.items():
            place = self.variables[name].reference
            assert self.execution.integer_initial_value(self.boat, place, value)
        self.observer = observer.CosimObserver.create_last_value()
        self.inputs = manipulator.CosimManipulator.create_override()
        assert self.execution.add_observer(self.observer)
        assert self.execution.add_manipulator(self.inputs)

    def set(self, name: str, value: float) -> None:
        """Set an input from the next step on."""
        reference, kind, *_ = self.variables[name]
        write = getattr(self.inputs, f"slave_{kind.lower()}_values")
        assert write(self.boat, [reference], [PLAIN_TYPES[kind](value)])

    def fly_step(self) -> None:
        """Fly one step."""
        assert self.execution.step(1)

    def numbers(self, names: Sequence[str]) -> list[float]:
        """Return real variables."""
        places = [self.variables[name].reference for name in names]
        return list(self.observer.last_real_values(self.boat, places))


class EcosJudge:
    """Ecos, which sets an input once."""

    def __init__(self, file: Path, unit: Unit, step: float, start: Mapping[str, int]) -> None:
        """Load a unit, and set whole numbers before it begins."""
        for library in Path(sys.prefix, "lib").glob(TBB_LIBRARY):
            ctypes.CDLL(str(library), ctypes.RTLD_GLOBAL)
        try:
            ecos: Any = pytest.importorskip("ecospy")
        except OSError as lacking:
            pytest.skip(f"ecospy: {lacking}: apt install libtbb12, or pip install tbb")
        self.variables = unit.variables
        structure = ecos.EcosSimulationStructure()
        structure.add_model("boat", str(file))
        structure.add_parameter_set("start", {f"boat::{name}": x for name, x in start.items()})
        self.simulation = ecos.EcosSimulation(structure=structure, step_size=step)
        self.simulation.init(parameter_set="start")

    def set(self, name: str, value: float) -> None:
        """Set an input from the next step on."""
        kind = self.variables[name].kind
        write = getattr(self.simulation, f"set_{'bool' if kind == 'Boolean' else kind.lower()}")
        write(f"boat::{name}", PLAIN_TYPES[kind](value))

    def fly_step(self) -> None:
        """Fly one step."""
        self.simulation.step(1)

    def numbers(self, names: Sequence[str]) -> list[float]:
        """Return real variables."""
        return [self.simulation.get_real(f"boat::{name}") for name in names]
