"""A boat as a functional mock-up unit for co-simulation, without Python inside.

``trainer boat export-fmu`` calls it, by FMI 2.0 or 3.0. The variables follow from the tables of
state, orders and casualties. For each platform a C compiler links ``unit.c`` with the face of a
version (``fmi2.c``, ``fmi3.c``), the boat's numbers and the small object that the trainer ships
for it; ``component`` makes the one for WebAssembly.
"""

import hashlib
import inspect
import io
import os
import re
import shlex
import subprocess
import tempfile
import uuid
import zipfile
from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass, replace
from importlib import metadata
from pathlib import Path
from typing import Final

import jinja2
import numpy as np

from trainer import __version__
from trainer.boat import casualties
from trainer.boat.boat import STATE_OFFSETS, Boat
from trainer.boat.effects import NumberRange, effects_of_boat
from trainer.boat.export.component import (
    COMPONENT_SOURCES,
    MANIFEST_PLACE,
    MANIFEST_TEXT,
    MODULE_OPTIONS,
    component_of,
)
from trainer.boat.export.header import field_comments, fields_of, record_members
from trainer.boat.export.targets import lacking_linker
from trainer.boat.machine_code import shipped_object
from trainer.boat.platforms import (
    NATIVE_PLATFORMS,
    UNIT_OBJECTS,
    UNIT_PLATFORMS,
    WASM_PLATFORM,
    Platform,
    platform_name,
)
from trainer.boat.sea_orders import fully_developed
from trainer.config.boat.casualties import GAUGE_UNITS
from trainer.config.files import ConfigError
from trainer.config.world.sea import SEA_STATE_HEIGHT, SeaFile, sea_settings, step_problem
from trainer.core import state
from trainer.core.digest import core_digest
from trainer.core.state import MAX_CASUALTIES, SCRATCH, STATE
from trainer.core.update import WATCHED_NAMES
from trainer.io.orders.quantities import DEGREES, KNOTS, METRES, TONNES
from trainer.io.tables import MOTION_COLUMNS

SOURCE_FOLDER: Final = Path(__file__).parent
MAX_SEED: Final = 2**31 - 1  # because an Integer of FMI has 32 bits
STATE_DOUBLES: Final = STATE.itemsize // 8
ORDER_UNITS: Final = {unit.factor: unit.names[0] for unit in (METRES, DEGREES, KNOTS, TONNES)}
MOTION_UNITS: Final = re.compile(r"^# (.*)\nMOTION", re.MULTILINE)  # a comment in ``core.state``
STATED_UNIT: Final = re.compile(r"^\[(.*?)\] ?")  # as comments there begin
COMPILER_OPTIONS: Final = (
    *("-std=c99", "-Os", "-ffp-contract=off", "-o", "boat.so"),
    *("face.c", "core.o", "-lm"),
)
NO_NUMBER: Final = NumberRange(0.0, 0.0, 0.0)  # of an order that has none
LIBRARY_ENDINGS: Final = {"linux": ".so", "windows": ".dll", WASM_PLATFORM: ".wasm"}  # by system
SYSTEM_OPTIONS: Final = {
    "linux": (
        *("-shared", "-s", "-fPIC", "-Wl,-z,defs", "-Wl,--build-id=none"),
        "-Wl,--version-script=map",
    ),
    "windows": ("-shared", "-s", "-static-libgcc", "-Wl,--no-insert-timestamp"),
    WASM_PLATFORM: MODULE_OPTIONS,
}
SHOWN_NAMES: Final = "{{ global: {face}*; local: *; }};\n"
TYPE_NAMES: Final = {"Real": "Float64", "Integer": "Int32"}  # of FMI 3.0


@dataclass(frozen=True)
class Variable:
    """One variable of the model; ``unit.c`` has the types and rules."""

    name: str
    meaning: str
    index: int  # in the state, or of a gauge, or the code of a casualty
    type: str = "Real"
    causality: str = "local"
    rule: str = "READ"
    unit: str = ""
    low: float = 0.0
    high: float = 0.0
    scale: float = 1.0  # SI = scale x value
    start: float = 0.0
    cleared: int = -1  # offset that becomes 0 with a new value
    shortened: int = -1  # angle that loses its whole turns with the value 0
    ramps: tuple[float, float] = (0.0, 0.0)  # [ticks] to come on, and to go

    @property
    def limits(self) -> str:
        """Return its limits in words."""
        return f"must be {self.low:g} to {self.high:g} {self.unit}".rstrip()

    @property
    def row(self) -> str:
        """Return its row of the table in C."""
        words = f'{self.type.upper()}, {self.rule}, "{self.name}", "{self.limits}"'
        numbers = (self.low, self.high, self.scale, self.index, self.cleared, self.shortened)
        return f"{{{words}, {', '.join(map(repr, (*numbers, *self.ramps)))}}}"


def order_inputs(boat: Boat, names: dict[int, str]) -> Iterator[Variable]:
    """Yield an input for each number of the state that orders can change."""
    comments = field_comments(state)
    found: dict[int, Variable] = {}
    zeros: dict[int, list[int]] = {}  # other fields that an order of numbers makes 0
    for effect in effects_of_boat(boat):
        low, high, factor, turn = effect.number or NO_NUMBER
        zeroed = [at for at, *rule in effect.writes if rule == ["const", 0.0]]
        for at, kind, x in effect.writes:
            meaning = STATED_UNIT.sub("", comments.get(names[at], ""))
            each = found.get(at, Variable(names[at], meaning, at, "Integer", "input", "NUMBER"))
            if kind == "short":
                each = replace(each, type="Real", rule="COURSE", high=float(turn), scale=factor)
                each = replace(each, unit=ORDER_UNITS[factor])
            elif kind == "number":  # positive is right, rise, ahead, in, forward
                scale, zeros[at] = each.scale if each.unit else x * abs(factor), zeroed
                before = (each.low, each.high) if each.unit else ()
                ends = (*before, *(round(x * end / scale, 6) for end in (low, high)))
                each = replace(each, type="Real", scale=scale, unit=ORDER_UNITS[abs(factor)])
                each = replace(each, low=min(ends) + 0.0, high=max(ends))
                each = replace(each, meaning=each.meaning or f"order: {effect.words}")
            elif kind == "const" and not each.unit:
                each = replace(each, high=max(each.high, x))
            elif kind == "shorter" and len(zeroed) == 1:  # one surface goes to the autopilot
                found[zeroed[0]] = replace(found[zeroed[0]], shortened=at)
            found[at] = each
    for at, each in found.items():
        start = float(boat.plain[at]) / each.scale + 0.0
        start = start % each.high if each.rule == "COURSE" else start
        cleared = next((other for other in zeros.get(at, ()) if not found[other].high), -1)
        kind = "Boolean" if (each.type, each.high) == ("Integer", 1.0) else each.type
        if each.high > 0.0:
            yield replace(each, type=kind, start=start, cleared=cleared)


def casualty_inputs(boat: Boat) -> Iterator[Variable]:
    """Yield a severity, 0 for none, for each casualty of the boat."""
    before, s = boat.snapshot(), boat.state
    for name, _, meaning in casualties.available_casualties(boat):
        if boat.casualties[name].parts:  # each part is an input
            continue
        casualties.insert_casualty(boat, name, 1.0)
        scale, ramp = float(s.casualty_target[0]), float(s.casualty_ticks[0])
        casualties.clear_casualty(boat, name)
        ramps = ramp, -float(s.casualty_ticks[0])
        boat.restore(before)
        measure, code = boat.casualties[name].measure, boat.casualties[name].code
        kind, named = "Boolean" if measure.sudden else "Real", f"casualty_{name.replace('-', '_')}"
        base = Variable(named, meaning, code, kind, "input", "CASUALTY", scale=scale, ramps=ramps)
        yield replace(base, low=min(measure.limits.low, 0.0), high=measure.limits.high)


def state_outputs(names: dict[int, str]) -> Iterator[Variable]:
    """Yield the numbers of the state; those of recordings are outputs."""
    said: dict[str, str] = field_comments(state)
    motion = MOTION_UNITS.findall(inspect.getsource(state))[0].split()
    said |= dict(zip(state.MOTION, motion, strict=True))
    # the comment of a block stands for its first number, and goes on to those without one
    said |= {
        names[at]: said[name] for name, at in STATE_OFFSETS.items() if name in said and at in names
    }
    last = ""
    for offset, name in names.items():
        last = said.get(name, last)
        shown = Variable(name, said.get(name, ""), offset)
        if name in MOTION_COLUMNS:
            unit = STATED_UNIT.findall(last)[0].strip("-")
            shown = replace(shown, causality="output", unit=unit)
        yield shown


def variables_of(boat: Boat, sea: SeaFile) -> list[Variable]:
    """Return the variables of a boat; a value reference is an index among them."""
    names = {offset // 8: name for name, offset, shape in record_members(STATE) if not shape}
    degrees = f"degree of the sea, WMO code 3700; -1: {sea.name}, as exported"
    seed = Variable("seed", "of all random numbers", STATE_OFFSETS["seed"], "Integer", "parameter")
    degree = replace(seed, name="sea_state", meaning=degrees, index=STATE_DOUBLES, low=-1.0)
    way = Variable("sea_from", "true, where the waves come from", STATE_DOUBLES + 1, unit="deg")
    parameters = [
        replace(seed, high=MAX_SEED, start=boat.state.seed),
        replace(degree, high=len(SEA_STATE_HEIGHT) - 1, start=-1.0),
        replace(way, causality="parameter", high=360.0, start=sea.sea.direction_deg),
    ]
    time = replace(way, name="time", meaning="of the simulator", index=0, causality="independent")
    time = replace(time, rule="TIME", unit="s")
    settable = [replace(each, rule="PARAMETER") for each in parameters]
    settable += [*order_inputs(boat, names), *casualty_inputs(boat)]
    gauges = [
        Variable(name.replace("-", "_"), "as it reads", i, "Real", "output", "GAUGE", unit, scale=x)
        for i, (name, (unit, x)) in enumerate(GAUGE_UNITS.items())
    ]
    taken = {each.name for each in settable}
    states = (each for each in state_outputs(names) if each.name not in taken)
    return [*settable, *gauges, *states, time]


def c_array(kind: str, name: str, values: Iterable[object]) -> str:
    """Return a constant array in C."""
    return f"static const {kind} {name}[] = {{{', '.join(map(str, values))}}};\n"


def model_text(boat: Boat, sea: SeaFile, variables: list[Variable]) -> str:
    """Return ``model.h`` but for the GUID: the boat's numbers, its variables, the seas."""
    step, g = boat.method.step, boat.vessel.g
    offsets = {"TICK": "tick", "PSI": "psi", "SEA": "sea", "CASUALTY": "casualty"}
    offsets |= {"TARGET": "casualty_target", "TICKS": "casualty_ticks"}
    whole = {f"{short}_PLACE": STATE_OFFSETS[name] for short, name in offsets.items()}
    whole["READING_PLACE"] = fields_of(SCRATCH)["reading"][0] // 8
    whole |= {"STATE_DOUBLES": STATE_DOUBLES, "SCRATCH_DOUBLES": SCRATCH.itemsize // 8}
    whole |= {"CASUALTY_SLOTS": MAX_CASUALTIES, "VARIABLE_COUNT": len(variables)}
    whole["SETTABLE_COUNT"] = sum(v.causality in ("parameter", "input") for v in variables)
    numbers = {"STEP_S": step, "DEGREE": DEGREES.factor, "START_SEA_FROM": sea.sea.direction_deg}
    text = f"enum {{ {', '.join(f'{name} = {value}' for name, value in whole.items())} }};\n"
    text += "".join(f"static const double {name} = {x!r};\n" for name, x in numbers.items())
    r = boat.records
    records = {"VESSEL": r.vessel, "COMPACT": r.compact, "SCHEME": r.scheme, "START": r.state}
    for name, record in records.items():
        words = np.frombuffer(record.tobytes(), np.uint64).tolist()
        text += c_array("unsigned long long", name, map(hex, words))
    degrees = range(len(SEA_STATE_HEIGHT))
    others = [replace(sea, sea=fully_developed(sea.sea, "state", float(n))) for n in degrees]
    wanted = [sea_settings(each, g) for each in (sea, *others)]
    fits = (f"{{{{{str(w.tolist())[1:-1]}}}, {not step_problem(w, step):d}}}" for w in wanted)
    text += c_array("struct sea", "SEAS", fits)
    text += c_array("char *const", "WATCHED", (f'"{name}"' for name in WATCHED_NAMES))
    return text + c_array("struct variable", "VARIABLES", (each.row for each in variables))


def face_sources(version: int) -> dict[str, bytes]:
    """Return the C sources of a version of FMI."""
    names = {"face.c": f"fmi{version}.c", "unit.c": "unit.c"}
    return {name: (SOURCE_FOLDER / source).read_bytes() for name, source in names.items()}


def chosen_platforms(asked: Collection[str]) -> list[str]:
    """Return the platforms of a unit: those asked for, or this machine's."""
    here = platform_name()
    if asked or here in NATIVE_PLATFORMS:
        return [name for name in UNIT_PLATFORMS if name in (asked or (here,))]
    raise ConfigError(
        f"export-fmu: there is no unit for {here}: give --platform {', '.join(UNIT_PLATFORMS)}"
    )


def find_linker(name: str) -> tuple[list[str], Platform]:
    """Return the compiler that links for a platform here, and the platform with its packages."""
    target = UNIT_PLATFORMS[name]
    if name == platform_name():
        return shlex.split(os.environ.get("CC") or "cc"), target._replace(packages="gcc")
    return [target.compiler], target


def link_binary(model: str, name: str, version: int) -> bytes:
    """Return the library of a model for a platform; ConfigError where none is made."""
    code, (compiler, target) = shipped_object(UNIT_OBJECTS[name]), find_linker(name)
    if code is None:
        raise ConfigError(
            "export-fmu: the core is not that of the shipped objects: trainer boat export-core "
            "trainer/boat/shipped --cpu shipped makes them again"
        )
    words = [*compiler, *COMPILER_OPTIONS, *SYSTEM_OPTIONS[name.partition("-")[0]]]
    if refused := lacking_linker(target, words[0]):
        own = "; CC names another" if name == platform_name() else ""
        raise ConfigError(f"export-fmu, {name}: {refused.reason}{own}")
    shown = SHOWN_NAMES.format(face=f"fmi{version}").encode()
    files = {"model.h": model.encode(), "map": shown, "core.o": code} | face_sources(version)
    if name == WASM_PLATFORM:
        files |= {file: (SOURCE_FOLDER / said).read_bytes() for file, said in COMPONENT_SOURCES}
    with tempfile.TemporaryDirectory() as folder:
        for file, data in files.items():
            Path(folder, file).write_bytes(data)
        done = subprocess.run(words, cwd=folder, capture_output=True, text=True, check=False)  # noqa: S603
        if done.returncode == 0:
            made = Path(folder, "boat.so").read_bytes()
            return component_of(made) if name == WASM_PLATFORM else made
    said = (done.stderr.strip().splitlines() or ["no word"])[-1]
    raise ConfigError(
        f"export-fmu, {name}: {words[0]}: {said}; Debian and Ubuntu: apt install {target.packages}"
    )


def fmu_bytes(boat: Boat, sea: SeaFile, version: int = 2, platforms: Collection[str] = ()) -> bytes:
    """Return the unit of a boat at its start in its world, for ``sea``.

    ``version`` is 2 or 3, of FMI; without ``platforms`` it is for this machine's. ConfigError with
    the next step where it cannot be made.
    """
    if boat.chart is not None or not boat.world.stands(boat.ticks):
        raise ConfigError(
            "export-fmu: a ground that is not level, a ship that pulls, and a current that changes "
            "belong to the trainer's session: leave them out"
        )
    if WASM_PLATFORM in platforms and version == 2:
        raise ConfigError(
            f"export-fmu: --platform {WASM_PLATFORM} is of FMI 3.0 alone: give --fmi 3"
        )
    if boat.state.seed > MAX_SEED:
        raise ConfigError(f"--seed {boat.state.seed:.0f}: must be at most {MAX_SEED} in an FMU")
    variables = variables_of(boat, sea)
    model = model_text(boat, sea, variables)
    sources = b"".join(face_sources(version).values())
    # whatever its platforms, so that a state goes on at any of them
    digest = hashlib.sha256(model.encode() + sources + core_digest().encode())
    guid = f"{{{uuid.UUID(bytes=digest.digest()[:16])}}}"
    identifier = re.sub(r"\W", "_", f"trainer_{boat.file.path.stem}", flags=re.ASCII)
    facts = {"boat": boat, "guid": guid, "identifier": identifier, "variables": variables}
    facts |= {"version": __version__, "degree": DEGREES.factor, "knot": KNOTS.factor}
    facts |= {"type_names": TYPE_NAMES}
    folder = jinja2.FileSystemLoader(SOURCE_FOLDER)
    pages = jinja2.Environment(loader=folder, autoescape=True, trim_blocks=True)
    licence = metadata.distribution("submarine-trainer").read_text("licenses/LICENSE")
    numbers = f'#define GUID "{guid}"\n{model}'
    libraries = {
        f"binaries/{UNIT_PLATFORMS[name].unit_folders[version - 2]}/{identifier}"
        + LIBRARY_ENDINGS[name.partition("-")[0]]: link_binary(numbers, name, version)
        for name in chosen_platforms(platforms)
    }
    files: dict[str, str | bytes] = {
        "modelDescription.xml": pages.get_template(f"fmi{version}.xml").render(facts),
        **libraries,
        "documentation/index.html": pages.get_template("fmu.html").render(facts),
        "documentation/licenses/license.txt": licence or "MIT\n",
    }
    if WASM_PLATFORM in platforms:
        files[MANIFEST_PLACE] = MANIFEST_TEXT
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w") as archive:
        for name, data in files.items():
            entry = zipfile.ZipInfo(name)  # without a date, so that two exports have the same bytes
            entry.external_attr = 0o644 << 16
            archive.writestr(entry, data, zipfile.ZIP_DEFLATED, 9)
    return packed.getvalue()
