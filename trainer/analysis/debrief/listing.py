"""``trainer recordings``: the list, the history of a trainee, and a name forgotten, as printed."""

import json
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import click

from trainer.analysis.debrief.forgetting import forget
from trainer.analysis.debrief.history import (
    LAST,
    Attempts,
    Listed,
    history,
    listed,
    of_trainee,
    recordings_in,
)
from trainer.io.lines import plain
from trainer.io.paths import recordings_folder


def found_in(places: Sequence[Path]) -> list[Path]:
    """Return the recordings in places, or in the recordings' folder, the newest first."""
    folder = recordings_folder()
    return list(recordings_in(places or ([folder] if folder.is_dir() else [])))


def print_list(places: Sequence[Path], *, as_json: bool) -> None:
    """Print the recordings, each as soon as it is known."""
    found = found_in(places)
    if as_json:
        click.echo(json.dumps(as_figures(map(listed, found)), indent=1))
        return
    if not found:
        where = ", ".join(map(str, places)) or recordings_folder()
        click.echo(f"no recording is in {where}: trainer run EXERCISE makes one")
    for line in list_lines(map(listed, found)):
        click.echo(plain(line))


def print_history(places: Sequence[Path], name: str, *, as_json: bool) -> None:
    """Print what a trainee has done; ConfigError if there is nothing of that name."""
    own = history(of_trainee(list(map(listed, found_in(places))), name))
    if as_json:
        click.echo(json.dumps(history_figures(own), indent=1))
        return
    click.echo("\n".join(map(plain, history_lines(own))))


def print_forgotten(places: Sequence[Path], name: str) -> None:
    """Remove a name and print where; ConfigError if it is nowhere, or cannot be removed."""
    for line in forget(name, found_in(places)):
        click.echo(line)


def list_lines(found: Iterable[Listed]) -> Iterator[str]:
    """Yield a line for each recording: when, what, who, and what it came to."""
    for each in found:
        if each.came is None:
            yield f"{_day(each.started):16}  {each.path.name}: cannot be read: {each.trouble}"
            continue
        came = each.came
        star = "*" if came.changed else ""
        free = "" if came.counts else " (practice or free)"
        names = ", ".join(each.trainees) or "-"
        outcome = came.outcome or "-"
        yield (
            f"{_day(each.started):16}  {came.exercise or '-':26}  {outcome:11}  "
            f"{_mark(came.total):>4}{star:1}  {names}  {each.path.name}{free}"
        )


def history_lines(found: Iterable[Attempts]) -> Iterator[str]:
    """Yield the history of a trainee, a line for each exercise."""
    yield f"{'exercise':28}  {'width':9}  mean of last {LAST}  attempts  seeds"
    for each in found:
        seeds = ", ".join(map(str, each.seeds))
        yield (
            f"{each.exercise:28}  {each.width:9}  {_mark(each.mean):>14}  "
            f"{each.attempts:8}  {seeds}"
        )


def as_figures(found: Iterable[Listed]) -> list[dict[str, Any]]:
    """Return recordings for programs."""
    return [
        {
            "file": str(each.path),
            "started": each.started,
            "trainees": list(each.trainees),
            "trouble": each.trouble,
            **(asdict(each.came) if each.came else {}),
        }
        for each in found
    ]


def history_figures(found: Iterable[Attempts]) -> list[dict[str, Any]]:
    """Return a trainee's history for programs."""
    return [asdict(each) | {"mean_of_last": each.mean} for each in found]


def _day(started: str) -> str:
    return started[:16].replace("T", " ")


def _mark(total: float | None) -> str:
    return "-" if total is None else f"{total:.0f}"
