"""Every keyword of every call of the Python face reaches what carries it out."""

from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest

import trainer
from trainer.api import calls
from trainer.api.boat import BOAT_KEYWORDS
from trainer.config import keywords as tables
from trainer.config.files import shipped_path
from trainer.config.schema import Kind
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
    "battery": ("endless", "battery", "endless"),
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
    "between_readings": ("step", "between_readings", "step"),
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
    "anyway": (True, "anyway", True),
}
WATCH_BOAT: dict[str, Case] = {
    "html": ("page.html", "html", Path("page.html")),
    "columns": ("depth=z:m", "columns", ("depth=z:m",)),
    "bias": ("pitch=1", "bias", ("pitch=1",)),
    "gauge_x": (2, "gauge_x", 2.0),
    "late": (1, "late", 1.0),
    "still": ("bow", "still", ("bow",)),
    "coarse": (True, "coarse", True),
    "anyway": (True, "anyway", True),
}
FIT_BOAT: dict[str, Case] = {
    **WATCH_BOAT,
    "hold_out": (str(RECORD), "hold_out", (RECORD,)),
    "output": ("fitted.toml", "output", Path("fitted.toml")),
    "draws": (3, "draws", 3),
}


class ArrivedError(Exception):
    """Ends a call where its options have arrived."""


class Face(NamedTuple):
    """A call of the Python face, and what takes the options that it sends."""

    call: Callable[..., object]
    cases: dict[str, Case]
    taker: str
    needs: str = "numpy"


FACES = {
    "boat": Face(trainer.Boat, RUN, "api.boat.plan_run"),
    "manoeuvre": Face(partial(trainer.manoeuvre, "turn"), MANOEUVRE, "api.programs.fly_manoeuvre"),
    "sweep": Face(
        partial(trainer.sweep, "turn-uncertainty"), SWEEP, "api.programs.fly_sweep", "pyarrow"
    ),
    "fit": Face(partial(trainer.identify_ship, RECORD), IDENTIFY, "api.programs.fit_ship", "scipy"),
    "fit_boat": Face(partial(trainer.fit_boat, RECORD, "bb2"), FIT_BOAT, "api.programs.fit_boat"),
    "watch_boat": Face(
        partial(calls.watch_boat, "bb2", RECORD), WATCH_BOAT, "api.programs.watch_boat"
    ),
}


@pytest.mark.parametrize(
    ("cases", "kinds", "by_place"),
    [
        ({**RUN, **BEGIN}, BOAT_KEYWORDS, {"vessel"}),
        (MANOEUVRE, tables.MANOEUVRE_KEYWORDS, {"vessel"}),
        (SWEEP, tables.SWEEP_KEYWORDS, {"study"}),
        (IDENTIFY, tables.IDENTIFY_KEYWORDS, {"record", "data_only"}),
        (FIT_BOAT, tables.FIT_BOAT_KEYWORDS, {"records", "prior"}),
        (WATCH_BOAT, tables.WATCH_BOAT_KEYWORDS, {"fitted", "records"}),
    ],
)
def test_every_keyword_has_a_case(
    cases: dict[str, Case], kinds: Mapping[str, Kind], by_place: set[str]
) -> None:
    assert cases.keys() == kinds.keys() - by_place


@pytest.mark.parametrize(
    ("face", "keyword"),
    [(face, keyword) for face, found in FACES.items() for keyword in found.cases],
)
def test_a_keyword_reaches_its_option(
    face: str, keyword: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    call, cases, taker, needs = FACES[face]
    pytest.importorskip(needs)
    value, option, wanted = cases[keyword]
    taken: dict[str, Any] = {}

    def arrive(*given: Any, **named: object) -> None:
        if face == "sweep":
            taken.update(members=given[0].members, out=given[1])
        elif given:
            taken.update(given[-1] if isinstance(given[-1], dict) else vars(given[-1]))
        taken.update(named)
        raise ArrivedError

    monkeypatch.setattr(f"trainer.{taker}", arrive)
    monkeypatch.setattr("trainer.identify.options.study_of", lambda _file, _options: None)
    with pytest.raises(ArrivedError):
        call(**{keyword: value})

    assert taken[option] == wanted


@pytest.mark.parametrize("keyword", BEGIN)
def test_a_keyword_of_the_start_is_where_the_boat_begins(keyword: str) -> None:
    value, number, wanted = BEGIN[keyword]
    options: dict[str, Any] = {keyword: value}
    assert trainer.Boat(**options).state[number] == pytest.approx(wanted, rel=1e-9)


@pytest.mark.parametrize("flag", [False, None])
def test_a_flag_that_is_not_set_is_as_if_not_given(flag: Any) -> None:
    with pytest.raises(trainer.TrainerError, match="is not stable"):
        trainer.Boat(unsafe_step=flag, integrator="bdf3", step=2.0)


@pytest.mark.parametrize("flag", ["yes", 2, [True]])
def test_a_flag_is_true_or_false(flag: object) -> None:
    with pytest.raises(trainer.TrainerError) as wrong:
        trainer.Boat(unsafe_step=flag)

    assert str(wrong.value).startswith("Boat: unsafe_step = ")
    assert str(wrong.value).endswith(": must be true or false")


@pytest.mark.parametrize(
    ("call", "keyword", "text"),
    [
        (trainer.Boat, "seed", "7"),
        (partial(trainer.manoeuvre, "turn"), "angle", "15"),
        (partial(trainer.fit_boat, RECORD, "bb2"), "draws", 3.5),
    ],
)
def test_a_number_is_none_of_another_type(
    call: Callable[..., object], keyword: str, text: object
) -> None:
    with pytest.raises(trainer.TrainerError, match=f"{keyword} = .*must be a (whole )?number"):
        call(**{keyword: text})


def test_numbers_of_numpy_and_paths_are_taken() -> None:
    given: dict[str, Any] = {"seed": np.int64(3), "step": np.float64(0.25), "depth": np.array(70)}
    boat = trainer.Boat(shipped_path("vessels", "bb2"), **given)

    boat.run(np.float64(1.0))

    assert (boat.columns["t"][1], boat.columns["z"][0]) == (0.25, 70.0)


def test_an_output_that_would_cost_an_input_is_refused_before_anything_is_read(
    tmp_path: Path,
) -> None:
    prior = tmp_path / "prior.toml"
    prior.write_text("nothing is read", encoding="utf-8")

    with pytest.raises(trainer.TrainerError, match=r"fit_boat: output: .*is an input here"):
        trainer.fit_boat("nix.csv", prior=prior, output=prior)


def test_an_output_of_another_kind_or_in_no_folder_is_refused(tmp_path: Path) -> None:
    told = r"output: .*it\.html: \.html is the ending of a page, .* such as .*it\.toml"
    with pytest.raises(trainer.TrainerError, match=told):
        trainer.fit_boat("nix.csv", prior="bb2", output=tmp_path / "it.html")
    with pytest.raises(trainer.TrainerError, match="there is no folder"):
        trainer.Boat(record=tmp_path / "none" / "it.trainer")


def test_a_record_is_shown_alone_by_call_as_by_the_command() -> None:
    pytest.importorskip("scipy")
    study = shipped_path("records", "example")

    seen = trainer.identify_ship(study, data_only=True)

    assert seen.report.runs[0].samples == seen.figures["yaw_rate"].samples > 100
    assert seen.figures["yaw_rate"].unit == "deg/s"
    assert seen.report.study in seen.page
    assert seen.page.startswith("RECORD\n")
