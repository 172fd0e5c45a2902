"""The standard hour on other processors, in emulators, and in WebAssembly.

Each that is here flies the core as a user exports it; of the others the Debian package is named.
"""

import shutil
import tempfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Final, NamedTuple

from helpers import tab
from helpers.emulated import EMULATORS, fly_exported_hour, needed_programs
from helpers.loops import in_a_loop

from bench.standard_hour import fly_hour, standard_boat
from trainer.boat.machine_code import way_name
from trainer.debrief.page.boat_page import boat_for_page


class Machine(NamedTuple):
    """How the hour is flown on a machine, and packages by program that does it."""

    fly: Callable[[], str]
    programs: Mapping[str, str]


@dataclass(frozen=True)
class MachineHours:
    """In what bits the hour ends on each machine, and what the others lack."""

    here: str
    sha256: dict[str, str]  # by machine
    packages: dict[str, str]  # of Debian, by machine
    same: bool


def fly_in_folder(cpu: str) -> str:
    """Return the digest of the hour by the core that is exported for a target."""
    with tempfile.TemporaryDirectory(prefix="trainer-") as folder:
        return fly_exported_hour(cpu, Path(folder))


def fly_in_node() -> str:
    """Return the digest of the hour by the core for WebAssembly, in node."""
    deeds, _ = tab.standard_hour()
    return str(tab.fly(boat_for_page(standard_boat(), "instructor"), *deeds, ("digest",))[-1])


MACHINES: Final[Mapping[str, Machine]] = {
    **{cpu: Machine(partial(fly_in_folder, cpu), needed_programs(cpu)) for cpu in EMULATORS},
    "wasm32": Machine(fly_in_node, {"node": "nodejs"}),
}


def fly_on_machines(machines: Mapping[str, Machine] = MACHINES) -> MachineHours:
    """Return in what bits the standard hour ends on each machine that is here."""
    digests, packages = {f"here, {way_name()}": fly_hour(in_a_loop)}, {}
    (here,) = digests.values()
    for name, machine in machines.items():
        missing = [
            names for program, names in machine.programs.items() if not shutil.which(program)
        ]
        if missing:
            packages[name] = " ".join(missing)
        else:
            digests[name] = machine.fly()
    return MachineHours(here, digests, packages, set(digests.values()) == {here})


def lines(figures: MachineHours) -> list[str]:
    """Return the answer as lines of a page."""
    flown = [
        f"  {name:<24}{sha256[:32]}  {'same' if sha256 == figures.here else 'NOT THE SAME'}"
        for name, sha256 in figures.sha256.items()
    ]
    lacking = [
        f"  {name:<24}not flown: apt install {names}" for name, names in figures.packages.items()
    ]
    answer = "the same bits" if figures.same else "NOT THE SAME BITS"
    return ["", f"OTHER PROCESSORS (the standard hour; SHA-256): {answer}", *flown, *lacking]
