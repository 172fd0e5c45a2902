"""The tables ``[[scores]]`` of an exercise file, read and checked against their measures."""

from collections.abc import Mapping
from typing import Final

from trainer.config import ConfigError, Place, collecting, nearest
from trainer.files.casualty_file import Casualty
from trainer.scores.measure_table import MEASURES, TIMELESS, WINDOW
from trainer.scores.passage import ORDERED
from trainer.scores.score_rule import SCORES, Rule, Score, understood

# what a rule may say for some measures only
OPTIONAL: Final = ("quantity", "target", "band", "casualty", "orders", *WINDOW)


def read_rules(
    table: Mapping[str, object], place: Place, known: Mapping[str, Casualty]
) -> tuple[Rule, ...]:
    """Return the rules of an exercise file; ConfigError with all that is wrong in them."""
    problems: list[str] = []
    rules: list[Rule] = []
    for i, score in enumerate(SCORES.read("scores", table.get("scores", []), place)):
        inside = place.inside(f"scores[{i}]")
        with collecting(problems):
            rules.append(_read_rule(score, inside, known))
    names = [rule.score.name for rule in rules]
    problems += [
        place.problem(f'two [[scores]] have the name "{name}"')
        for name in dict.fromkeys(names)
        if names.count(name) > 1
    ]
    if problems:
        raise ConfigError(*problems)
    return tuple(rules)


def _read_rule(score: Score, place: Place, known: Mapping[str, Casualty]) -> Rule:
    """Return one rule; ConfigError with all that is wrong in it."""
    problems: list[str] = []
    with collecting(problems):
        rule = understood(score, place, known)
    if score.measure not in MEASURES:
        guess = nearest(score.measure, MEASURES) or f"; there are: {', '.join(MEASURES)}"
        problems.append(place.wrong("measure", score.measure, f"no such measure{guess}"))
    else:
        problems += _unfit(score, place)
    if not problems:
        problems += _misaimed(rule, place)
    if problems:
        raise ConfigError(*problems)
    return rule


def _unfit(score: Score, place: Place) -> list[str]:
    """Return which keys the measure has no use for, and which it lacks."""
    measure = MEASURES[score.measure]
    timed = () if score.measure in TIMELESS else WINDOW
    taken = (*measure.needs, *measure.may, *timed)
    given = [key for key in OPTIONAL if getattr(score, key) is not None]
    found = [
        place.wrong(key, getattr(score, key), f"{score.measure} has no use for it")
        for key in given
        if key not in taken
    ]
    lacking = [key for key in measure.needs if key not in given]
    if lacking:
        found.append(place.problem(f"{score.measure} lacks {', '.join(lacking)}"))
    return found


def _misaimed(rule: Rule, place: Place) -> list[str]:
    """Return what is wrong with the quantity, or with the lack of its target."""
    measure, measured, score = MEASURES[rule.score.measure], rule.measured, rule.score
    if measured is None:
        return []
    if measure.quantities and measured.name not in measure.quantities:
        told = f"{score.measure} is of {' or '.join(measure.quantities)}"
        return [place.wrong("quantity", score.quantity, told)]
    if score.target is None and "target" in measure.may and measured.name not in ORDERED:
        told = f"nobody orders it as such ({', '.join(ORDERED)} are): give a target"
        return [place.wrong("quantity", score.quantity, told)]
    return []
