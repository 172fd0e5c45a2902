"""What the program writes, the program reads: a law for each kind of file that it writes."""

import math
import re
from collections.abc import Mapping
from dataclasses import fields, replace
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any
from unittest.mock import patch

import numpy as np
import pytest
from helpers.ships import SHIP
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from trainer.analysis import gains
from trainer.analysis.estimate.boat_file import boat_tables, boat_text, estimate_of, open_hull
from trainer.analysis.guide import uncertainty
from trainer.analysis.guide.trials import load_published, trials_path
from trainer.analysis.reduce import page as reduction_page
from trainer.analysis.reduce.reduction import load_standings, save_standings
from trainer.analysis.reduce.search import SearchState, TermNeed
from trainer.analysis.sweep import sweep
from trainer.config.boat.vessel import load_vessel, parse_vessel
from trainer.config.boat.vessel_template import write_new as write_vessel
from trainer.config.exercise.baseline import (
    Baseline,
    BaselineHeading,
    PeopleFigures,
    Totals,
    read_baseline,
    write_baseline,
)
from trainer.config.exercise.exercise import parse_exercise
from trainer.config.files import MIN_NONZERO_SIZE, parse_toml, toml_value
from trainer.config.schema import Choice, Quantities, Quantity, Text, kinds_of
from trainer.config.ship.nomoto import NomotoFile, load_nomoto, nomoto_text_of
from trainer.config.ship.sensors import Sensors
from trainer.config.ship.ship import (
    Dimensions,
    FitResult,
    RecordSettings,
    ShipColumn,
    ShipFile,
    parse_ship,
    ship_text,
)
from trainer.core.terms import EXTRA_TERMS
from trainer.debrief.marks.changes import Change, read_changes, write_changes
from trainer.debrief.marks.forms import EvaluationForm, FormHeading, read_forms, write_forms
from trainer.identify.experiment import exercise_text
from trainer.identify.pages.ship_files import rewrite_coefficients
from trainer.identify.record.proposal import write_proposal
from trainer.identify.record.sources import write_columns
from trainer.identify.record.study import load_study

MANY = settings(max_examples=60, deadline=None)
FEW = settings(max_examples=15, deadline=None, suppress_health_check=[HealthCheck.too_slow])
NAMES = st.text(st.characters(exclude_categories=["Cs"]), min_size=1, max_size=30)
LETTERS = st.characters(exclude_categories=["C", "Z"], include_characters=" ")
PRINTED = st.text(LETTERS | st.sampled_from("\"\\'#"), min_size=1, max_size=30)
TINY = st.sampled_from([2e-13, -2.1e-13, 5e-324, -1e-20])
BB2 = load_vessel("bb2")


def numbers(low: float, high: float, *, tiny: bool = True) -> st.SearchStrategy[float]:
    """Return numbers of a range; among them, where 0 is in it, such as no reader takes."""
    plain = st.floats(low, high, allow_nan=False).filter(lambda x: not 0 < abs(x) < 1e-9)
    small = TINY.filter(lambda x: low <= x <= high)
    return plain | small if tiny and low <= 0.0 <= high and (low < 0.0 or low == 0.0) else plain


def values_of(kind: Any) -> st.SearchStrategy[Any]:
    """Return values that a kind of key may have."""
    if isinstance(kind, Quantity):
        limits = kind.limits
        low = max(limits.low, -1e12) + (1e-6 if limits.open_below else 0.0)
        return numbers(low, min(limits.high, 1e12), tiny=not limits.open_below)
    if isinstance(kind, Quantities):
        return st.lists(values_of(kind.each), min_size=kind.fewest, max_size=min(kind.most, 3)).map(
            tuple
        )
    if isinstance(kind, Choice):
        return st.sampled_from(kind.words)
    assert isinstance(kind, Text), kind
    return PRINTED.map(lambda text: text[: kind.longest])


def records(record: Any) -> st.SearchStrategy[Any]:
    """Return records of a class, all keys given."""
    return st.builds(record, **{name: values_of(kind) for name, kind in kinds_of(record).items()})


def same(read: Any, written: Any, digits: int = 15) -> None:
    """Assert that what was read is what was written, to so many digits, and 0 what was tiny."""
    if isinstance(written, float):
        wanted = 0.0 if abs(written) < MIN_NONZERO_SIZE else written
        assert read == pytest.approx(wanted, rel=10.0**-digits, abs=0.0)
    elif isinstance(written, Mapping):
        assert [*read] == [*written]
        for key, value in written.items():
            same(read[key], value, digits)
    elif isinstance(written, list | tuple):
        assert len(read) == len(written)
        for one, other in zip(read, written, strict=True):
            same(one, other, digits)
    elif hasattr(written, "__dataclass_fields__"):
        for item in fields(written):
            same(getattr(read, item.name), getattr(written, item.name), digits)
    else:
        assert read == written


@MANY
@given(st.data())
def test_a_fitted_ship_is_read_as_it_was_written(data: st.DataObject) -> None:
    names = ("X_0", "Y_v", "N_F")
    one = numbers(-1e9, 1e9)
    ship = ShipFile(
        path=Path("ship.toml"),
        name=data.draw(values_of(Text(79, ""))),
        dimensions=data.draw(records(Dimensions)),
        records=data.draw(records(RecordSettings)),
        sensors=data.draw(records(Sensors)),
        columns=data.draw(st.lists(records(ShipColumn), max_size=2).map(tuple)),
        result=data.draw(records(FitResult)),
        coefficients={name: data.draw(one) for name in names},
        covariance=tuple(tuple(data.draw(one) for _ in names) for _ in names),
        uncertain=names,
        ranges={"v": (data.draw(one), data.draw(one))},
    )

    read = parse_ship(ship_text(ship, data.draw(NAMES)), ship.path)

    same(replace(read, ranges={}, covariance=None), replace(ship, ranges={}, covariance=None))
    same(read.covariance, ship.covariance, 8)
    same(read.ranges, ship.ranges, 5)


def test_a_covariance_that_is_nearly_nothing_sails_again() -> None:
    # the tanker of configs/ships/kvlcc2.toml has one of 2e-13 where it is fitted again
    ship = replace(
        SHIP,
        result=FitResult(model="mmg", speed_kn=15.8699, revolutions_per_s=1.52767),
        coefficients={"X_0": -0.05111855, "Y_0": -0.001925595},
        uncertain=("X_0", "Y_0"),
        covariance=((0.000107404, -2.1e-13), (-2.1e-13, 7.81953e-06)),
    )
    read = parse_ship(ship_text(ship, "trainer identify"), Path("kvlcc2.toml"))
    assert read.covariance == ((0.000107404, 0.0), (0.0, 7.81953e-06))

    text = ship_text(ship, "trainer identify")
    earlier = re.sub(r"^X_0 = \[.*", "X_0 = [0.000107404, -2.1e-13]", text, flags=re.MULTILINE)
    assert earlier != text
    read = parse_ship(earlier, Path("kvlcc2.toml"))  # as release 0.2 wrote it
    assert read.covariance == ((0.000107404, -2.1e-13), (0.0, 7.81953e-06))


@MANY
@given(records(NomotoFile), NAMES, st.dictionaries(st.sampled_from(["K", "T1"]), st.floats(0, 9)))
def test_a_nomoto_ship_is_read_as_it_was_written(
    ship: NomotoFile, source: str, deviations: dict[str, float]
) -> None:
    ship = replace(ship, H1_s=None, H2_s2=None, H3_s3=None)
    with TemporaryDirectory() as folder:
        path = Path(folder) / "ship.toml"
        path.write_text(nomoto_text_of(ship, source, deviations), encoding="utf-8")
        same(load_nomoto(path), ship, 8)


@FEW
@given(st.dictionaries(st.sampled_from(["Y_v", "Y_r", "N_v", "N_r"]), numbers(-9, 9), min_size=1))
def test_a_vessel_with_identified_coefficients_is_read(values: dict[str, float]) -> None:
    text = rewrite_coefficients(BB2.text, values, "identified")
    read = parse_vessel(text, BB2.path).coefficients
    same({name: read[name] for name in values}, values, 5)


@FEW
@given(st.dictionaries(st.sampled_from(["Y_v", "M_w", "Y_vdot"]), numbers(0.0, 3.0)))
def test_a_reduced_vessel_is_read_as_it_was_written(factors: dict[str, float]) -> None:
    by_set = {"modified": dict.fromkeys(EXTRA_TERMS, 1.0) | factors, "basic": factors}
    needs = [TermNeed(EXTRA_TERMS[0], math.inf, 'a "turn"', "heel")]
    tables = reduction_page.factor_tables(by_set, needs, {"kept": 3, "share": 2e-13})
    read = parse_vessel(reduction_page.rewrite_vessel(BB2.text, tables), BB2.path)
    for name in by_set:
        kept = {key: value for key, value in factors.items() if value != 1.0}
        same({key: read.compensation[name].get(key, 0.0) for key in kept}, kept, 3)


@FEW
@given(st.lists(numbers(0.0, 3.0), min_size=2, max_size=2), numbers(0.0, 9.0))
def test_a_search_goes_on_from_what_was_kept(factors: list[float], limit: float) -> None:
    kept = {"modified": SearchState(tuple(factors), (0, 1), limit=limit)}
    with TemporaryDirectory() as folder:
        path = Path(folder) / "bb2.partial"
        save_standings(path, BB2, kept)
        assert load_standings(path, BB2) == kept


@FEW
@given(st.lists(numbers(-9.0, 9.0), min_size=2, max_size=2))
def test_gains_are_read_as_they_were_written(row: list[float]) -> None:
    own = gains.design_gains(BB2)
    made = {**own, **{key: row for key, each in own.items() if isinstance(each, list)}}
    with patch.object(gains, "design_gains", return_value=made):
        same(parse_toml(gains.design_text(BB2), "gains.toml")["autopilot"], made)


@cache
def estimate() -> Any:
    """Return the estimate of a shipped hull, and its tables."""
    made = estimate_of(open_hull("suboff"))
    return made, boat_tables(made)


@FEW
@given(st.dictionaries(st.sampled_from(["Y_v", "Z_q", "M_vr"]), numbers(-1e-3, 1e-3), min_size=1))
def test_an_estimated_boat_is_read_as_it_was_written(changed: dict[str, float]) -> None:
    made, tables = estimate()
    tables = {**tables, "coefficients": {**tables["coefficients"], **changed}}
    read = parse_vessel(boat_text(made, tables), Path("boat.toml"))
    same({name: read.coefficients[name] for name in changed}, changed)


@FEW
@given(st.floats(0.5, 2.5))
def test_a_scaled_vessel_is_read(factor: float) -> None:
    with TemporaryDirectory() as folder:
        path = Path(folder) / "boat.toml"
        write_vessel(path, "bb2", factor * BB2.hull.length, 'a "boat"\\')
        assert load_vessel(str(path)).hull.length == pytest.approx(factor * BB2.hull.length)


@MANY
@given(
    st.lists(st.floats(0.0, 86399.0).map(lambda t: round(t, 6)), min_size=1, max_size=3),
    PRINTED,
    st.floats(1.0, 10.0),
)
def test_an_experiment_is_an_exercise_as_it_was_written(
    times: list[float], name: str, speed: float
) -> None:
    orders = tuple((t, "rudder left 5") for t in sorted(times))
    table = {"vessel": "bb2", "speed_kn": speed, "depth_m": 50.0, "duration_s": 86399.123456}
    text = exercise_text(orders, name, table)
    read = parse_exercise(text, Path("trial.toml"))
    assert read.heading.name == name
    assert [one.seconds for one in read.schedule] == [t for t, _ in orders]
    assert read.initial.speed_kn == pytest.approx(speed, rel=1e-11)


@MANY
@given(
    st.dictionaries(PRINTED, numbers(0.0, 100.0), max_size=3),
    records(Totals),
    numbers(0.0, 1e6),
    records(PeopleFigures),
)
def test_a_baseline_is_read_as_it_was_written(
    marks: dict[str, float], totals: Totals, seed: float, people: PeopleFigures
) -> None:
    heading = BaselineHeading(
        schema="baseline/1", exercise="ab", core="cd", seed=float(int(seed)), seeds=10.0
    )
    written = Baseline(heading=heading, nobody=totals, crew=None, marks=marks, people=people)
    read = read_baseline(write_baseline(written), Path("jam.baseline.toml"))
    assert (read.heading, read.nobody.outcome) == (heading, totals.outcome)
    assert [*read.marks] == [*marks]
    assert read.nobody.total == pytest.approx(totals.total, abs=0.05)
    assert read.people
    assert read.people.core == people.core
    assert read.people.persons == pytest.approx(people.persons, abs=0.5)
    assert read.people.standard_error == pytest.approx(people.standard_error, abs=0.05)
    assert read.people.correlation == pytest.approx(people.correlation, abs=0.005)


@MANY
@given(st.lists(records(Change), max_size=2))
def test_changes_are_read_as_they_were_written(changes: list[Change]) -> None:
    written = [
        replace(one, branch=float(int(one.branch)), name="outcome", what="won") for one in changes
    ]
    with TemporaryDirectory() as folder:
        recording = Path(folder) / "run.trainer"
        write_changes(recording, written)
        same(read_changes(recording), tuple(written))


@MANY
@given(st.data())
def test_forms_are_read_as_they_were_written(data: st.DataObject) -> None:
    heading = {name: values_of(kind) for name, kind in kinds_of(FormHeading).items()}
    marks = st.dictionaries(PRINTED, numbers(0.0, 100.0), min_size=1, max_size=3)
    forms = data.draw(st.lists(st.builds(EvaluationForm, **heading, marks=marks), min_size=1))
    with TemporaryDirectory() as folder:
        recording = Path(folder) / "run.trainer"
        write_forms(recording, forms)
        same(read_forms(recording), tuple(forms))


@FEW
@given(numbers(0.0, 9.0))
def test_the_table_of_uncertainty_is_read_as_it_was_written(sd: float) -> None:
    published = load_published(trials_path(BB2) or Path())
    inputs = [uncertainty.InputDeviation("Y_v", -0.04, sd, 'of a "source"')]
    figures = len(published.figures)
    values = np.outer([0.0, 1.0, 3.0], np.full(figures, sd))
    with TemporaryDirectory() as folder:
        beside = replace(published, path=Path(folder) / "bb2.toml")
        text = uncertainty._write_table(  # noqa: SLF001  flown by 200 boats else
            BB2, beside, inputs, np.array([[1.0], [2.0], [4.0]]), values
        )
        uncertainty.table_path(beside).write_text(text, encoding="utf-8")
        read = uncertainty.load_spreads(BB2, beside)
    assert read is not None
    assert not read.stale
    same([one._replace(line=0) for one in read.inputs], inputs, 2)
    assert all(one.line for one in read.inputs)
    assert len(read.spreads) == figures


@MANY
@given(st.lists(st.floats(allow_nan=True), min_size=1, max_size=4))
def test_a_sweep_s_table_is_read_as_it_was_written(column: list[float]) -> None:
    pa = pytest.importorskip("pyarrow")
    table = pa.table({"member": [*range(len(column))], "heel": column})
    with TemporaryDirectory() as folder:
        sweep.write_table(table, Path(folder) / "result.parquet")
        read = sweep.read_table(Path(folder) / "result.parquet")
    assert np.array_equal(np.array(read["heel"]), np.array(column), equal_nan=True)


@MANY
@given(PRINTED.filter(lambda name: name.strip() and "/" not in name), numbers(1.0, 500.0))
def test_a_proposed_study_is_read(name: str, length: float) -> None:
    t = np.arange(200.0)
    helm = np.sign(np.sin(0.05 * t)) * 0.1
    columns = {"time": t, "rudder": helm, "yaw_rate": -0.1 * helm}
    with TemporaryDirectory() as folder:
        data = Path(folder) / f"{name[:20]}.csv"
        write_columns(data, columns)
        path = Path(folder) / "of-it.toml"
        write_proposal(data, path, length, 12.3456789)
        study = load_study(path)
    assert study.ship is not None
    assert study.ship.length_m == pytest.approx(length, rel=1e-11)
    assert study.ship.speed_kn == 12.3456789
    assert study.heading.name == data.stem


@MANY
@given(NAMES)
def test_every_text_is_toml(text: str) -> None:
    assert parse_toml(f"note = {toml_value(text)}", "a.toml") == {"note": text}
