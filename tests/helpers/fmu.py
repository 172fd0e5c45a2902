"""A functional mock-up unit as a simulator has it, by ctypes: co-simulation by FMI 2.0 or 3.0."""

import ctypes
import platform
import shutil
import sys
import xml.etree.ElementTree as ET
import zipfile
from pathlib import Path
from typing import Any, Final, NamedTuple

import pytest

from trainer.boat.platforms import SHIPPED_PLATFORMS, platform_name
from trainer.core.state import STATE

UNIT_MARKS: Final = [  # of tests that link a unit
    pytest.mark.process,
    pytest.mark.skipif(not shutil.which("cc"), reason="no C compiler here"),
    pytest.mark.skipif(
        (sys.platform, platform.machine()) != ("linux", "x86_64"), reason="of Linux on x86-64"
    ),
]
OK, ERROR = 0, 3
CO_SIMULATION = 1
NUMBERS: Final[dict[int, dict[str, Any]]] = {  # of the two versions
    2: {"Real": ctypes.c_double, "Integer": ctypes.c_int, "Boolean": ctypes.c_int},
    3: {"Float64": ctypes.c_double, "Int32": ctypes.c_int, "Boolean": ctypes.c_bool},
}
NAMES_OF_2: Final = {  # of functions, by their names in FMI 3.0
    "GetFMUState": "GetFMUstate",
    "SetFMUState": "SetFMUstate",
    "FreeFMUState": "FreeFMUstate",
    "SerializedFMUStateSize": "SerializedFMUstateSize",
    "SerializeFMUState": "SerializeFMUstate",
    "DeserializeFMUState": "DeSerializeFMUstate",
}
NO, YES, NOTHING = ctypes.c_bool(0), ctypes.c_bool(1), ctypes.c_void_p()
GUID_BYTES = 40  # before the numbers of a serialised state
LOGGER_OF_3 = ctypes.CFUNCTYPE(
    None, ctypes.c_void_p, ctypes.c_int, ctypes.c_char_p, ctypes.c_char_p
)
LOGGER = ctypes.CFUNCTYPE(
    None,
    *(ctypes.c_void_p, ctypes.c_char_p, ctypes.c_int, ctypes.c_char_p, ctypes.c_char_p),
    ctypes.c_char_p,  # of "%s"
)


class Host(ctypes.Structure):
    """What a simulator offers to a unit."""

    _fields_ = (
        ("logger", LOGGER),
        ("not_used", ctypes.c_void_p * 3),
        ("environment", ctypes.c_void_p),
    )


class Place(NamedTuple):
    """A variable as the model description has it."""

    reference: int
    kind: str
    causality: str
    facts: dict[str, str]


def unpack(path: Path, folder: Path) -> "Unit":
    """Return the unit in a file, unpacked into a folder."""
    with zipfile.ZipFile(path) as archive:
        archive.extractall(folder)
    return Unit(folder)


class Unit:
    """An unpacked unit: its variables by name, and its library."""

    def __init__(self, folder: Path) -> None:
        """Read the description and load the library."""
        self.description = ET.parse(folder / "modelDescription.xml").getroot()  # noqa: S314
        self.version = int(self.description.attrib["fmiVersion"][0])
        token = {2: "guid", 3: "instantiationToken"}[self.version]
        self.guid = self.description.attrib[token].encode()
        self.variables = {}
        described = self.description.find("ModelVariables")
        assert described is not None
        for each in described:
            reference, causality = int(each.attrib["valueReference"]), each.attrib["causality"]
            own = each[0] if self.version == 2 else each
            self.variables[each.attrib["name"]] = Place(reference, own.tag, causality, own.attrib)
        place = SHIPPED_PLATFORMS[platform_name()].unit_folders[self.version - 2]
        (self.path,) = (folder / "binaries" / place).glob("*.so")
        self.library: Any = ctypes.CDLL(str(self.path))
        self.numbers = NUMBERS[self.version]

    @property
    def real(self) -> str:
        """Return what its version calls a real number."""
        return next(iter(self.numbers))

    def function(self, name: str) -> Any:
        """Return a function of its library, by its name in FMI 3.0."""
        name = NAMES_OF_2.get(name, name) if self.version == 2 else name
        return getattr(self.library, f"fmi{self.version}{name}")


def begun(unit: Unit, **start: float) -> "Instance":
    """Return a new boat of a unit, begun with these values of variables."""
    boat = Instance(unit)
    boat.begin(**start)
    return boat


class Instance:
    """One boat of a unit, and what it told its logger."""

    def __init__(self, unit: Unit) -> None:
        """Instantiate a boat."""
        self.unit, self.told, self.time = unit, [""], 0.0
        made = self._made_by_2() if unit.version == 2 else self.make()
        assert made
        self.address = ctypes.c_void_p(made)

    def _made_by_2(self) -> Any:
        self._host = Host(LOGGER(self._log))
        make = self.unit.function("Instantiate")
        make.restype = ctypes.c_void_p
        return make(b"boat", CO_SIMULATION, self.unit.guid, b"", ctypes.byref(self._host), 0, 0)

    def make(self, interface: str = "CoSimulation") -> Any:
        """Return a new instance of FMI 3.0 with that interface, None where it is refused."""
        self._logger = LOGGER_OF_3(self._log)
        make = self.unit.function(f"Instantiate{interface}")
        make.restype = ctypes.c_void_p
        asked = () if interface != "CoSimulation" else (NO, NO, NOTHING, ctypes.c_size_t(0))
        given = (b"boat", self.unit.guid, b"", NO, NO, *asked, NOTHING, self._logger, NOTHING)
        return make(*given)

    def _log(self, *given: Any) -> None:
        self.told.append(given[-1].decode())

    def begin(self, **start: float) -> None:
        """Go through the initialization with these values of variables."""
        self.time = 0.0
        zero = ctypes.c_double(0.0)
        times = (0, zero, zero, 0, zero)
        if self.unit.version == 2:
            assert self.call("SetupExperiment", *times) == OK
        assert self.call("EnterInitializationMode", *times) == OK
        for name, value in start.items():
            assert self.set(name, value) == OK, self.told[-1]
        assert self.call("ExitInitializationMode") == OK

    def call(self, name: str, *given: Any) -> int:
        """Call a function of the unit; return its status."""
        return int(self.unit.function(name)(self.address, *given))

    def set(self, name: str, value: float) -> int:
        """Set a variable; return the status."""
        reference, kind, *_ = self.unit.variables[name]
        number, place = self.unit.numbers[kind](value), ctypes.c_uint(reference)
        count = ctypes.c_size_t(1)
        there = (ctypes.byref(place), count, ctypes.byref(number), count)
        return self.call(f"Set{kind}", *there[: self.unit.version + 1])

    def get(self, name: str) -> float:
        """Return a variable."""
        reference, kind, *_ = self.unit.variables[name]
        number, place = self.unit.numbers[kind](), ctypes.c_uint(reference)
        count = ctypes.c_size_t(1)
        there = (ctypes.byref(place), count, ctypes.byref(number), count)
        assert self.call(f"Get{kind}", *there[: self.unit.version + 1]) == OK
        return float(number.value)

    def step(self, ticks: int = 1, size: float = 0.5) -> int:
        """Make steps; return the status of the last."""
        status = OK
        for _ in range(ticks):
            status = self.sail(self.time, size)
            self.time += size if status == OK else 0.0
        return status

    def sail(self, now: float, size: float) -> int:
        """Make one step from a moment [s]; return its status."""
        moment, length = ctypes.c_double(now), ctypes.c_double(size)
        if self.unit.version == 2:
            return self.call("DoStep", moment, length, 1)
        flags, reached = (ctypes.c_bool * 3)(YES, YES, YES), ctypes.c_double()
        told = (*(ctypes.byref(flags, i) for i in range(3)), ctypes.byref(reached))
        status = self.call("DoStep", moment, length, YES, *told)
        if status == OK:
            assert not any(flags)
            assert reached.value == pytest.approx(now + size, rel=1e-12)
        return status

    def serialised(self) -> bytes:
        """Return the state as bytes."""
        kept, size = ctypes.c_void_p(), ctypes.c_size_t()
        assert self.call("GetFMUState", ctypes.byref(kept)) == OK
        assert self.call("SerializedFMUStateSize", kept, ctypes.byref(size)) == OK
        block = ctypes.create_string_buffer(size.value)
        assert self.call("SerializeFMUState", kept, block, size) == OK
        assert self.call("FreeFMUState", ctypes.byref(kept)) == OK
        assert kept.value is None
        return block.raw

    def numbers(self) -> bytes:
        """Return the bytes of the boat's state."""
        return self.serialised()[GUID_BYTES : GUID_BYTES + STATE.itemsize]

    def restore(self, data: bytes) -> int:
        """Go to a serialised state; return the status."""
        kept = ctypes.c_void_p()
        size = ctypes.c_size_t(len(data))
        status = self.call("DeserializeFMUState", data, size, ctypes.byref(kept))
        if status == OK:
            assert self.call("SetFMUState", kept) == OK
            assert self.call("FreeFMUState", ctypes.byref(kept)) == OK
        return status

    def free(self) -> None:
        """Free the boat."""
        self.unit.function("FreeInstance")(self.address)


def main() -> None:
    """Go on from a state that another process saved: FOLDER FILE TICKS, to the same file."""
    folder, file, ticks = Path(sys.argv[1]), Path(sys.argv[2]), int(sys.argv[3])
    boat = Instance(Unit(folder))
    assert boat.restore(file.read_bytes()) == OK
    boat.time = boat.get("tick") * 0.5
    assert boat.step(ticks) == OK
    file.write_bytes(boat.serialised())


if __name__ == "__main__":
    main()
