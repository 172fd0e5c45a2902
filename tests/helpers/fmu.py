"""A functional mock-up unit as a simulator has it, by ctypes: FMI 2.0 for co-simulation."""

import ctypes
import sys
import xml.etree.ElementTree as ET
import zipfile
from pathlib import Path
from typing import Any, Final, NamedTuple

from trainer.core.state import STATE

OK, ERROR = 0, 3
CO_SIMULATION = 1
NUMBERS: Final[dict[str, Any]] = {
    "Real": ctypes.c_double,
    "Integer": ctypes.c_int,
    "Boolean": ctypes.c_int,
}
GUID_BYTES = 40  # before the numbers of a serialised state
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
        self.guid = self.description.attrib["guid"].encode()
        self.variables = {}
        for each in self.description.iter("ScalarVariable"):
            reference, causality = int(each.attrib["valueReference"]), each.attrib["causality"]
            self.variables[each.attrib["name"]] = Place(
                reference, each[0].tag, causality, each[0].attrib
            )
        (self.path,) = folder.glob("binaries/linux64/*.so")
        self.library: Any = ctypes.CDLL(str(self.path))
        self.library.fmi2Instantiate.restype = ctypes.c_void_p


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
        self._host = Host(LOGGER(self._log))
        made = unit.library.fmi2Instantiate(
            b"boat", CO_SIMULATION, unit.guid, b"", ctypes.byref(self._host), 0, 0
        )
        assert made
        self.address = ctypes.c_void_p(made)

    def _log(self, *given: Any) -> None:
        assert given[4] == b"%s"
        self.told.append(given[5].decode())

    def begin(self, **start: float) -> None:
        """Go through the initialization with these values of variables."""
        self.time = 0.0
        zero = ctypes.c_double(0.0)
        assert self.call("SetupExperiment", 0, zero, zero, 0, zero) == OK
        assert self.call("EnterInitializationMode") == OK
        for name, value in start.items():
            assert self.set(name, value) == OK, self.told[-1]
        assert self.call("ExitInitializationMode") == OK

    def call(self, name: str, *given: Any) -> int:
        """Call a function of the unit; return its status."""
        return int(getattr(self.unit.library, f"fmi2{name}")(self.address, *given))

    def set(self, name: str, value: float) -> int:
        """Set a variable; return the status."""
        reference, kind, *_ = self.unit.variables[name]
        number = NUMBERS[kind](value)
        place = ctypes.c_uint(reference)
        return self.call(
            f"Set{kind}", ctypes.byref(place), ctypes.c_size_t(1), ctypes.byref(number)
        )

    def get(self, name: str) -> float:
        """Return a variable."""
        reference, kind, *_ = self.unit.variables[name]
        number, place = NUMBERS[kind](), ctypes.c_uint(reference)
        count = ctypes.c_size_t(1)
        assert self.call(f"Get{kind}", ctypes.byref(place), count, ctypes.byref(number)) == OK
        return float(number.value)

    def step(self, ticks: int = 1, size: float = 0.5) -> int:
        """Make steps; return the status of the last."""
        status = OK
        for _ in range(ticks):
            status = self.call("DoStep", ctypes.c_double(self.time), ctypes.c_double(size), 1)
            self.time += size if status == OK else 0.0
        return status

    def serialised(self) -> bytes:
        """Return the state as bytes."""
        kept, size = ctypes.c_void_p(), ctypes.c_size_t()
        assert self.call("GetFMUstate", ctypes.byref(kept)) == OK
        assert self.call("SerializedFMUstateSize", kept, ctypes.byref(size)) == OK
        block = ctypes.create_string_buffer(size.value)
        assert self.call("SerializeFMUstate", kept, block, size) == OK
        assert self.call("FreeFMUstate", ctypes.byref(kept)) == OK
        assert kept.value is None
        return block.raw

    def numbers(self) -> bytes:
        """Return the bytes of the boat's state."""
        return self.serialised()[GUID_BYTES : GUID_BYTES + STATE.itemsize]

    def restore(self, data: bytes) -> int:
        """Go to a serialised state; return the status."""
        kept = ctypes.c_void_p()
        size = ctypes.c_size_t(len(data))
        status = self.call("DeSerializeFMUstate", data, size, ctypes.byref(kept))
        if status == OK:
            assert self.call("SetFMUstate", kept) == OK
            assert self.call("FreeFMUstate", ctypes.byref(kept)) == OK
        return status

    def free(self) -> None:
        """Free the boat."""
        self.unit.library.fmi2FreeInstance(self.address)


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
