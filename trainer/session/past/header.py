"""The header of a recording: how its run was made, and what differs today.

A header holds these texts: ``plan``, the form of the header; ``trainer``, ``core``,
``python``, ``numpy``, ``numba`` and ``machine``, what computed it; ``started``, when; and as JSON
``options``, those of the command line that a plan depends on; ``texts``, every file read, by its
key; ``method``; ``layout``, the name of each number of a state; ``vessel``, its key, and ``seed``.
Some have ``width``, by which it is judged, ``trainees``, names as JSON, ``endless``, where the
battery was not drained, and ``alone``, where who trains sat alone at the console; ``nomoto`` is the
form of the equation by which Nomoto ships went, the first where there is none; ``rules``, the same
of the rules of marking.

``texts`` makes a recording whole: it can be replayed after its exercise or vessel file has changed.
``differences`` lists what has changed since and may change bits, before a replay or a resumed run.
"""

import getpass
import json
import platform
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import closing, contextmanager
from dataclasses import asdict, fields, replace
from datetime import UTC, datetime
from functools import cache
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final

from trainer import __version__
from trainer.boat.assemble import Method
from trainer.boat.boat import Boat
from trainer.config.boat.vessel import load_vessel
from trainer.config.exercise.baseline import BASELINE_SUFFIX
from trainer.config.exercise.progress import file_stem
from trainer.config.exercise.score_rules import RULES_FORM
from trainer.config.files import (
    ABANDONED_FILES,
    ConfigError,
    collecting,
    key_of,
    no_constant,
    path_of,
    quote,
    reading_recorded,
    remembering,
)
from trainer.config.ship import nomoto
from trainer.config.words import ENDLESS_BATTERY
from trainer.config.world.soundings import read_as_kept
from trainer.core.digest import core_digest, same_core
from trainer.io.recording.recording import Recording, RecordingError, bring_home
from trainer.session.past.layout import LAYOUT, changes
from trainer.session.past.options import RunOptions
from trainer.session.past.plan import Plan, plan_run

PLAN_FORMAT: Final = "1"
# of the command line, that a plan depends on; their kind
PLAN_OPTIONS: Final[Mapping[str, Any]] = {
    **dict.fromkeys(("exercise", "sea", "orders_file", "equations", "rates"), str | None),
    **dict.fromkeys(("vessel", "trig", "integrator"), str),
    **dict.fromkeys(("duration", "step"), int | float | None),
    "seed": int,
}
TRAINEES_KEY: Final = "trainees"
FAMILIARISATION_KEY: Final = "familiarisation"  # there in a run that has no marks
ENDLESS_KEY: Final = "endless"  # there where the battery was not drained
ALONE_KEY: Final = "alone"  # there where who trains sat alone at the console
# form 1 differentiated a rudder that stood still within each step
NOMOTO_FORM: Final = "2"
MAX_NAME_LETTERS: Final = 60  # [characters]
# a key of exercises that came later, and changes nothing of how the boat is flown
VISITORS_PATTERN: Final = re.compile(r"^visitors[ \t]*=.*\n", re.MULTILINE)
MAX_OPTION_NUMBER: Final = 2.0**63  # of a number among the options
USED_LIBRARIES: Final = ("numpy", "numba")
NO_CHANGES: Final[Mapping[str, Any]] = MappingProxyType({})


def _are_texts(found: object) -> bool:
    return isinstance(found, list) and all(isinstance(each, str) for each in found)


# The parts of a header that are JSON, and what they have to be.
HEADER_PARTS: Final[Mapping[str, Callable[[Any], bool]]] = {
    "options": lambda found: isinstance(found, dict),
    "texts": lambda found: isinstance(found, dict) and _are_texts(list(found.values())),
    "method": lambda found: isinstance(found, dict),
    "layout": _are_texts,
    "vessel": lambda found: isinstance(found, str),
    "seed": lambda found: isinstance(found, int),
}


@contextmanager
def open_recording(path: Path) -> Iterator[Recording]:
    """Yield a recording to be read inside the block; ConfigError if it cannot be opened."""
    with refusing_damage(), closing(Recording.look(path)) as recording:
        yield recording


@contextmanager
def open_whole_recording(path: Path) -> Iterator[Recording]:
    """Yield a recording inside the block; ConfigError if it has too many branches to read."""
    with open_recording(path) as recording:
        recording.refuse_branches()
        yield recording
    bring_home(path)  # not after a refusal, which leaves everything as it was


@contextmanager
def refusing_damage() -> Iterator[None]:
    """Raise ConfigError for a recording that cannot be opened or read inside the block."""
    try:
        yield
    except RecordingError as error:
        raise ConfigError(str(error)) from None


def header_of(options: RunOptions, texts: Mapping[str, str], boat: Boat) -> dict[str, str]:
    """Return the header of a run that ``options`` planned from ``texts``, its boat just started."""
    planned = {name: getattr(options, name) for name in PLAN_OPTIONS}
    planned["given"] = sorted(options.given & planned.keys())
    return {
        "plan": PLAN_FORMAT,
        "trainer": __version__,
        "core": core_digest(),
        **_surroundings(),
        "started": datetime.now(UTC).isoformat(timespec="seconds"),
        "options": json.dumps(planned, default=str),  # a path is a text
        "texts": json.dumps(texts),
        "method": json.dumps(asdict(boat.method)),
        "layout": json.dumps(LAYOUT),
        "vessel": json.dumps(key_of(boat.file.path)),
        "seed": json.dumps(int(boat.state.seed)),
        "width": options.width,
        "nomoto": NOMOTO_FORM,
        "rules": RULES_FORM,
        **({TRAINEES_KEY: json.dumps(names_of(options.trainee))} if options.trainee else {}),
        **({ENDLESS_KEY: "yes"} if options.battery == ENDLESS_BATTERY else {}),
        **({FAMILIARISATION_KEY: "yes"} if options.familiarisation else {}),
        **({ALONE_KEY: "yes"} if options.train else {}),
    }


def names_of(given: Iterable[str]) -> list[str]:
    """Return names of trainees as the header has them, each once; ConfigError."""
    names = [" ".join(name.split()) for name in given]
    for name in names:
        if not name or not name.isprintable() or len(name) > MAX_NAME_LETTERS:
            wrong = (
                f"--trainee {quote(name)}: a name has 1 to {MAX_NAME_LETTERS} printable characters"
            )
            raise ConfigError(wrong)
        file_stem(name)
    return list(dict.fromkeys(names))


def learners_of(options: RunOptions) -> tuple[str, ...]:
    """Return by which names the progress of who trains is kept."""
    own = options.train or options.browse
    return options.trainee or (account_names() if own and not options.no_record else ())


def account_names() -> tuple[str, ...]:
    """Return the name of the user's account, none where none can be kept."""
    try:
        return tuple(names_of([getpass.getuser()]))
    except (ConfigError, OSError, KeyError, ImportError):
        return ()


def trainees_of(header: Mapping[str, str]) -> tuple[str, ...]:
    """Return the names of the trainees of a recording, none where it cannot be read."""
    try:
        trainees = json.loads(header.get(TRAINEES_KEY, "[]"))
    except (ValueError, RecursionError):
        return ()
    return tuple(trainees) if _are_texts(trainees) else ()


def exercise_of(header: Mapping[str, str]) -> str:
    """Return the name of a recording's exercise, "" for none; ConfigError."""
    return Path(_part(header, "options").get("exercise") or "").stem


def plan_of(header: Mapping[str, str], otherwise: Mapping[str, Any] = NO_CHANGES) -> Plan:
    """Return the plan of the run, from the texts of the recording alone.

    ``otherwise`` has options to be taken instead of the recorded; a vessel among them is read from
    its file of today. ConfigError if the header is of another form, or this version cannot read
    what the files say.
    """
    plan_options, texts = _part(header, "options"), _part(header, "texts")
    _check_options(plan_options)
    options = RunOptions(
        battery=ENDLESS_BATTERY if ENDLESS_KEY in header else "drained",
        **{name: plan_options[name] for name in PLAN_OPTIONS if name != "orders_file"},
        orders_file=plan_options["orders_file"] and Path(plan_options["orders_file"]),
        given=frozenset(plan_options["given"]) | otherwise.keys(),
    )
    with remembering() as today:
        if "vessel" in otherwise:
            load_vessel(otherwise["vessel"])
    with reading_recorded({**today, **texts}):
        return plan_run(replace(options, **otherwise))


def method_of(header: Mapping[str, str]) -> Method:
    """Return how the recorded boat was computed; ConfigError if the header does not say."""
    method = _part(header, "method")
    kinds = {field.name: str if field.name != "step" else int | float for field in fields(Method)}
    if method.keys() != kinds.keys() or not all(
        isinstance(method[name], kind) for name, kind in kinds.items()
    ):
        raise ConfigError(f"recording: method = {quote(method)}: is no method of this version")
    return Method(**method)


def layout_of(header: Mapping[str, str]) -> tuple[str, ...]:
    """Return the name of each number of a recorded state. ConfigError if it does not say."""
    return tuple(_part(header, "layout"))


def differences(header: Mapping[str, str], otherwise: Mapping[str, Any] = NO_CHANGES) -> list[str]:
    """Return a line for each difference that may change bits. No line: the same bits."""
    texts: list[str] = []
    for part in (_other_program(header), _other_texts(header), _other_plan(header, otherwise)):
        with collecting(texts):
            for text in part:
                texts.append(text)  # noqa: PERF402 (those before an error are kept)
    return list(dict.fromkeys(texts))


def notes(header: Mapping[str, str]) -> list[str]:
    """Return a line for each other difference, which should change no bit."""
    return [
        f"{name} {now}, recorded {header.get(name, 'none')}"
        for name, now in _surroundings().items()
        if header.get(name) != now
    ]


@cache
def _surroundings() -> Mapping[str, str]:
    """Return the versions and the machine that compute a run, beside the trainer's own."""
    from importlib import metadata  # noqa: PLC0415  who reads a header does without

    libraries = {name: metadata.version(name) for name in USED_LIBRARIES}
    machine = f"{platform.machine()} {platform.system()}"
    return {"python": platform.python_version(), **libraries, "machine": machine}


def _part(header: Mapping[str, str], name: str) -> Any:
    """Return a part of the header; ConfigError if it is missing or of another form."""
    if header.get("plan") != PLAN_FORMAT:
        form = quote(header.get("plan", "none"))
        raise ConfigError(f"recording: plan = {form}: this version reads plan {quote(PLAN_FORMAT)}")
    try:
        part = json.loads(header[name], parse_constant=no_constant)
    except (KeyError, ValueError, RecursionError):
        raise ConfigError(f"recording: its header has no readable {name}") from None
    if not HEADER_PARTS[name](part):
        raise ConfigError(f"recording: {name} = {quote(part)}: is of another form")
    return part


def _check_options(recorded: Mapping[str, Any]) -> None:
    """Raise ConfigError naming the first option that is missing or of the wrong type."""
    for name, kind in {**PLAN_OPTIONS, "given": list}.items():
        if name not in recorded:
            raise ConfigError(f"recording: its header has no option {name}")
        if not isinstance(recorded[name], kind) or isinstance(recorded[name], bool):
            wrong = quote(recorded[name])
            raise ConfigError(f"recording: option {name} = {wrong}: is of another kind")
        if isinstance(recorded[name], int | float) and not abs(recorded[name]) <= MAX_OPTION_NUMBER:
            wrong = quote(recorded[name])
            raise ConfigError(
                f"recording: option {name} = {wrong}: must be {MAX_OPTION_NUMBER:g} at most"
            )
    if not _are_texts(recorded["given"]):
        raise ConfigError(f"recording: option given = {quote(recorded['given'])}: must be names")


def _other_program(header: Mapping[str, str]) -> Iterator[str]:
    """Yield a line for each program or machine that is another than then."""
    if header.get("trainer") != __version__:
        yield f"trainer {__version__}, recorded {header.get('trainer', 'none')}"
    if not same_core(header.get("core")):
        yield f"core {core_digest()}, recorded {header.get('core', 'none')}: other equations"
    form = header.get("nomoto", "1")
    texts = _part(header, "texts").values()
    if form != NOMOTO_FORM and any(nomoto.NOMOTO_SCHEMA in text for text in texts):
        yield f"Nomoto ships of form {NOMOTO_FORM}, recorded {form}: they go by other steps"
    layout = layout_of(header)
    if layout != LAYOUT:
        new = [name for name in LAYOUT if name not in layout]
        gone = [name for name in layout if name not in LAYOUT]
        yield (
            f"state of {len(LAYOUT)} numbers, recorded {len(layout)}; "
            f"new: {_few(new)}; gone: {_few(gone)}"
        )


def _few(names: list[str]) -> str:
    more = f" and {len(names) - 5} more" if len(names) > 5 else ""
    return (", ".join(names[:5]) or "none") + more


def _other_texts(header: Mapping[str, str]) -> Iterator[str]:
    """Yield a line for each file whose text has changed since, or that is gone."""
    for key, was in _part(header, "texts").items():
        if key in ABANDONED_FILES or key.endswith(BASELINE_SUFFIX):
            continue
        try:
            now = read_as_kept(path_of(key), was)
        except ConfigError as wrong:
            yield f"{wrong}; it was read when this was recorded"
        else:
            if VISITORS_PATTERN.sub("", now) != VISITORS_PATTERN.sub("", was):
                yield from changes(key, now, was)


def _other_plan(header: Mapping[str, str], otherwise: Mapping[str, Any]) -> Iterator[str]:
    """Yield a line for each setting in which the wanted plan is not the recorded one."""
    plan = plan_of(header, otherwise)
    now = {**asdict(plan.method), "seed": plan.seed}
    was = {**asdict(method_of(header)), "seed": _part(header, "seed")}
    for name, value in now.items():
        if value != was[name]:
            yield f"{name} {_format_part(name, value)}, recorded {_format_part(name, was[name])}"
    key, vessel = key_of(plan.file.path), _part(header, "vessel")
    if "vessel" in otherwise and key != vessel:
        yield f"vessel {key}, recorded {vessel}"
        yield from changes(key, plan.file.text, _part(header, "texts").get(vessel, ""))


def _format_part(name: str, value: object) -> str:
    """Return a part of the method in words, a step with its unit."""
    return f"{value:g} s" if name == "step" else str(value)
