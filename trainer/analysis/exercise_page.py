"""The commands ``trainer exercise new`` and ``check``: a file to begin with, and what one says."""

import json
import re
from collections.abc import Iterator
from dataclasses import fields
from pathlib import Path
from typing import Final

import click

from trainer.analysis.debrief.scoring import formula_of
from trainer.analysis.debrief.trajectory import lacks
from trainer.boat.boat import Boat
from trainer.config.exercise import parse_exercise
from trainer.config.files import ConfigError, read_text, shipped
from trainer.session.plan import Plan
from trainer.units import KNOT

SKELETON: Final = "exercise-skeleton"
NAMED: Final = re.compile(r'^name = "[^"]*"', re.MULTILINE)


def write_new(path: Path, name: str | None) -> None:
    """Write a valid exercise to begin with; ConfigError if the file is there or cannot be made."""
    text = read_text(shipped("", SKELETON))
    if name is not None:
        text = NAMED.sub(lambda _: f"name = {json.dumps(name, ensure_ascii=False)}", text, count=1)
    parse_exercise(text, path)
    try:
        with path.open("x", encoding="utf-8") as file:
            file.write(text)
    except FileExistsError:
        raise ConfigError(f"{path} is there already: give a new name") from None
    except OSError as error:
        raise ConfigError(f"{path} cannot be written: {error.strerror}") from None
    click.echo(f"{path} written; next: trainer exercise check {_as_typed(path)}")


def _as_typed(path: Path) -> str:
    """Return a path as the commands take it: a bare name would be a shipped exercise's."""
    bare = path.suffix != ".toml" and len(path.parts) == 1
    return f"./{path}" if bare else str(path)


def summary(plan: Plan) -> list[str]:
    """Return what an exercise is, a line each; ConfigError if its boat cannot start."""
    boat = Boat(plan.file, plan.method)
    plan.start(boat)
    s, method = boat.state, plan.method
    lines = [
        ("name", plan.title),
        ("boat", f"{boat.file.name}; {method.equations} set, step {method.step:g} s"),
        ("start", f"{s.u / KNOT:.3g} kn, {s.z:g} m; sea: {plan.sea.name}"),
        ("lasts", "until quit" if plan.duration is None else f"{plan.duration:g} s"),
        *(("at", f"{entry.seconds:g} s: {entry.order.text}") for entry in plan.schedule),
        *(("when", f"{each.condition.text}: {each.casualty.name}") for each in plan.armed),
        *(("limit", text) for text in _limits(plan)),
        *(("score", text) for text in _scores(plan)),
        *(("note", text) for text in _notes(plan, boat)),
    ]
    return [f"{word:8}{text}" for word, text in lines]


def _limits(plan: Plan) -> Iterator[str]:
    for item in fields(plan.limits):
        limit = getattr(plan.limits, item.name)
        if limit is not None:
            yield f"{item.name} {limit:g}"


def _scores(plan: Plan) -> Iterator[str]:
    whole = sum(rule.weight for rule in plan.scores)
    for rule in plan.scores:
        share = 100.0 * rule.weight / whole
        yield f"{share:.0f} % {rule.score.name}: {formula_of(rule)}"


def _notes(plan: Plan, boat: Boat) -> Iterator[str]:
    """Yield what is not wrong, and may not be meant."""
    end = plan.duration
    if not plan.scores:
        yield "nothing is scored: trainer debrief will give no marks"
    for rule in plan.scores:
        if end is not None and (rule.score.from_s or 0.0) > end:
            yield f"score {rule.score.name}: begins after the end"
        for name in lacks(boat, rule):
            yield f"score {rule.score.name}: this boat has no {name}; it will not count"
    for entry in plan.schedule:
        if end is not None and entry.seconds >= end:
            yield f"{entry.order.text}: comes when the exercise is over"
