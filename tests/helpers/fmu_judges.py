"""Another's simulator, which flies a unit by FMI 2.0, as a package of Python has it."""

import ctypes
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Final

import pytest

from helpers.fmu import Unit

TBB_LIBRARY: Final = "libtbb.so.12"  # that ecospy wants; Debian's libtbb12, or the package tbb
PLAIN_TYPES: Final = {"Real": float, "Integer": int, "Boolean": bool}


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
