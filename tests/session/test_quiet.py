"""Ticks without a call, flown many at once: the same run as one that looks at each tick."""

from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from trainer import Boat
from trainer.io.recording.recording import Recording
from trainer.session.past.options import RunOptions
from trainer.session.quiet import QuietTicks
from trainer.session.run import run_boat
from trainer.session.session import Session

HEAD = 'schema = "exercise/1"\nname = "Quiet"\nbriefing = "Quiet."\n'
CROSSING = """
[[contact]]
name = "{name}"
type = "cargo"
points = [[{north}, {east}]]
course_deg = 270
speed_kn = 12
"""
# each with orders and calls of another monitor
EXERCISES = {
    "ships near, one run into": (
        f'{HEAD}duration_s = 1500\nsea = "sea-state-3"\n[initial]\nspeed_kn = 6\ndepth_m = 12\n'
        '[contacts]\ncollision = "freeze"\n'
        + CROSSING.format(name="clear", north=4000, east=9000)
        + CROSSING.format(name="near", north=1500, east=3150)
        + '[[orders]]\nat_s = 900\norder = "course 090"\n'
    ),
    "a sea at periscope depth, up and broached": (
        f'{HEAD}duration_s = 1800\nsea = "sea-state-6"\n[initial]\nspeed_kn = 5\ndepth_m = 18\n'
        "[limits]\ndepth_m_min = 16.0\npitch_deg_max = 2.0\n"
        '[[orders]]\nat_s = 300\norder = "depth 60"\n'
        '[[orders]]\nat_s = 900\norder = "depth 17"\n'
    ),
    "over a slope, aground": (
        f"{HEAD}duration_s = 1500\n[initial]\nspeed_kn = 6\ndepth_m = 60\n"
        "[limits]\nclearance_m_min = 25.0\n"
        "[bottom]\ndepth_m = 120\nslope_percent = 4\ndeepens_deg = 180\n"
        'grounding = "freeze"\n[[orders]]\nat_s = 600\norder = "depth 90"\n'
    ),
    "test depth passed by a limited engine, astern, out of the range": (
        f"{HEAD}duration_s = 2400\n[initial]\nspeed_kn = 6\ndepth_m = 200\n"
        '[[orders]]\nat_s = 60\norder = "depth 248"\n'
        '[[orders]]\nat_s = 60\norder = "bell ahead full"\n'
        '[[orders]]\nat_s = 1200\norder = "depth 120"\n'
        '[[orders]]\nat_s = 1500\norder = "rpm -40"\n'
    ),
}

Flown = tuple[Any, ...]


def one_by_one(patch: pytest.MonkeyPatch) -> None:
    """Have sessions take each tick by itself."""
    patch.setattr(QuietTicks, "fly", lambda *_: 0)


@pytest.fixture(params=EXERCISES)
def exercise(request: pytest.FixtureRequest, tmp_path: Path) -> Path:
    """Return the path of an exercise."""
    path = tmp_path / "quiet.toml"
    path.write_text(EXERCISES[request.param], encoding="utf-8")
    return path


def flown_by_calls(path: Path) -> Flown:
    """Return all that an exercise leaves, flown by calls."""
    with Boat(exercise=path) as boat:
        while boat.time < 1500.0:
            try:
                boat.run()
            except Exception as error:  # noqa: BLE001  a collision freezes
                assert "frozen" in str(error)  # noqa: PT017
        columns = {name: column.tobytes() for name, column in boat.columns.items()}
        monitors = boat._session.monitors  # noqa: SLF001
        limits, met = monitors.limits, monitors.limits.encounters
        left: list[Any] = [
            limits.times,
            limits.beyond,
            limits.shows,
            limits.validity,
            limits.followed,
        ]
        left += [met.closest, met.nearest, met.called, met._pose, met._past]  # noqa: SLF001
        left += [monitors.depths, monitors.pilot]
        return boat.events, boat.orders, boat.state, columns, repr(left)


@pytest.mark.long
def test_a_run_has_the_same_states_orders_and_events_as_tick_by_tick(
    exercise: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    at_once = flown_by_calls(exercise)
    one_by_one(monkeypatch)
    by_tick = flown_by_calls(exercise)

    assert by_tick[0]
    assert at_once == by_tick


def recorded(path: Path, folder: Path, name: str) -> Flown:
    """Return states, orders and events of a headless run of an exercise, from its recording."""
    file, rows = folder / f"{name}.trainer", folder / f"{name}.csv"
    run_boat(
        RunOptions(
            exercise=str(path), headless=True, speed=float("inf"), record=file, csv_path=rows
        )
    )
    with closing(Recording.look(file)) as recording:
        states = [(each.tick, each.state) for each in recording.flown(1)]
        orders = [(each.tick, each.text, each.answer) for each in recording.orders(1)]
        events = [(each.tick, each.kind, each.text) for each in recording.events()]
        timed = [each.work is not None and each.work > 0 for each in recording.flown(1)][1:]
    assert all(timed)
    return states, orders, events, rows.read_bytes()


@pytest.mark.slow
def test_its_recording_has_each_state_order_and_event(
    exercise: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    at_once = recorded(exercise, tmp_path, "at-once")
    one_by_one(monkeypatch)
    assert recorded(exercise, tmp_path, "by-tick") == at_once


def counting(patch: pytest.MonkeyPatch) -> Callable[[], int]:
    """Count the ticks that sessions take by themselves."""
    taken: list[int] = []
    tick = Session.tick

    def count(session: Session) -> None:
        taken.append(1)
        tick(session)

    patch.setattr(Session, "tick", count)
    return lambda: len(taken)


def test_most_ticks_of_a_quiet_hour_are_flown_at_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "ship.toml"
    ship = CROSSING.format(name="far", north=9000, east=9000)
    sea = 'sea = "sea-state-5"\n[initial]\nspeed_kn = 6\ndepth_m = 40\n'
    path.write_text(f"{HEAD}{sea}{ship}", encoding="utf-8")
    taken = counting(monkeypatch)
    with Boat(exercise=path) as boat:
        boat.run(3600)
        assert taken() < 360
        assert np.array_equal(boat.columns["tick"], np.arange(7201))
        assert boat._session.time.ledger.summary().ticks == 7200  # noqa: SLF001


def test_a_station_has_each_tick_to_itself(monkeypatch: pytest.MonkeyPatch) -> None:
    """Whoever is attached may order something before any tick, and sees each."""
    taken = counting(monkeypatch)
    with Boat() as boat:
        session = boat._session  # noqa: SLF001
        session.event_log.stations.append(session.event_log.stations)  # type: ignore[arg-type]
        for name in ("_spread", "take_up"):
            monkeypatch.setattr(session.event_log, name, lambda *_: None)
        monkeypatch.setattr(session.dispatch, "tell_plans", lambda: None)
        boat.run(100)
        assert taken() == 200
