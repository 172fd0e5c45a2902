"""The instructions of a shipped tick, counted by valgrind: exact at any load.

``python -m tests.bench --instructions`` prints them beside those that ``instructions.json`` keeps;
that file is written anew by hand where a change of the core is meant to change them.
"""

import gzip
import json
import re
import shlex
import shutil
import subprocess
import tempfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from helpers.loops import CASUALTY_KINDS

from trainer.boat.assemble import Method
from trainer.boat.boat import Boat
from trainer.boat.casualties import insert_casualty
from trainer.boat.machine_code import SHIPPED_FOLDER
from trainer.boat.platforms import platform_name
from trainer.config.boat.vessel import load_vessel
from trainer.config.files import ConfigError
from trainer.config.world.sea import load_sea
from trainer.units import KNOT

HOST: Final = Path(__file__).with_suffix(".c")
KEPT: Final = Path(__file__).with_suffix(".json")
MEASURED: Final = "linux-x86_64"
COUNTED: Final = re.compile(r"Collected : (\d+)")
FEW, MANY = 200, 1200  # [ticks] of two runs, whose difference has no start in it


@dataclass(frozen=True)
class Instructions:
    """The instructions of one tick, by where the boat is."""

    now: dict[str, float]
    kept: dict[str, float]


def boat_at(name: str, depth: float, sea: str = "calm") -> Boat:
    """Return a boat at its own speed, at a depth [m] in a sea."""
    file = load_vessel(name)
    boat = Boat(file, Method("modified", "lagged", "exact", "adams2", file.run.step_s))
    boat.start(file.run.start_speed_kn * KNOT, depth, 0.0)
    boat.put_to_sea(load_sea(sea))
    return boat


def troubled() -> Boat:
    """Return a boat with six casualties."""
    boat = boat_at("bb2", 60.0)
    for name in CASUALTY_KINDS:
        insert_casualty(boat, name)
    return boat


PLACES: Final[Mapping[str, Callable[[], Boat]]] = {
    "bb2, calm, 60 m": lambda: boat_at("bb2", 60.0),
    "bb2, sea state 5, 60 m": lambda: boat_at("bb2", 60.0, "sea-state-5"),
    "bb2, calm, 18 m": lambda: boat_at("bb2", 18.0),
    "bb2, sea state 5, 18 m": lambda: boat_at("bb2", 18.0, "sea-state-5"),
    "bb2, six casualties": troubled,
    "sdv-mk9, calm, 20 m": lambda: boat_at("sdv-mk9", 20.0),
    "remus100, calm, 20 m": lambda: boat_at("remus100", 20.0),
}


def build_host(folder: Path) -> Path:
    """Return the host with the shipped object in it; ConfigError where it cannot be built."""
    compiler = shlex.split("cc")
    if platform_name() != MEASURED:
        raise ConfigError(f"instructions are counted on {MEASURED}, by the shipped object alone")
    for program in ("valgrind", compiler[0]):
        if not shutil.which(program):
            raise ConfigError(f"instructions are not counted: there is no {program} here")
    code = gzip.decompress((SHIPPED_FOLDER / f"{MEASURED}.o.gz").read_bytes())
    (folder / "tick.o").write_bytes(code)
    words = [*compiler, "-O2", "-o", str(folder / "host"), str(HOST), str(folder / "tick.o")]
    subprocess.run(words, check=True)
    return folder / "host"


def count(host: Path, boat: Boat) -> float:
    """Return the instructions of a tick of a boat as it stands."""
    file = host.with_name("records.bin")
    file.write_bytes(b"".join(record.tobytes() for record in boat.records))
    sizes = [str(record.nbytes) for record in boat.records]
    few, many = (collected(host, [str(file), str(ticks), *sizes]) for ticks in (FEW, MANY))
    return (many - few) / (MANY - FEW)


def collected(host: Path, words: list[str]) -> int:
    """Return the instructions of a whole run of the host."""
    command = ["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null", str(host), *words]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    found = COUNTED.search(done.stderr)
    assert found, done.stderr
    return int(found[1])


def measure() -> Instructions:
    """Count the instructions of a tick in each place; ConfigError where that cannot be done."""
    with tempfile.TemporaryDirectory() as folder:
        host = build_host(Path(folder))
        now = {name: count(host, make()) for name, make in PLACES.items()}
    return Instructions(now, json.loads(KEPT.read_text("utf-8")))


def lines(figures: Instructions) -> list[str]:
    """Return the figures as lines of a page."""
    rows = [
        f"  {name:<28}{number:8,.0f}{figures.kept.get(name, float('nan')):10,.0f}"
        for name, number in figures.now.items()
    ]
    heading = f"INSTRUCTIONS A TICK ({MEASURED}, the shipped object; by valgrind, exact)"
    return ["", heading, f"  {'':<28}{'now':>8}{'kept':>10}", *rows]
