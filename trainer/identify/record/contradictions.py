"""What a record's own channels contradict, and what would mend it."""

import shlex
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final, NamedTuple

import numpy as np

from trainer.config.files import ConfigError, quote
from trainer.identify.record.columns import GuessedColumns
from trainer.identify.record.evidence import (
    CHANNEL_QUANTITIES,
    COMMON_UNITS,
    FAR_OUT,
    TURNED_SIGN,
    Change,
    Course,
    Ratio,
    compare_channels,
    explain,
)
from trainer.identify.record.findings import find_strange_rate
from trainer.identify.record.measurements import Finding, Record
from trainer.identify.record.motion_laws import Signal
from trainer.identify.record.sources import MAX_INTERVAL_S, Column, load_record
from trainer.io.paths import RECORDING_SUFFIX

ANYWAY_TEXT: Final = "--anyway takes it as it is"
MOST_WAYS: Final = 4  # that are named, and changes that are made
Say = Callable[[Change], str]  # how a user says a change


class Contradiction(NamedTuple):
    """What channels say against units and signs as they were taken."""

    faults: str
    ways: Sequence[tuple[Change, ...]]  # the fewest changes that mend all, each of them
    refused: bool

    def text(self, say: Say) -> str:
        """Return the faults, and how to say each change that mends them."""
        ways = list[str]()
        for way in self.ways[:MOST_WAYS]:
            units = [change.unit for change in way if change.unit != TURNED_SIGN]
            agreed = f"in {' and '.join(units)} all agrees: " if units else ""
            ways.append(agreed + " and ".join(say(change) for change in way))
        return f"{self.faults}: {', or '.join(ways) or 'no one change of unit or sign mends it'}"


def compare_record(record: Record, vessel: Course) -> tuple[Ratio, ...]:
    """Return what a record's channels say of each other; nothing of an exact recording."""
    if Path(record.source).suffix == RECORDING_SUFFIX or record.interval > MAX_INTERVAL_S:
        return ()
    known = {name: np.isfinite(values) for name, values in record.values.items()}
    channels = {
        name: Signal(record.t[known[name]], record.values[name][known[name]])
        for name in (*CHANNEL_QUANTITIES, "latitude", "longitude", "roll", "pitch_rate")
        if name in known and np.count_nonzero(known[name]) > 1
    }
    return tuple(compare_channels(channels, vessel, record.units))


def find_contradiction(ratios: Sequence[Ratio], units: Mapping[str, str]) -> Contradiction | None:
    """Return what disagrees; refused where one change explains it, or where it is far out."""
    wrong = [ratio for ratio in ratios if not ratio.agrees()]
    if not wrong:
        return None
    ways = explain(ratios, units)
    far = any(
        ratio.beyond > FAR_OUT or (ratio.sign_fault and ratio.found <= 0.0) for ratio in wrong
    )
    plain = bool(ways) and len(ways[0]) == 1 and not all(ratio.doubtful for ratio in wrong)
    faults = ", ".join(dict.fromkeys(ratio.fault for ratio in wrong))
    return Contradiction(faults, ways, plain or far)


def check_evidence(record: Record, vessel: Course, say: Say, *, anyway: bool) -> Record:
    """Return the record with its evidence, and what it contradicts told if ``anyway``.

    ConfigError with what it contradicts, and how to say what mends it.
    """
    return _judge(record, compare_record(record, vessel), say, anyway=anyway)


def _judge(record: Record, ratios: tuple[Ratio, ...], say: Say, *, anyway: bool) -> Record:
    found = find_contradiction(ratios, record.units)
    strange = () if found and found.refused else find_strange_rate(record)
    refused = [str(one) for one in strange] if record.units else []
    told = [] if found is None else [found.text(say)]
    if found and found.refused:
        refused, told = told, []
    if refused and not anyway:
        raise ConfigError(f"{record.source}: {refused[0]}; {ANYWAY_TEXT}")
    findings = [record.finding("t", f"taken as it is: {text}") for text in (*told, *refused)]
    return replace(record, evidence=ratios, findings=(*record.findings, *findings))


def in_study(record: Record, positive_rudder: str) -> Say:
    """Return how a change is said in a study or a ship's file."""
    other = "starboard" if positive_rudder == "port" else "port"

    def say(change: Change) -> str:
        if change.channel == "rudder" and change.unit == TURNED_SIGN:
            return f'say positive_rudder = "{other}"'
        key = f"unit = {quote(change.unit)}"
        if change.unit == TURNED_SIGN:
            east = ", of one from east offset = 90 too" if change.channel == "heading" else ""
            key = f"scale = -1{east}"
        return f"say {key} in its [[columns]] of {record.name(change.channel)}"

    return say


@dataclass(frozen=True)
class Settled:
    """A file's columns after its channels were compared, and its record."""

    columns: GuessedColumns
    record: Record
    sign: str  # line of a file that says a rudder positive to starboard, or ""
    anyway: str  # likewise that contradictions are taken


def settle_columns(
    data: Path, guess: GuessedColumns, vessel: Course, *, anyway: bool = False
) -> Settled:
    """Return the columns of a file, guesses set right by what channels say.

    A change of a guessed unit, or of the rudder's sign, is made and told if it alone mends all.
    ConfigError with what else its channels contradict, unless ``anyway``.
    """
    columns, made, sign = dict(guess.columns), list[str](), ""
    while True:
        record = load_record(data, columns)
        if sign:
            record = replace(record, rudder=-record.column("rudder"))
        ratios = compare_record(record, vessel)
        if not sign and (evidence := _wrong_rudder(ratios)):
            sign = f'positive_rudder = "starboard"  # guessed: {evidence} say so\n'
            continue
        found = find_contradiction(ratios, record.units)
        way = _plain_way(found, guess.unsure) if found and len(made) < MOST_WAYS else ()
        if not found or not way:
            break
        for channel, unit in way:
            columns[channel] = replace(columns[channel], unit=unit)
            made.append(f"{columns[channel].name}: read in {unit}: else {found.faults}")
    findings = (*record.findings, *(Finding(data.name, 0, text) for text in made))
    record = replace(record, findings=findings)
    judged = _judge(record, ratios, _by_option(columns), anyway=anyway)
    taken = 'anyway = "yes"\n' if anyway and len(judged.findings) > len(findings) else ""
    return Settled(replace(guess, columns=columns), judged, sign, taken)


def _wrong_rudder(ratios: Sequence[Ratio]) -> str:
    """Return the evidence of a rudder positive to starboard, "" if there is none.

    A heading that goes anticlockwise looks alike, unless a rate or a track stands beside it.
    """
    wrong = [one for one in ratios if one.found <= 0.0 and "rudder" in one.signed]
    others = [one for one in ratios if one not in wrong and one.found <= 0.0 and one.sign_fault]
    return wrong[0].evidence if wrong and not others else ""


def _plain_way(found: Contradiction, unsure: Collection[str]) -> tuple[Change, ...]:
    """Return the one change of guessed units that may be made without asking, () if none."""
    plain = [
        way
        for way in found.ways
        if all(one.channel in unsure and one.unit in COMMON_UNITS for one in way)
    ]
    plain = [way for way in plain if all(one.channel != "heading" for one in way)] or plain
    return plain[0] if len(plain) == 1 else ()  # a heading's unit is told by its size


def _by_option(columns: Mapping[str, Column]) -> Say:
    """Return how a change is said to the command that writes a study."""

    def say(change: Change) -> str:
        one = columns.get(change.channel)
        if one is None:
            return f"turn the sign of {change.channel}"
        return f"say {option_of('--column', change, one)}"

    return say


def option_of(option: str, change: Change, one: Column) -> str:
    """Return the option that reads a column otherwise."""
    unit = one.unit if change.unit == TURNED_SIGN else change.unit
    text = f"{option} {change.channel}={shlex.quote(one.name)}:{unit}"
    if change.unit != TURNED_SIGN:
        return text
    scale = -1.0 if one.scale is None else -one.scale
    east = " (*-1+90 of one from east)" if change.channel == "heading" and unit == "deg" else ""
    offset = f"{-one.offset:+g}" if one.offset else ""
    return f"{text}*{scale:g}{offset}{east}"
