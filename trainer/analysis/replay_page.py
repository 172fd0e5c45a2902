"""The command ``trainer replay`` flies each branch of a recording again and compares it."""

from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

import click

from trainer.config.files import json_text
from trainer.io.lines import plain
from trainer.session.header import differences, notes, reading
from trainer.session.replay import Flight, replay_anyway
from trainer.session.resume import refuse_other


def replay_file(path: Path, otherwise: Mapping[str, Any], *, anyway: bool, as_json: bool) -> int:
    """Fly a recording again and print how it went; return the exit code."""
    with reading(path) as recording:
        header = recording.header()
        found = differences(header, otherwise)
        refuse_other(path, found, anyway=anyway)
        for note in (*found, *notes(header)):
            click.echo(plain(f"note: {note}"), err=True)
        flights = replay_anyway(recording, otherwise)
    click.echo(
        json_text([as_row(each) for each in flights], indent=1) if as_json else page(flights)
    )
    return 0 if all(flight.same for flight in flights) else 1


def as_row(flight: Flight) -> dict[str, Any]:
    """Return a flight as JSON has it."""
    parting = flight.parting and asdict(flight.parting)
    return {
        "branch": flight.branch.id,
        "from_tick": flight.branch.tick,
        "why": flight.branch.why,
        "states_compared": flight.compared,
        "states_unequal": flight.unequal,
        "same": flight.same,
        "first_difference": parting,
        "answers": flight.answers,
        "trouble": flight.trouble,
    }


def page(flights: list[Flight]) -> str:
    """Return the flights as lines."""
    return "\n".join(plain(line) for flight in flights for line in describe_flight(flight))


def describe_flight(flight: Flight) -> list[str]:
    """Return a flight in words."""
    branch = flight.branch
    begun = f", from tick {branch.tick} ({branch.why})" if branch.parent else ""
    verdict = "the same to the last bit"
    if not flight.same:
        verdict = f"NOT THE SAME: {flight.unequal} of them differ"
    lines = [f"branch {branch.id}{begun}: {flight.compared} states, {verdict}"]
    lines += [f"  {flight.parting}"] if flight.parting else []
    lines += [f"  {answer}" for answer in flight.answers]
    return lines + ([f"  {flight.trouble}"] if flight.trouble else [])
