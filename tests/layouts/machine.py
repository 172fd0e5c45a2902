"""The machine: commands drawn by a seed, and what must hold after each of them.

Each command succeeds, or refuses with a clear line and exit code 2, without a traceback. What was
readable stays readable: a recording of another layout keeps its bytes, one of today's only grows,
and a copy has all that its source has. A refusal leaves every file as it was. What ``replay`` calls
damaged, ``resume`` calls damaged in the same words.
"""

import os
import random
import subprocess
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final, NamedTuple

from helpers.nursery import start_trainer

from layouts.recordings import KINDS, RELEASED, TRAINEE, Told, by_name, known, put_released, told
from trainer.io.recording.recording import RecordingError
from trainer.session.past.layout import LAYOUT

PATIENCE_S: Final = 120.0
CLASS: Final = 'exercise = "depth-changes"\nboats = 2\n'
JUMPS: Final = (
    *("backtrack 3", "restore a", "restore b", "reset", "branch 1", "branch 2", "again"),
    *("snapshot b", "replay 4", "take over", "step 2", "depth 70", "mark here"),
)
COMMANDS: Final = {
    "resume": "resume {file} --headless --speed max --duration {end}",
    "resume --anyway": "resume {file} --headless --speed max --duration {end} --anyway",
    "live": "resume {file} --speed max --anyway",
    "resume too short": "resume {file} --headless --speed max --duration 1 --anyway",
    "replay": "replay {file}",
    "replay --anyway": "replay {file} --anyway",
    "replay otherwise": "replay {file} --anyway --step 0.25",
    "debrief": "debrief {file} --html {out}.html",
    "debrief text": "debrief {file} --text",
    "reference": "debrief {file} --text --reference-from 5",
    "export": "export {file} --csv {out}.csv",
    "frames": "export {file} --mcap {out}.mcap",
    "list": "recordings {folder}",
    "forget": "recordings {folder} --forget",
    "class debrief": "class debrief {folder} --html {out}.html",
}
MAY_REFUSE: Final = {"resume", "replay", "resume too short", "forget"}  # a whole recording


class Given(NamedTuple):
    """A command that is given: its name, its words, and what is typed into it."""

    name: str
    words: tuple[str, ...]
    typed: str
    file: Path


class Ended(NamedTuple):
    """How a command ended."""

    code: int
    out: str
    err: str


@dataclass
class Play:
    """A seed as it is played, in a folder of a class."""

    folder: Path
    dice: random.Random
    whole: bool = True
    given: list[str] = field(default_factory=list)
    wrong: list[str] = field(default_factory=list)
    refused: int = 0

    def must(self, held: object, otherwise: str) -> None:
        """Note what is wrong unless it held."""
        if not held:
            self.wrong.append(f"{'; '.join(self.given)}: {otherwise}")


def play(seed: int, folder: Path) -> Play:
    """Play two or three commands over a recording, both drawn by a seed."""
    dice = random.Random(seed)  # noqa: S311 no secrets
    kinds, names = [*KINDS], [*RELEASED]
    name, kind = names[seed % len(names)], kinds[seed // len(names) % len(kinds)]
    (folder / "boat-1").mkdir()
    (folder / "class.toml").write_text(CLASS)
    path = folder / "boat-1" / "old.trainer"
    put_released(name, path)
    KINDS[kind].change(path, dice)
    played = Play(folder, dice, KINDS[kind].whole, [f"seed {seed}, {name} {kind}"])
    if not played.whole:
        check_damaged(played, path)
    for _ in range(dice.choice((2, 2, 3))):
        check_command(played, draw(played))
        if played.wrong:
            break
    return played


def draw(played: Play) -> Given:
    """Return a command over one of the recordings that are there."""
    dice = played.dice
    file = dice.choice(sorted(played.folder.glob("boat-1/*.trainer")))
    name = dice.choice([*COMMANDS, "live", "live", "resume --anyway"])
    typed = [line for _ in range(6) for line in (dice.choice(JUMPS), "step 3")]
    places: Mapping[str, object] = {
        "file": file,
        "folder": played.folder,
        "out": played.folder.parent / f"out-{len(played.given)}",
        "end": 100 * len(played.given),
    }
    words = [word.format(**places) for word in COMMANDS[name].split()]
    words += [TRAINEE] if name == "forget" else []
    lines = "\n".join([*typed, "freeze", "quit", "quit", ""]) if name == "live" else ""
    return Given(name, tuple(words), lines, file)


def carry_out(played: Play, given: Given) -> Ended:
    """Carry out a command; return how it ended."""
    own = {**os.environ, "XDG_STATE_HOME": str(played.folder.parent / "home")}
    pipe = subprocess.PIPE
    with start_trainer(*given.words, env=own, stdin=pipe, stdout=pipe, stderr=pipe) as process:
        out, err = process.communicate(given.typed, timeout=PATIENCE_S)
        return Ended(process.wait(), out, err)


def check_command(played: Play, given: Given) -> Ended:
    """Carry out a command, and look whether all laws hold after it."""
    typed = f" < {given.typed!r}" if given.typed else ""
    played.given.append(f"{' '.join(given.words)}{typed}")
    files, were = bytes_of(played.folder), readable(played.folder)
    ended = carry_out(played, given)
    now, are = bytes_of(played.folder), readable(played.folder)
    said = ended.err.strip()
    played.must("Traceback" not in ended.out + ended.err, said[-900:])
    played.must(ended.code in (0, 1, 2), f"ended with {ended.code}: {said[-300:]}")
    if ended.code == 2:
        played.refused += 1
        lines = said.splitlines()
        played.must(lines and lines[-1].startswith("trainer: "), f"no clear line: {said[-300:]}")
        changed = sorted(
            str(each) for each in files.keys() | now.keys() if files.get(each) != now.get(each)
        )
        played.must(files == now, f"refused, and has changed {changed}: {said[-200:]}")
        played.must(
            not played.whole or given.name in MAY_REFUSE, f"a whole one is refused: {said[-300:]}"
        )
    for path, was in were.items():
        if path not in are:
            played.must(False, f"{path.name} is not readable any more")  # noqa: FBT003
        else:
            for why in differences(was, are[path], forgotten=given.name == "forget"):
                played.must(False, f"{path.name}: {why}")  # noqa: FBT003
            other = was.layout != LAYOUT and given.name != "forget"
            log = path.with_name(f"{path.name}-wal")  # may be moved into the recording
            played.must(
                not other or log in files or files[path] == now[path],
                f"{path.name}, of another layout, has other bytes",
            )
    for path in are.keys() - were.keys():
        for why in lacking(were.get(given.file), are[path]):
            played.must(False, f"{path.name}: {why}")  # noqa: FBT003
    return ended


def check_damaged(played: Play, path: Path) -> None:
    """Look whether ``resume`` says what ``replay`` says of damage."""
    end = ("--headless", "--speed", "max", "--duration", "99", "--anyway")
    replayed = check_command(
        played, Given("replay --anyway", ("replay", str(path), "--anyway"), "", path)
    )
    if replayed.code == 2:
        resumed = check_command(
            played, Given("resume --anyway", ("resume", str(path), *end), "", path)
        )
        says, said = (each.err.splitlines()[-1:] for each in (resumed, replayed))
        played.must(says == said, f"resume says {says}, and replay {said}")


def bytes_of(folder: Path) -> dict[Path, bytes]:
    """Return what is in the recordings and beside them.

    Without what SQLite makes for readers: a judge of a session that has ended may still be one.
    """
    files = [path for path in folder.rglob("*") if path.is_file()]
    held = {path: path.read_bytes() for path in files if not path.name.endswith("-shm")}
    return {path: data for path, data in held.items() if data or not path.name.endswith("-wal")}


def readable(folder: Path) -> dict[Path, Told]:
    """Return what each recording tells that can be read."""
    found = {}
    for path in folder.glob("boat-1/*.trainer"):
        try:
            found[path] = told(path)
        except RecordingError:
            continue
    return found


def differences(was: Told, now: Told, *, forgotten: bool) -> Iterator[str]:
    """Yield what a recording no longer tells, or tells otherwise."""
    if {len(state) for states in now.states for state in states} != {8 * len(now.layout)}:
        yield "states of several sizes"
    if was.layout != now.layout:
        yield "another layout"
    if now.branches[: len(was.branches)] != was.branches:
        yield "other branches"
    for number, states in enumerate(was.states):
        if now.states[number][: len(states)] != states:
            yield f"other states of branch {number + 1}"
    for number, orders in enumerate(was.orders):
        if now.orders[number][: len(orders)] != orders and not forgotten:
            yield f"other orders of branch {number + 1}"
    if not {*was.snapshots} <= {*now.snapshots}:
        yield "a snapshot is lost"


def lacking(source: Told | None, copy: Told) -> Iterator[str]:
    """Yield what a copy lacks of its source."""
    if source is None:
        yield "is there, and nothing was readable"
        return
    names = known(source.layout)
    if copy.layout != LAYOUT:
        yield "not of today's layout"
        return
    carried = copy._replace(
        layout=tuple(names),
        states=tuple(tuple(by_name(LAYOUT, each, names)) for each in copy.states),
    )
    held = source._replace(
        layout=tuple(names),
        states=tuple(tuple(by_name(source.layout, each, names)) for each in source.states),
        snapshots=(),
    )
    yield from differences(held, carried, forgotten=False)
