"""``python -m tests.mutation`` draws faults of one place, and counts what finds them."""

import concurrent.futures
import contextlib
import functools
import json as js
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import asdict
from datetime import UTC, datetime
from pathlib import Path
from queue import SimpleQueue
from typing import Final

import click

sys.path.insert(0, str(Path(__file__).parents[1]))  # packages of tests/ go by their own names

from helpers.progress import Bar

from mutation.places import Place
from mutation.table import in_words
from mutation.trials import Copy, Drawn, NotGreenError, Trial, attempt, copied_tree, draw
from trainer.cli.main import run_command

DAYS: Final = ("monday", "tuesday", "wednesday", "thursday", "friday", "saturday", "sunday")
MAX_UNFOUND: Final = 0.5  # [-] of the faults; above, it is red


@click.command()
@click.option("--mutants", type=click.IntRange(1), default=100, show_default=True, metavar="N")
@click.option("--seed", default="", help="Of the draw. [default: the day's]")
@click.option(
    "--seeds", type=click.IntRange(1), default=20, show_default=True, help="Whole sessions, each."
)
@click.option(
    "--seconds",
    type=click.FloatRange(1.0),
    default=3.0,
    show_default=True,
    help="That a process of theirs lives, at most.",
)
@click.option("--minutes", type=click.FloatRange(0.1), help="Begin no more of them afterwards.")
@click.option("--jobs", type=click.IntRange(1, 64), default=1, show_default=True, help="At a time.")
@click.option("--on", type=click.Choice(DAYS), help="Do nothing on other days.")
@click.option("--near", is_flag=True, help="Ask the tests alone that import its module.")
@click.option("--json", "json", is_flag=True, help="Print the findings as JSON.")
def mutation(
    *,
    mutants: int,
    seed: str,
    seeds: int,
    seconds: float,
    minutes: float | None,
    jobs: int,
    on: str | None,
    near: bool,
    json: bool,
) -> None:
    """Make faults of one place in session, io and boat, and see what finds them.

    Each is made in a copy of the tree. Whole sessions of some seeds look for it, then the quick
    tests of its room, or those of them that import its module.

    \b
    Example:  python -m tests.mutation --mutants 30 --seed 1
              python -m tests.mutation --mutants 2 --json

    Exit codes: 0 all was tried, 1 too many are found by nothing, 2 the tree itself is not green.
    """
    now = datetime.now(UTC)
    if on and DAYS[now.weekday()] != on:
        click.echo(f"not today: on {on.capitalize()}")
        return
    with contextlib.ExitStack() as stack:
        copies = [stack.enter_context(copied_tree()) for _ in range(jobs)]
        try:
            drawn = draw(copies[0], mutants, seed or now.strftime("%G-%V-%u"), seeds, seconds)
            until = time.monotonic() + 60.0 * minutes if minutes else None
            trying = functools.partial(attempt, seeds=seeds, seconds=seconds, near=near)
            trials = list(try_all(copies, drawn.chosen, trying, until))
        except NotGreenError as error:
            click.echo(f"Error: {error} is not green without any fault; mend it first", err=True)
            sys.exit(2)
    report(drawn, trials, json=json)


def try_all(
    copies: list[Copy],
    places: list[Place],
    trying: Callable[[Copy, Place], Trial],
    until: float | None,
) -> Iterator[Trial]:
    """Yield what comes of each fault; begin none after a time [s]."""
    free: SimpleQueue[Copy] = SimpleQueue()
    for copy in copies:
        free.put(copy)

    def try_one(place: Place) -> Trial | None:
        if until and time.monotonic() > until:
            return None
        copy = free.get()
        try:
            return trying(copy, place)
        finally:
            free.put(copy)

    with (
        Bar("trying", len(places)) as bar,
        concurrent.futures.ThreadPoolExecutor(len(copies)) as pool,
    ):
        for number, trial in enumerate(pool.map(try_one, places), 1):
            bar.at("faults", number)
            if trial:
                yield trial


def report(drawn: Drawn, trials: list[Trial], *, json: bool) -> None:
    """Print what has found the faults; leave with 1 where nothing finds many."""
    unfound = sum(each.unfound for each in trials)
    if json:
        found = {
            "places": drawn.places,
            "executed": drawn.executed,
            "faults": [asdict(each) for each in trials],
        }
        click.echo(js.dumps(found, indent=1))
    else:
        click.echo("\n".join(in_words(drawn, trials)))
        click.echo(f"of {len(trials)} faults nothing finds {unfound}")
    sys.exit(1 if unfound > MAX_UNFOUND * len(trials) else 0)


if __name__ == "__main__":
    run_command(mutation, "python -m tests.mutation")
