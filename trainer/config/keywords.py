"""The keywords of the Python face: what each call takes, with unit, limits and meaning.

The command line makes its options of the same tables (``cli.options.kind_option``), so that a call
and a command accept the same and explain it alike. ``reading_keywords`` checks a call's.
"""

import os
from collections.abc import Iterable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, Final, TypeVar

from trainer.config.files import ConfigError, Position, is_path, offer_known
from trainer.config.schema import (
    Choice,
    Choices,
    Flag,
    KeyForm,
    Kind,
    Quantity,
    Text,
    WholeNumber,
    above,
    within,
)
from trainer.config.ship.fit_options import FIT_KINDS
from trainer.config.words import BATTERY_KINDS, EQUATION_SETS, LINEAR_MODELS, TRIGONOMETRY_KINDS
from trainer.io.outputs import FILE_KINDS, SameFileError, note_input, promising

Record = TypeVar("Record")


@dataclass(frozen=True)
class InputFile:
    """The path of a file that is read; Tab offers those with some endings."""

    endings: tuple[str, ...]
    meaning: str

    @property
    def form(self) -> KeyForm:
        """Return unit, range and meaning, and the JSON Schema of its values."""
        return KeyForm("path", ", ".join(self.endings), self.meaning, {"type": "string"})

    def read(self, key: str, value: object, position: Position) -> Path:
        """Return the path, noted as an input; ConfigError if an output is to replace it."""
        path = Path(_text_of(key, value, position))
        try:
            note_input(path)
        except SameFileError as lost:
            raise ConfigError(position.problem(f"{key}: {lost}")) from None
        return path


@dataclass(frozen=True)
class OutputFile(InputFile):
    """The path of a file that is written, of the kind that some endings have."""

    def read(self, key: str, value: object, position: Position) -> Path:
        """Return the path; ConfigError if it is that of another kind, or in no folder."""
        path = Path(_text_of(key, value, position))
        try:
            refuse_output(path, self.endings)
        except ConfigError as wrong:
            raise ConfigError(position.problem(f"{key}: {wrong}")) from None
        return path


@dataclass(frozen=True)
class ShippedName(InputFile):
    """The name of a shipped file of some kinds (``endings``), or a path."""

    def read(self, key: str, value: object, position: Position) -> str:  # type: ignore[override]
        """Return the name; a path is noted as an input."""
        name = _text_of(key, value, position)
        return str(super().read(key, name, position)) if is_path(name) else name


@dataclass(frozen=True)
class Several:
    """One or more values of a kind."""

    each: Kind

    @property
    def form(self) -> KeyForm:
        """Return unit, range and meaning, and the JSON Schema of its values."""
        return self.each.form

    def read(self, key: str, value: object, position: Position) -> tuple[object, ...]:
        """Return the values, also where one is given alone; ConfigError for the first wrong."""
        listed = value if isinstance(value, Iterable) and not isinstance(value, str) else [value]
        return tuple(self.each.read(key, _as_pythons(self.each, one), position) for one in listed)


def _text_of(key: str, value: object, position: Position) -> str:
    """Return a name or path as text; ConfigError if it is none."""
    if not isinstance(value, str | os.PathLike):
        raise ConfigError(position.wrong(key, value, "must be a name or a path"))
    return os.fsdecode(value)


def refuse_output(path: Path, endings: tuple[str, ...], more: str = "") -> None:
    """Raise ConfigError for an output with another kind's ending, or where no folder is.

    ``more`` ends the hint at another name.
    """
    ending = path.suffix.lower()
    if ending in FILE_KINDS and ending not in endings:
        such = f", such as {path.with_suffix(endings[0])}" if endings else ""
        raise ConfigError(
            f"{path}: {ending} is the ending of {FILE_KINDS[ending]}, and this is not one: "
            f"give another name{such}{more}"
        )
    if endings and not path.parent.is_dir():
        raise ConfigError(f"{path}: there is no folder {path.parent}")


def _as_pythons(kind: Kind, value: Any) -> Any:
    """Return a value of numpy, or one that is near a kind's, as the kind reads it."""
    value = value.item() if getattr(value, "size", 0) == 1 else value
    if isinstance(kind, Choices):
        return [value] if isinstance(value, str) else [*value]
    return str(value) if isinstance(kind, Choice) and type(value) is int else value  # model=1


@contextmanager
def reading_keywords(
    call: str, kinds: Mapping[str, Kind], keywords: Mapping[str, Any]
) -> Iterator[dict[str, Any]]:
    """Yield what was given to a call, read by kind.

    One with None counts as not given. It is a block, inside which its outputs are promised.
    ConfigError if one is wrong or unknown.
    """
    for name in keywords:
        if name not in kinds:
            raise ConfigError(f"no keyword {name!r}{offer_known(name, sorted(kinds))}")
    asked: dict[str, Any] = {
        name: kinds[name].read(name, _as_pythons(kinds[name], value), Position(call, ""))
        for name, value in keywords.items()
        if value is not None
    }
    with ExitStack() as promises:
        for name, path in asked.items():
            if isinstance(kinds[name], OutputFile):
                try:
                    promises.enter_context(promising(path, f"{name}="))
                except SameFileError as lost:
                    raise ConfigError(f"{call}: {name}: {lost}") from None
        yield asked


def fill_record(kind: type[Record], values: Mapping[str, Any], **further: Any) -> Record:
    """Return a record filled from options of the same names, and from ``further``."""
    names = [item.name for item in fields(kind)]  # type: ignore[arg-type]
    return kind(**{name: values[name] for name in names if name in values}, **further)


TRIAL_ENDINGS: Final = ".trainer", ".csv"
RECORD_ENDINGS: Final = (".toml", *TRIAL_ENDINGS)
RATE_KINDS: Final = ("exact", "lagged")
STEP_LIMITS: Final = 0.001, 2.0  # [s] of steps that are accepted
_ANGLE: Final = within(0, 90)  # [deg]
_DURATION: Final = within(1, 1e5)  # [s]
_AHEAD: Final = above(0, 60)  # [kn]
_METHOD: Final[Mapping[str, Kind]] = {
    "equations": Choice(
        EQUATION_SETS, "full set (1)-(7), compact modified or basic, or the vertical plane alone"
    ),
    "rates": Choice(
        RATE_KINDS,
        "accelerations by the 6x6 solve, or each from its own equation with last cycle's",
    ),
    "trig": Choice(TRIGONOMETRY_KINDS, "exact, or the 1969 approximations of the compact sets"),
    "integrator": Text(
        200,
        "euler, adams2 to adams4, best2, heun, abm2 to abm4, hamming4, o30c31, bdf2, bdf3, "
        "rk2 to rk4, rkv, or a multistep method as 'a=1;b=1.5,-0.5'",
    ),
    "sea": ShippedName(("seas",), "calm, sea-state-1 to sea-state-6, or a file"),
    "seed": WholeNumber(0, 2**53 - 1, "seed of all random numbers"),
    "vessel": ShippedName(("vessels",), "bb2, sdv-mk9, remus100, or the path of a vessel file"),
}
RUN_KEYWORDS: Final[Mapping[str, Kind]] = {
    **_METHOD,
    "exercise": ShippedName(("lessons", "exercises"), "name or path of an exercise"),
    "step": Quantity("s", within(*STEP_LIMITS), "step in s"),
    "unsafe_step": Flag("run even where the step is not stable"),
    "battery": Choice(BATTERY_KINDS, "whether the boat's battery is drained, or never goes flat"),
    "orders": InputFile((".txt",), "scheduled orders, a line each: SECONDS ORDER"),
    "record": OutputFile(
        (".trainer",), "keep the whole run in this file, or in a new one in this folder"
    ),
}
MANOEUVRE_KEYWORDS: Final[Mapping[str, Kind]] = {
    **_METHOD,
    "speed": Quantity("kn", _AHEAD, "at the start"),
    "angle": Quantity("deg", _ANGLE, "of the control"),
    "side": Choice(("starboard", "port"), "where a turn goes, or a zig-zag or spiral goes first"),
    "direction": Choice(("rise", "dive"), "way of the planes, or their first"),
    "planes": Quantity("deg", _ANGLE, "of a climbing turn"),
    "execute": Quantity("deg", within(0, 180), "mark"),
    "duration": Quantity("s", _DURATION, "of the manoeuvre"),
    "step_speed": Quantity("kn", within(0.1, 60), "at most, of each step of an acceleration"),
    "step_time": Quantity("s", _DURATION, "of each step"),
    "ahead_speed": Quantity("kn", _AHEAD, "the last that an acceleration orders"),
    "ahead_time": Quantity("s", _DURATION, "until an utmost acceleration stops"),
    "depth": Quantity("m", within(0, 12000), "to begin at"),
    "step": Quantity("s", within(1e-3, 10), "from state to state"),
    "controls": Choice(
        ("own", "once"), "the boat's own rates, lags and dead times, or none, as in 1969"
    ),
    "trim": Choice(("own", "full"), "start in the trim of the equations flown, or of the full set"),
    "law": Choice(
        ("trainer", "report", "literal"), "of depth keeping, as the order autopilot has them"
    ),
}
# fmt: off
_STUDY_NAMES: Final = (
    "model", "length", "noise", "method", "reject", "between_readings", "every", "begin", "end",
)
# fmt: on
SWEEP_KEYWORDS: Final[Mapping[str, Kind]] = {
    "study": ShippedName(("studies",), "name or path of a study"),
    "out": OutputFile((".parquet",), "Parquet file of the result"),
    "members": WholeNumber(1, 10**9, "how many"),
    "jobs": WholeNumber(1, 256, "processes"),
    "scheduler": Text(
        200, "fly on the workers of this Dask scheduler, such as tcp://10.0.0.1:8786"
    ),
}
IDENTIFY_KEYWORDS: Final[Mapping[str, Kind]] = {
    "record": InputFile(RECORD_ENDINGS, "a study, a recording or a CSV file"),
    **{name: kind for name, kind in FIT_KINDS.items() if name in _STUDY_NAMES},
    "at": FIT_KINDS["speed"],
    "output": FIT_KINDS["outputs"],
    "vessel": _METHOD["vessel"],
    "exact": Flag("add no sensor noise to a recording's exact state"),
    "system": InputFile((".toml", ".py"), "your own: matrices, or a program"),
    "simulate": Flag("estimate nothing: the model as it starts"),
    "anyway": Flag("even if the record contradicts itself"),
    "data_only": Flag("show and plot the record alone"),
    "against": Choice(LINEAR_MODELS, "test it against a simpler model"),
    "without": Several(Text(200, "test it without this parameter")),
    "check": InputFile(RECORD_ENDINGS, "another record to predict, as a test"),
    "kappa": InputFile(RECORD_ENDINGS, "a record of large manoeuvres, for kappa"),
    "bech": InputFile(RECORD_ENDINGS, "the same, for Bech's H(r), three terms"),
    "spiral": InputFile((".toml", ".csv"), "steady turns, for H(r); times not read"),
    "joint": Flag("K, T1, T2, T3 too from both records, with the curve"),
    "matrices": Flag("show the system and covariance matrices"),
}
RECORDS_KEYWORDS: Final[Mapping[str, Kind]] = {  # of what wrote a boat's records
    "records": Several(InputFile(TRIAL_ENDINGS, "recordings or CSV files")),
    "columns": Several(Text(500, "where a channel is, such as --columns depth=Keel:m; repeatable")),
    "bias": Several(
        Text(200, "what may be off: weight [-], trim [m], pitch or roll [deg], log [-]; repeatable")
    ),
    "gauge_x": Quantity("m", within(-1000, 1000), "depth gauge, ahead of the origin"),
    "late": Quantity("s", within(-1000, 1000), "surfaces are logged late by this"),
    "still": Several(
        Choice(("rudder", "stern", "bow"), "a surface without a column stood at zero")
    ),
    "coarse": Flag("take readings too rare; bands then hold less"),
    "anyway": Flag("even if signs are wrong, or a fit is not settled"),
    "html": OutputFile((".html",), "write one HTML page"),
}
FIT_BOAT_KEYWORDS: Final[Mapping[str, Kind]] = {
    **RECORDS_KEYWORDS,
    "prior": ShippedName(("vessels",), "the boat before: an estimate"),
    "output": OutputFile((".toml",), "write the fitted boat so"),
    "hold_out": Several(
        InputFile(TRIAL_ENDINGS, "a record to foretell, not to fit; may be repeated")
    ),
    "draws": WholeNumber(0, 2000, "of the coefficients, for the bands"),
}
WATCH_BOAT_KEYWORDS: Final[Mapping[str, Kind]] = {
    **RECORDS_KEYWORDS,
    "fitted": ShippedName(("vessels",), "the file of a boat that was fitted"),
}
