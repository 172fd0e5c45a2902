"""What the texts of the shipped exercises state: every time, depth and rate is a field or flown."""

import tomllib
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import pytest

from trainer.authoring.exercise_page import check_exercise
from trainer.authoring.stated import fly_stated
from trainer.boat.depths import WATCH_CALLS
from trainer.boat.grounding import GENTLE_SINK
from trainer.config.boat.casualties import load_casualties
from trainer.config.exercise.baseline import digest_of
from trainer.config.exercise.derived import LASTING_CONDITION, compile_conditions
from trainer.config.exercise.exercise import load_exercise, parse_exercise
from trainer.config.exercise.reference_crew import CREW_HANDS
from trainer.config.exercise.score_rules import SCORE_MEASURES, parse_quantity
from trainer.config.exercise.stated import JUDGED_KINDS, TEXT_UNITS, TextFigure, figures_of
from trainer.config.files import ConfigError, Position, path_named, read_text, shipped_names
from trainer.session.past.options import RunOptions
from trainer.session.past.plan import plan_run

NAMES = shipped_names("exercises")
STATING = tuple(name for name in NAMES if load_exercise(name).stated)
UNITS_OF_KEYS = {"_s": "s", "_m": "m", "_kn": "kn"}
UNITS_OF_ORDERS = {"depth": "m", "speed": "kn", "turns": "kn"}  # of a number without one
PLACE = Position("test", "")
LAWS = (  # what texts say of the trainer's own laws
    (GENTLE_SINK, *TEXT_UNITS["m/s"]),
    *((above, *TEXT_UNITS["m"]) for above, _ in WATCH_CALLS),
)
Field = tuple[float, str, float]  # number, kind, and the size [SI] of its unit

DRIFT = """
schema = "exercise/1"
name = "Drift"
duration_s = 60
briefing = "Hold your course. After {time} seconds the boat is 200 m further north."
[initial]
speed_kn = 8
[[stated]]
says = "After {time} seconds the boat is 200 m further"
when = "north > 200"
at_s = {time}
"""


def of_key(key: str, number: float) -> Iterator[Field]:
    """Yield the field if its key says its unit."""
    for end in ("", "_min", "_max"):
        for suffix, unit in UNITS_OF_KEYS.items():
            if key.endswith(suffix + end):
                yield number, *TEXT_UNITS[unit]


def of_score(row: Mapping[str, Any]) -> Iterator[Field]:
    """Yield what a score's numbers are, in the unit of its quantity or measure."""
    unit = SCORE_MEASURES[row["measure"]].unit
    size = 1.0
    if not unit:
        measured = parse_quantity(row["quantity"], PLACE)
        unit, size = measured.unit, measured.size
    if unit in TEXT_UNITS:
        kind = TEXT_UNITS[unit][0]
        for key in ("target", "band", "full", "zero"):
            if key in row:
                yield row[key], kind, size if size != 1.0 else TEXT_UNITS[unit][1]


def of_condition(text: str) -> Iterator[Field]:
    """Yield the thresholds of a condition, and how long it has to hold."""
    lasting = LASTING_CONDITION.fullmatch(text.strip())
    for condition in compile_conditions(lasting[1] if lasting else text, PLACE):
        measured = parse_quantity(condition.quantity, PLACE)
        kind, size = TEXT_UNITS.get(measured.unit, ("", 1.0))
        if kind:
            yield condition.threshold / size, kind, size
    if lasting:
        yield float(lasting[2]), *TEXT_UNITS["s"]


def of_casualty(row: Mapping[str, Any]) -> Iterator[Field]:
    """Yield when a casualty comes at the latest, and how much it amounts to."""
    if "within_s" in row:
        yield row["at_s"] + row["within_s"], *TEXT_UNITS["s"]
    casualty = load_casualties()[row["name"]]
    if casualty.measure.parameter.endswith("_m"):
        yield row.get("severity", casualty.severity) * casualty.full, *TEXT_UNITS["m"]


def of_order(text: str) -> Iterator[Field]:
    """Yield the numbers of an order, with the unit that its word gives them."""
    for figure in figures_of(text):
        units = [TEXT_UNITS[unit] for word, unit in UNITS_OF_ORDERS.items() if word in text.split()]
        if figure.kind:
            yield figure.number, figure.kind, figure.size
        elif units:
            yield figure.number, *units[0]


def of_condition_or_order(key: str, value: object) -> Iterator[Field]:
    """Yield the numbers that are written in a text of a field."""
    if key == "order":
        yield from of_order(str(value))
    elif key == "when":
        yield from of_condition(str(value))


def of_rows(key: str, rows: Sequence[Any]) -> Iterator[Field]:
    """Yield the numbers of a list: conditions that lose, or tables."""
    if key == "lost":
        for text in rows:
            yield from of_condition(text)
    for row in rows:
        if isinstance(row, Mapping):
            yield from own_fields(row)
            yield from OF_TABLES.get(key, lambda _: iter(()))(row)


def of_current(table: Mapping[str, Any]) -> Iterator[Field]:
    """Yield the speeds of a current by depth."""
    return ((row[2], *TEXT_UNITS["kn"]) for row in table.get("table", ()))


OF_TABLES = {"scores": of_score, "casualties": of_casualty}


def own_fields(table: Mapping[str, Any]) -> Iterator[Field]:
    """Yield every number of an exercise's own fields that has a unit."""
    for key, value in table.items():
        if key in ("briefing", "instructor", "stated"):
            continue
        if isinstance(value, str):
            yield from of_condition_or_order(key, value)
        elif isinstance(value, Mapping):
            yield from own_fields(value)
        elif isinstance(value, list):
            yield from of_rows(key, value)
        elif isinstance(value, int | float):
            yield from of_key(key, value)
    yield from of_current(table.get("current", {}))


def unfounded(text: str, path: Path) -> list[str]:
    """Return the figures of an exercise's texts that are neither a field nor stated."""
    table, exercise = tomllib.loads(text), parse_exercise(text, path)
    crew = {name: vars(getattr(exercise.crew, name)) for name in CREW_HANDS}
    fields, stated = [*LAWS, *own_fields(table), *own_fields(crew)], exercise.stated
    texts = " ".join((table["briefing"], table.get("instructor", "")))

    def founded(figure: TextFigure) -> bool:
        own = any(figure.is_of(*field) for field in fields)
        return own or any(
            each.states(figure) and figure.text in " ".join(each.row.says.split())
            for each in stated
        )

    return [
        figure.text
        for figure in figures_of(texts)
        if figure.kind in JUDGED_KINDS and not founded(figure)
    ]


@pytest.mark.parametrize("name", NAMES)
def test_every_time_depth_and_rate_of_a_text_is_a_field_of_its_file_or_flown(name: str) -> None:
    path = path_named(name, "exercises")
    assert unfounded(read_text(path), path) == []


@pytest.mark.parametrize("name", STATING)
def test_a_boat_does_what_the_texts_state(name: str) -> None:
    flown = fly_stated(plan_run(RunOptions(exercise=name)), load_exercise(name).stated, {})
    wrong = [each.difference for each in flown if not each.holds]
    assert not wrong, wrong


def test_the_check_of_an_exercise_tells_a_stated_figure_that_is_not_flown(tmp_path: Path) -> None:
    path = tmp_path / "drift.toml"
    path.write_text(DRIFT.format(time=49), encoding="utf-8")
    assert any(line.startswith("name") for line in check_exercise(str(path)))
    path.write_text(DRIFT.format(time=40), encoding="utf-8")
    with pytest.raises(ConfigError) as wrong:
        check_exercise(str(path))
    (problem,) = wrong.value.problems
    assert "drift.toml: line 9: [stated[0]] says =" in problem
    assert "flown by nobody aboard, north > 200 is 49 s, not 40 s" in problem


@pytest.mark.parametrize(
    ("words", "other", "told"),
    [
        ("After 49 seconds", "After 49 s", "neither briefing nor instructor"),
        ("at_s = 49", "at_s = 50", "has no figure that is 50 s"),
        ("at_s = 49", "", "lacks at_s"),
        ("at_s = 49", 'at_s = 49\nquantity = "north_m"', "give one of when, quantity"),
        ("at_s = 49", 'at_s = 49\norders = ["turns 9"]', 'orders[0] = "turns 9": a line is'),
        ("at_s = 49", 'at_s = 49\norders = ["1 sing"]', 'orders[0] = "1 sing"'),
        ("at_s = 49", 'at_s = 49\norders = ["1 tell wait"]', "moves no boat"),
        ("at_s = 49", "at_s = 49\nvalue = 3", "measure and value go with quantity"),
        ('when = "north > 200"', 'quantity = "north_m"\nvalue = 200', "lacks measure, value"),
        ('when = "north > 200"', 'when = "nort > 200"', "north"),
        ("north > 200", "north > 190", '"200 m" is no number of this row'),
    ],
)
def test_a_stated_row_that_does_not_fit_its_texts_is_refused(
    words: str, other: str, told: str
) -> None:
    head, rows = DRIFT.format(time=49).split("[[stated]]")
    assert words in rows
    with pytest.raises(ConfigError, match=r"stated\[0\]") as wrong:
        parse_exercise(f"{head}[[stated]]{rows.replace(words, other)}", Path("drift.toml"))
    assert told in str(wrong.value)


def test_a_figure_that_no_field_and_no_row_has_is_found() -> None:
    text = DRIFT.format(time=49)
    assert unfounded(text, Path("drift.toml")) == []
    assert unfounded(text.partition("[[stated]]")[0], Path("drift.toml")) == ["49 seconds", "200 m"]


@pytest.mark.parametrize(
    ("text", "number", "kind"),
    [
        ("after 7 minutes", 7, "time"),
        ("lost at 2:30 on", 150, "time"),
        ("for half an hour.", 0.5, "time"),
        ("twenty seconds:", 20, "time"),
        ("at 54 m: the", 54, "length"),
        ("0.15 m/s; then", 0.15, "speed"),
        ("8 knots", 8, "speed"),
        ("15 and 20 minutes", 20, "time"),
        ("course 045", 45, ""),
    ],
)
def test_figures_are_read_as_texts_write_them(text: str, number: float, kind: str) -> None:
    figure = [*figures_of(text)][-1]
    assert (figure.number, figure.kind) == (number, kind)


def test_a_stated_figure_flies_nothing_so_that_baselines_stay() -> None:
    text = DRIFT.format(time=49)
    assert digest_of(text) == digest_of(text.partition("[[stated]]")[0])
