"""The instructor's changes of marks, each with a reason. The old marks stay beside them.

``page`` makes them for ``trainer debrief``, and ``data`` judges by them. Changes are kept beside
the recording: drill.changes.toml beside drill.trainer. The recording itself stays as it was flown.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Final

from trainer.config.exercise.outcome import Outcome
from trainer.config.files import (
    ConfigError,
    Position,
    nearest,
    parse_toml,
    quote,
    text_if_there,
    toml_value,
)
from trainer.config.schema import Choice, Quantity, Rows, Text, read_record, required, within
from trainer.debrief.marks.judgement import WIDTH_FACTORS, judge_run, total_of
from trainer.debrief.marks.mark_numbers import LOST_CAP
from trainer.debrief.marks.scoring import Scorecard
from trainer.debrief.passage.trajectory import Trajectory
from trainer.io.outputs import renew_whole
from trainer.session.past.plan import Plan

CHANGES_SCHEMA: Final = "changes/1"
CHANGES_SUFFIX: Final = ".changes.toml"  # ends the name of the file
OUTCOME_NAME, WIDTH_NAME = "outcome", "width"  # what is changed beside a score
KNOWN_OUTCOMES: Final = (Outcome.WON, Outcome.LOST, Outcome.NOT_REACHED)
STRIKE_WORD, WEIGHT_WORD = "strike", "weight"
WEIGHT_FIELD: Final = Quantity("-", within(0, 1000), "in the total")
CHANGE_FORM: Final = 'say it as "NAME: WHAT, REASON", such as "{}: weight 0, the gauge was wrong"'


@dataclass(frozen=True, kw_only=True)
class Change:
    """One change of the instructor's."""

    branch: float = required(Quantity("-", within(1, 1e9), "of the recording"))
    name: str = required(Text(60, "the score; or outcome, width"))
    what: str = required(Text(40, "weight and a number, strike, an outcome, a width"))
    reason: str = required(Text(300, "why"))
    at: str = required(Text(40, "when it was made, UTC"))

    def __str__(self) -> str:
        """Return the change in the words of the page."""
        return f"{self.name}: {self.what} ({self.reason})"


@dataclass(frozen=True, kw_only=True)
class ChangesHead:
    """The head of the file of changes."""

    schema: str = required(Choice((CHANGES_SCHEMA,), "form of the file"))


CHANGE_ROWS: Final = Rows(Change, (), 0, 1000, "what was changed")


def changes_path(recording: Path) -> Path:
    """Return where the changes of a recording are kept: beside it."""
    return recording.with_name(f"{recording.stem}{CHANGES_SUFFIX}")


def read_changes(recording: Path) -> tuple[Change, ...]:
    """Return the changes kept beside a recording; ConfigError if they cannot be read."""
    path = changes_path(recording)
    text = text_if_there(path)
    if text is None:
        return ()
    table, position = parse_toml(text, path.name), Position(path.name, "")
    rows = table.pop("changes", [])
    read_record(ChangesHead, table, position, ())
    changes: tuple[Change, ...] = CHANGE_ROWS.read("changes", rows, position)
    for change in changes:
        _what(change.name, change.what, f"{path.name}: {change.name}: {change.what}")
    return changes


def write_changes(recording: Path, changes: Sequence[Change]) -> None:
    """Write the changes beside a recording, whole or not at all. Without changes the file goes."""
    path = changes_path(recording)
    try:
        if changes:
            renew_whole(path, text_of(changes))
        else:
            path.unlink(missing_ok=True)
    except OSError as error:
        raise ConfigError(f"{path} cannot be written: {error.strerror}") from None


def text_of(changes: Iterable[Change]) -> str:
    """Return the text that reads back as these changes."""
    lines = [
        "# Marks changed by the instructor: trainer debrief --change",
        f'schema = "{CHANGES_SCHEMA}"',
    ]
    for change in changes:
        lines += ["", "[[changes]]", f"branch = {int(change.branch)}"]
        for key in ("name", "what", "reason", "at"):
            lines.append(f"{key} = {toml_value(getattr(change, key))}")
    return "\n".join(lines) + "\n"


def change_of(text: str, branch: int, plan: Plan) -> Change:
    """Return the change in a text such as NAME: WHAT, REASON; ConfigError with that form."""
    names = names_of(plan)
    name, rest = _named(text, names)
    what, _, reason = (part.strip() for part in rest.partition(","))
    if not (what and reason):
        raise ConfigError(f"--change {quote(text)}: {CHANGE_FORM.format(name)}: a reason is needed")
    fields = {
        "branch": branch,
        "name": name,
        "what": _what(name, " ".join(what.split()), f"--change {quote(text)}"),
        "reason": reason,
        "at": datetime.now(UTC).isoformat(timespec="seconds"),
    }
    return read_record(Change, fields, Position("--change", ""), ())


def names_of(plan: Plan) -> tuple[str, ...]:
    """Return the names that an instructor can change; ConfigError if there are no marks."""
    if not plan.scores:
        raise ConfigError(
            "--change: this run has no scoring rules, so there are no marks to change"
        )
    names = tuple(rule.score.name for rule in plan.scores)
    return (*names, OUTCOME_NAME, WIDTH_NAME) if plan.judged_by_tasks else (*names, WIDTH_NAME)


def _named(text: str, names: tuple[str, ...]) -> tuple[str, str]:
    """Return the name that a text begins with, and what follows; ConfigError naming the nearest."""
    folded = text.strip().casefold()
    for name in sorted(names, key=len, reverse=True):
        if folded.startswith(f"{name.casefold()}:"):
            return name, text.strip()[len(name) + 1 :]
    given_name, colon, _ = text.partition(":")
    if not colon:
        raise ConfigError(f"--change {quote(text)}: {CHANGE_FORM.format(names[0])}")
    raise ConfigError(_unknown("--change", given_name.strip(), names))


def _unknown(option: str, given: str, names: tuple[str, ...]) -> str:
    known_names = ", ".join(names)
    near = nearest(given, names)
    return f"{option} {quote(given)}: nothing of that name{near}; there are: {known_names}"


def _what(name: str, what: str, where: str) -> str:
    """Return the new value as the file has it; ConfigError with the values allowed."""
    known = {OUTCOME_NAME: KNOWN_OUTCOMES, WIDTH_NAME: tuple(WIDTH_FACTORS)}.get(name)
    if known is not None:
        if what.lower() not in known:
            hint = f"{nearest(what, known)}; say {', '.join(known)}"
            raise ConfigError(f"{where}: no {name} {quote(what)}{hint}")
        return what.lower()
    if what.lower() == STRIKE_WORD:
        return STRIKE_WORD
    word, _, number = what.lower().partition(" ")
    try:
        weight = WEIGHT_FIELD.read(WEIGHT_WORD, float(number), Position("", ""))
    except ValueError:  # a ConfigError is one
        hint = f'say "weight" and a number of 0 to 1000, or "{STRIKE_WORD}"'
        raise ConfigError(f"{where}: {quote(what)}: {hint}") from None
    if word != WEIGHT_WORD:
        raise ConfigError(f"{where}: {quote(what)}: say weight, or {STRIKE_WORD}")
    return f"{WEIGHT_WORD} {weight:g}"


def without_changes(changes: Sequence[Change], name: str, branch: int) -> tuple[Change, ...]:
    """Return the changes without a name's, or without all, in a branch; ConfigError if none."""
    here = [each for each in changes if each.branch == branch]
    names = tuple(dict.fromkeys(each.name for each in here))
    if not names:
        raise ConfigError(f"--change-back {quote(name)}: nothing has been changed in this run")
    wanted = name.strip().casefold()
    if wanted != "all" and wanted not in {each.casefold() for each in names}:
        raise ConfigError(_unknown("--change-back", name, (*names, "all")))
    return tuple(
        change
        for change in changes
        if change.branch != branch or wanted not in ("all", change.name.casefold())
    )


def changed_card(
    trajectory: Trajectory,
    plan: Plan,
    nobody: Mapping[str, Mapping[str, float]],
    width: str,
    changes: Sequence[Change],
) -> Scorecard:
    """Return the marks as changed; ``nobody`` has those with nobody aboard, by width and name."""
    words = {each.name: each.what for each in changes}  # the last of a name counts
    width = words.get(WIDTH_NAME, width)
    scores = []
    for rule in plan.scores:
        what = words.get(rule.score.name, f"{WEIGHT_WORD} {rule.weight!r}")
        weight = 0.0 if what == STRIKE_WORD else float(what.partition(" ")[2])
        if weight > 0.0:
            scores.append(replace(rule, score=replace(rule.score, weight=weight)))
    card = judge_run(trajectory, replace(plan, scores=tuple(scores)), nobody[width], width)
    return with_outcome(card, Outcome(words[OUTCOME_NAME])) if OUTCOME_NAME in words else card


def with_outcome(card: Scorecard, outcome: Outcome) -> Scorecard:
    """Return a card with another outcome, its total capped as that outcome allows."""
    verdict = card.verdict
    if verdict is None:
        return card
    caps = {Outcome.LOST: LOST_CAP, Outcome.NOT_REACHED: verdict.gate_cap}
    cap, reason = caps.get(outcome), "" if outcome is Outcome.WON else verdict.reason
    verdict = replace(verdict, outcome=outcome, reason=reason, cap=cap, void=False, free=False)
    return replace(card, total=total_of(verdict), verdict=verdict)
