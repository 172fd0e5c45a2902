"""Every keyword of every call of the Python face reaches the option of its name."""

from collections.abc import Callable
from dataclasses import asdict, fields
from pathlib import Path
from typing import Any

import pytest

import trainer
from trainer.cli import boat, calls, guide, identify
from trainer.cli import sweep as sweep_command
from trainer.config.files import shipped_path
from trainer.identify.options import IdentifyOptions
from trainer.units import KNOT

RECORD = shipped_path("records", "example").with_suffix(".csv")
Case = tuple[Any, str, Any]  # the value given, the option, and what has to arrive there

METHOD: dict[str, Case] = {
    "equations": ("full", "equations", "full"),
    "rates": ("exact", "rates", "exact"),
    "trig": ("report", "trig", "report"),
    "integrator": ("rk4", "integrator", "rk4"),
    "step": (0.25, "step", 0.25),
    "seed": (7, "seed", 7),
}
RUN: dict[str, Case] = {
    **METHOD,
    "exercise": ("stern-plane-jam", "exercise", "stern-plane-jam"),
    "sea": ("sea-state-3", "sea", "sea-state-3"),
    "unsafe_step": (True, "unsafe_step", True),
    "orders": ("orders.txt", "orders_file", Path("orders.txt")),
    "record": ("run.trainer", "record", Path("run.trainer")),
}
BEGIN: dict[str, Case] = {  # what is no option: the number of the state
    "speed": (7.5, "u", 7.5 * KNOT),
    "depth": (75, "z", 75.0),
    "course": (90.0, "psi", 1.5707963267948966),
}
MANOEUVRE: dict[str, Case] = {
    **METHOD,
    "speed": (8, "speed", 8.0),
    "angle": (15, "angle", 15.0),
    "side": ("port", "side", "port"),
    "direction": ("dive", "direction", "dive"),
    "planes": (12, "planes", 12.0),
    "execute": (10, "execute", 10.0),
    "duration": (300, "duration", 300.0),
    "step_speed": (12, "step_speed", 12.0),
    "step_time": (20, "step_time", 20.0),
    "ahead_speed": (6, "ahead_speed", 6.0),
    "ahead_time": (30, "ahead_time", 30.0),
    "depth": (60, "depth", 60.0),
    "sea": ("sea-state-2", "sea", "sea-state-2"),
    "controls": ("once", "controls", "once"),
    "trim": ("full", "trim", "full"),
    "law": ("report", "law", "report"),
}
SWEEP: dict[str, Case] = {
    "members": (3, "members", 3),
    "out": ("out.parquet", "out", Path("out.parquet")),
    "jobs": (2, "jobs", 2),
    "scheduler": ("tcp://127.0.0.1:8786", "scheduler", "tcp://127.0.0.1:8786"),
}
IDENTIFY: dict[str, Case] = {
    "model": ("nomoto1", "model", "nomoto1"),
    "vessel": ("bb2", "vessel", "bb2"),
    "length": (70, "length", 70.0),
    "at": (10, "knots", 10.0),
    "output": (["yaw_rate", "heading"], "channels", ("yaw_rate", "heading")),
    "noise": ("innovations", "noise", "innovations"),
    "method": ("bfgs", "method", "bfgs"),
    "exact": (True, "exact", True),
    "system": ("own.toml", "system", Path("own.toml")),
    "reject": (0.01, "reject", 0.01),
    "every": (5, "every", 5),
    "begin": (10, "begin", 10.0),
    "end": (90.0, "end", 90.0),
    "simulate": (True, "simulate", True),
    "against": ("nomoto1", "against", "nomoto1"),
    "without": ("T3", "without", ("T3",)),
    "check": ("other.csv", "check", Path("other.csv")),
    "kappa": ("large.csv", "kappa", Path("large.csv")),
    "bech": ("large.csv", "bech", Path("large.csv")),
    "spiral": ("turns.csv", "spiral", Path("turns.csv")),
    "joint": (True, "joint", True),
    "matrices": (True, "matrices", True),
}


class ArrivedError(Exception):
    """Ends a call where its options have arrived."""


def told_apart(cases: dict[str, Case]) -> list[Any]:
    """Return the cases as parameters of a test."""
    return [pytest.param(keyword, *case, id=keyword) for keyword, case in cases.items()]


def options_at(call: Callable[[], object], heard: dict[str, Any]) -> dict[str, Any]:
    """Return the options that have arrived when a call ends there."""
    with pytest.raises(ArrivedError):
        call()
    return heard


@pytest.mark.parametrize(
    ("cases", "options"),
    [
        ({**RUN, **BEGIN}, boat.BoatOptions),
        (MANOEUVRE, calls.ManoeuvreOptions),
        (SWEEP, calls.SweepOptions),
        (IDENTIFY, calls.IdentifyOptions),
    ],
)
def test_every_keyword_has_a_case(cases: dict[str, Case], options: type[Any]) -> None:
    assert cases.keys() == options.__annotations__.keys()


@pytest.mark.parametrize(("keyword", "value", "option", "wanted"), told_apart(RUN))
def test_a_keyword_of_a_boat_reaches_its_option(
    keyword: str, value: object, option: str, wanted: object, monkeypatch: pytest.MonkeyPatch
) -> None:
    heard: dict[str, Any] = {}

    def plan_run(options: Any) -> None:
        heard.update(asdict(options))
        raise ArrivedError

    monkeypatch.setattr(boat, "plan_run", plan_run)

    call = options_at(lambda: trainer.Boat(**{keyword: value}), heard)  # type: ignore[arg-type]
    assert call[option] == wanted


@pytest.mark.parametrize(("keyword", "value", "number", "wanted"), told_apart(BEGIN))
def test_a_keyword_of_the_start_is_where_the_boat_begins(
    keyword: str, value: float, number: str, wanted: float
) -> None:
    options: dict[str, Any] = {keyword: value}
    assert trainer.Boat(**options).state[number] == pytest.approx(wanted, rel=1e-9)


@pytest.mark.parametrize(("keyword", "value", "option", "wanted"), told_apart(MANOEUVRE))
def test_a_keyword_of_a_manoeuvre_reaches_its_option(
    keyword: str, value: object, option: str, wanted: object, monkeypatch: pytest.MonkeyPatch
) -> None:
    heard: dict[str, Any] = {}

    def fly(_vessel: str, _name: str, options: dict[str, Any]) -> None:
        heard.update(options)
        raise ArrivedError

    monkeypatch.setattr(guide, "fly", fly)

    call = options_at(lambda: trainer.manoeuvre("turn", **{keyword: value}), heard)  # type: ignore[arg-type]
    assert call[option] == wanted


@pytest.mark.parametrize(("keyword", "value", "option", "wanted"), told_apart(SWEEP))
def test_a_keyword_of_a_sweep_reaches_its_option(
    keyword: str, value: object, option: str, wanted: object, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("pyarrow")
    heard: dict[str, Any] = {}

    def fly(_job: object, _out: Path, options: dict[str, Any]) -> None:
        heard.update(options)
        raise ArrivedError

    monkeypatch.setattr(sweep_command, "fly", fly)

    call = options_at(lambda: trainer.sweep("turn-uncertainty", **{keyword: value}), heard)  # type: ignore[arg-type]
    assert call[option] == wanted


@pytest.mark.parametrize(("keyword", "value", "option", "wanted"), told_apart(IDENTIFY))
def test_a_keyword_of_a_fit_reaches_its_option(
    keyword: str, value: object, option: str, wanted: object, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("scipy")
    heard: dict[str, Any] = {}
    monkeypatch.setattr("trainer.identify.options.study_of", lambda _file, _options: None)

    def fit_ship(_study: object, options: IdentifyOptions) -> None:
        heard.update({item.name: getattr(options, item.name) for item in fields(options)})
        raise ArrivedError

    monkeypatch.setattr(identify, "fit_ship", fit_ship)

    call = options_at(lambda: trainer.identify_ship(RECORD, **{keyword: value}), heard)  # type: ignore[call-overload]
    assert call[option] == wanted


@pytest.mark.parametrize("flag", [False, None])
def test_a_flag_that_is_not_set_is_as_if_not_given(flag: Any) -> None:
    with pytest.raises(trainer.TrainerError, match="is not stable"):
        trainer.Boat(unsafe_step=flag, integrator="bdf3", step=2.0)


@pytest.mark.parametrize("flag", ["yes", 2, [True]])
def test_a_flag_is_true_or_false(flag: object) -> None:
    with pytest.raises(trainer.TrainerError) as wrong:
        trainer.Boat(unsafe_step=flag)  # type: ignore[arg-type]

    told = f"Invalid value for 'unsafe_step': {flag!r} is not one of False, True."
    assert str(wrong.value) == told


def test_an_unknown_keyword_is_told_before_its_value_is_read() -> None:
    with pytest.raises(trainer.TrainerError, match="no keyword 'unsafe_stp'; nearest is unsafe"):
        trainer.Boat(unsafe_stp=True)  # type: ignore[call-arg]


def test_a_record_is_shown_alone_by_call_as_by_the_command() -> None:
    pytest.importorskip("scipy")
    study = shipped_path("records", "example")

    seen = trainer.identify_ship(study, data_only=True)

    assert seen.report.runs[0].samples == seen.figures["yaw_rate"].samples > 100
    assert seen.figures["yaw_rate"].unit == "deg/s"
    assert seen.report.study in seen.page
    assert seen.page.startswith("RECORD\n")
