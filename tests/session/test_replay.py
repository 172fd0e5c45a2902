"""A recording flown again: the same bits, or the first place where they are not."""

import contextlib
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.altered import alter, alter_number
from helpers.givers import giver_at
from helpers.orders import read_order
from helpers.sessions import NOISE_AND_FLOODING, TROUBLED_SEA, begin_run
from helpers.waiting import stay_for

from trainer.boat.boat import Boat
from trainer.boat.helm import obey_order
from trainer.config.files import ConfigError
from trainer.core.update import update
from trainer.debrief.passage.recording_export import table_layout
from trainer.io.orders.grammar import Order, Refused
from trainer.io.orders.words import BOAT_ORDERS
from trainer.io.recording.facts import BranchCause
from trainer.io.recording.recording import Moment, Recording
from trainer.session.past.header import differences
from trainer.session.past.layout import LAYOUT
from trainer.session.past.options import RunOptions
from trainer.session.replay import ReplayFlight, replay_anyway

EXERCISE = f"""{TROUBLED_SEA}
[[orders]]
at_s = 20
order = "course right 60"

{NOISE_AND_FLOODING}
[[casualties]]
when = "depth > 42"
name = "rudder-slow"
"""
# Given by hand at these ticks: the first, several at one, one refused, one at the last.
ORDERS_GIVEN = {
    0: ["depth 60"],
    30: ["pump trim forward 3 t", "hover on", "blow forward"],
    55: ["speed 40", "time x2", "casualty stern-slow 0.7 ramp 20"],
    90: ["freeze tanks", "casualty gyro-biased 0.5 ramp 10"],
    120: ["release tanks", "sea state 4", "surface"],
    160: ["rudder left 10"],
}
LAST = 160


class Run:
    """A boat recorded as a session records one."""

    def __init__(self, folder: Path, options: RunOptions) -> None:
        self.plan, self.boat, header = begin_run(options)
        self.path = folder / "run.trainer"
        self.recording = Recording.create(self.path, header, self.state)
        self.after = self.entry = 0

    @property
    def state(self) -> bytes:
        return self.boat.records.state.tobytes()

    @property
    def tick(self) -> int:
        return int(self.boat.state.tick)

    def give(self, order: Order, entry: int | None = None) -> None:
        number = self.recording.order(self.tick, giver_at("instructor"), order.text, entry)
        self.after = number
        if entry is not None:
            self.entry = entry + 1
        if order.name in BOAT_ORDERS:
            answer = obey_order(self.boat, order)
            refused = isinstance(answer, Refused)
            self.recording.answered(number, str(answer), not refused)

    def sail(self, until: int, orders: dict[int, list[str]]) -> None:
        """Take ticks until that one, giving what is due, also at the last."""
        while True:
            for place, entry in enumerate(self.plan.schedule):
                due = entry.seconds <= self.boat.time and place >= self.entry
                if due:
                    self.give(entry.order, place)
            for text in orders.get(self.tick, []):
                order = read_order(text)
                self.give(order)
            if self.tick == until:
                return
            with np.errstate(all="ignore"):
                assert self.boat.tick() == 0
            self.recording.state(self.tick, self.state)

    def now(self) -> Moment:
        return Moment(self.recording.branch, self.tick, self.state, self.after, self.entry)

    def go_back(self, moment: Moment, why: str) -> None:
        self.boat.restore(np.frombuffer(moment.state, self.boat.records.state.dtype))
        self.after, self.entry = moment.after, moment.entry
        self.recording.fork(moment, why)


@pytest.fixture
def run(tmp_path: Path) -> Iterator[Run]:
    """Return a run to tick LAST with sea, tanks, casualties and autopilot at work."""
    (tmp_path / "all.toml").write_text(EXERCISE)
    made = Run(tmp_path, options(exercise=str(tmp_path / "all.toml")))
    made.sail(LAST, ORDERS_GIVEN)
    yield made
    made.recording.close()


def options(**given: Any) -> RunOptions:
    """Return the command line's options with those given."""
    return RunOptions(**{"equations": "full", **given}, given=frozenset(given))


def looked_at(path: Path) -> list[ReplayFlight]:
    """Return how a recording flies that another program has written."""
    recording = Recording.look(path)
    flights = replay_anyway(recording)
    recording.close()
    return flights


# The same


def test_every_branch_is_flown_again_from_its_own_start(run: Run) -> None:
    # back to the middle by a moment of the recording, to the start, and to a moment that
    # includes orders of its own tick
    middle = run.recording.moment(1, 70)
    assert middle is not None
    run.go_back(middle, "backtrack")
    run.sail(100, {70: ["course 300"], 100: ["rudder right 5"]})
    kept = run.now()
    run.sail(130, {})
    start = run.recording.moment(1, 0)
    assert start is not None
    run.go_back(start, "reset")
    run.sail(40, {0: ["speed 12"]})
    run.go_back(kept, "restore")
    run.sail(150, {100: ["planes manual"], 110: ["freeze depth"], 140: ["release all"]})

    flights = replay_anyway(run.recording)

    assert [flight.branch.why for flight in flights] == [
        *("the start", "backtrack", "reset", "restore"),
    ]
    assert [flight.compared for flight in flights] == [LAST + 1, 60, 40, 50]
    assert all(flight.same for flight in flights)


# Not the same


def test_one_wrong_bit_of_one_state_is_named_by_tick_and_number(run: Run) -> None:
    run.recording.close()
    alter_number(run.path, "water_trim_forward", 2.0**-36, 77)
    (flight,) = looked_at(run.path)

    assert (flight.compared, flight.unequal) == (LAST + 1, 1)
    assert flight.parting is not None
    assert flight.parting.tick == 77
    name, recorded, flown, numbers = flight.parting.unlike
    assert (name, numbers) == ("water_trim_forward", 1)
    assert recorded == flown + 2.0**-36
    assert str(flight.parting) == (
        f"tick 77: water_trim_forward was {recorded!r}, is now {flown!r}"
    )
    assert not flight.same


def test_an_order_that_the_recording_lacks_parts_the_flight_for_good(run: Run) -> None:
    run.recording.close()
    alter(run.path, "DELETE FROM orders WHERE text LIKE 'blow forward%'")
    (flight,) = looked_at(run.path)

    assert flight.parting is not None
    assert flight.parting.tick == 31
    assert flight.unequal == LAST - 30
    assert flight.parting.unlike.numbers > 1
    assert "numbers more" in str(flight.parting)


@pytest.mark.parametrize(
    ("given", "accepted", "told"),
    [
        ("speed 40 kn", 1, "tick 55: speed 40 kn: hm; now: this boat's greatest speed is "),
        ("rudder left 10", 0, "tick 160: rudder left 10: hm; now: rudder left 10, by hand"),
    ],
)
def test_an_answer_that_is_not_the_recorded_one_is_told(
    run: Run, given: str, accepted: int, told: str
) -> None:
    run.recording.close()
    change = "UPDATE orders SET accepted = ?, answer = 'hm' WHERE text = ?"
    assert alter(run.path, change, accepted, given) == 1
    (flight,) = looked_at(run.path)

    assert len(flight.answers) == 1
    assert flight.answers[0].startswith(told)
    assert not flight.same
    assert flight.unequal == 0


def test_orders_after_the_last_state_are_given_each_at_its_tick(run: Run) -> None:
    run.sail(180, {180: ["rudder meet"]})  # which is refused where she does not swing
    run.recording.close()
    assert alter(run.path, "DELETE FROM states") == 180
    (flight,) = looked_at(run.path)

    assert flight.compared == 1
    assert flight.same, flight.answers


def test_a_state_of_another_tick_is_not_passed_over(run: Run) -> None:
    run.recording.close()
    alter_number(run.path, "tick", 1.0)
    (flight,) = looked_at(run.path)
    assert flight.compared == LAST + 1
    assert not flight.same


def test_lost_ticks_are_flown_to_the_state_after_them_where_no_order_is_lost(run: Run) -> None:
    run.recording.fork(run.now(), "not recorded", BranchCause.GAP)
    run.sail(170, {})
    run.recording.close()
    assert alter(run.path, "DELETE FROM states WHERE branch = 1 AND tick > 100") == 60
    flights = looked_at(run.path)
    assert [flight.compared for flight in flights] == [102, 10]
    assert all(flight.same for flight in flights)

    assert alter(run.path, "UPDATE orders SET text = 'rudder left 9' WHERE tick = 160") == 1
    assert alter(run.path, "DELETE FROM states WHERE branch = 1") == 100
    first, after = looked_at(run.path)
    assert (first.compared, first.unequal, after.same) == (2, 1, True)
    assert first.parting is not None
    assert first.parting.tick == 160

    assert alter(run.path, "DELETE FROM orders WHERE tick = 160") == 1
    first, _ = looked_at(run.path)
    assert (first.compared, first.same) == (1, True)


def test_a_state_cut_short_is_told_where_it_is_tabulated(run: Run) -> None:
    run.recording.close()
    with contextlib.closing(Recording.look(run.path)) as looked:
        numbers = table_layout(looked).numbers
        with pytest.raises(ConfigError, match=r"a state of 9 bytes, not of \d+: damaged"):
            numbers(bytes(9))


def test_a_state_cut_short_ends_its_branch_and_not_the_others(run: Run) -> None:
    middle = run.recording.moment(1, 70)
    assert middle is not None
    run.go_back(middle, "backtrack")
    run.sail(80, {})
    run.recording.close()
    alter(run.path, "UPDATE states SET state = x'00' WHERE branch = 1 AND tick = 20")
    first, second = looked_at(run.path)

    assert first.trouble == f"a state of 1 bytes, not of {8 * len(LAYOUT)}: damaged"
    assert first.compared == 21
    assert second.same


def test_a_boat_lost_on_the_way_ends_its_flight(run: Run) -> None:
    run.recording.close()
    alter_number(run.path, "v", 1e200)
    (flight,) = looked_at(run.path)

    assert "is out of all bounds after tick 0" in flight.trouble
    assert not flight.same


# Otherwise


def test_flown_with_another_step_the_orders_come_at_the_same_times(run: Run) -> None:
    middle = run.recording.moment(1, 90)
    assert middle is not None
    run.go_back(middle, "backtrack")
    run.sail(121, {})

    halved, other = replay_anyway(run.recording, {"step": 0.25})
    assert (halved.compared, other.compared) == (LAST + 1, 31)
    assert halved.trouble == other.trouble == ""
    doubled, other = replay_anyway(run.recording, {"step": 1.0})
    # the states of whole seconds
    assert (doubled.compared, other.compared) == (LAST // 2 + 1, 15)
    for flight in (halved, doubled):
        assert flight.answers == []  # every order was given, and answered as it was then
        assert flight.parting is not None
        assert flight.parting.unlike.name != "tick"


def test_another_step_ends_about_where_the_recorded_one_did(tmp_path: Path) -> None:
    made = Run(tmp_path, options())
    made.sail(240, {20: ["depth 80"], 41: ["course right 40"]})
    seen: list[tuple[float, float, float]] = []

    def noting(boat: Boat) -> int:
        status = update(*boat.records)
        s = boat.state
        seen.append((float(s.z), float(s.psi), float(s.x)))
        return status

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Boat, "tick", noting)
        (flight,) = replay_anyway(made.recording, {"step": 0.25})
    made.recording.close()

    s = made.boat.state
    depth, heading, north = seen[-1]
    assert len(seen) == 480
    assert flight.parting is not None
    assert flight.parting.unlike.name != "tick"  # four ticks where two were is no difference
    assert depth == pytest.approx(float(s.z), abs=0.5)
    assert heading == pytest.approx(float(s.psi), abs=0.02)
    assert north == pytest.approx(float(s.x), abs=5.0)


def test_flown_by_another_vessel_it_begins_as_that_one_does(run: Run, tmp_path: Path) -> None:
    text = run.plan.file.text
    assert text.count("\nlength = 70.2") == 1
    (tmp_path / "longer.toml").write_text(text.replace("\nlength = 70.2", "\nlength = 71"))

    (flight,) = replay_anyway(run.recording, {"vessel": str(tmp_path / "longer.toml")})

    assert flight.parting is not None
    assert flight.parting.tick == 0
    assert flight.trouble == ""


def test_a_recording_of_an_older_state_is_compared_in_what_it_has(
    run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    older = [name for name in LAYOUT if name != "sailed_y"]
    places = [LAYOUT.index(name) for name in older]
    header, branches = run.recording.header(), run.recording.branches()
    states = list(run.recording.states(1))

    def shorter(state: bytes) -> bytes:
        return np.frombuffer(state)[places].tobytes()

    header["layout"] = str(older).replace("'", '"')
    first = replace(branches[0], state=shorter(branches[0].state))
    monkeypatch.setattr(run.recording, "header", lambda: header)
    monkeypatch.setattr(run.recording, "branches", lambda: [first])
    monkeypatch.setattr(
        run.recording, "states", lambda _: ((tick, shorter(state)) for tick, state in states)
    )

    (told,) = differences(header)
    assert told.endswith("new: sailed_y; gone: none")
    (flight,) = replay_anyway(run.recording)

    assert flight.same
    assert flight.compared == LAST + 1


# Recordings that would take all memory, or all time

SERIES = "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n LIMIT {}) "
SWOLLEN = {
    "header": (6, "INSERT INTO header SELECT 'k' || i, printf('%.*c', 15000000, 'x') FROM n"),
    "branches": (
        1500,
        "INSERT INTO branches SELECT 9 + i, 1, 0, 0, 0, '', zeroblob(60000), '', 'jump' FROM n",
    ),
    "orders": (
        9000,
        (
            "INSERT INTO orders SELECT 99 + i, 1, 9, i, printf('%.*c', 9000, 'x'), 0, 1, i, i, "
            "'station', i, 0, '', '' FROM n"
        ),
    ),
    "events": (
        9000,
        (
            "INSERT INTO events "
            "SELECT 999 + i, 1, 9, 'mark', '', printf('%.*c', 9000, 'x'), '', '' FROM n"
        ),
    ),
    "snapshots": (
        3000,
        "INSERT INTO snapshots SELECT 9 + i, 'n' || i, 1, 9, zeroblob(60000), 0, 0, '' FROM n",
    ),
}
BOUND = 200_000  # [kB] above what a replay of an empty recording takes


def taken(path: Path) -> int:
    """Return the memory [kB] that `trainer replay` of a recording takes."""
    replay = subprocess.Popen(
        [sys.executable, "-m", "trainer", "replay", str(path)],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    _, status, used = os.wait4(replay.pid, 0)
    replay.returncode = os.waitstatus_to_exitcode(status)
    assert replay.returncode in (0, 1, 2)
    return used.ru_maxrss


@pytest.mark.process
@pytest.mark.skipif(sys.platform != "linux", reason="other units of memory elsewhere")
@pytest.mark.parametrize(
    "what",
    [pytest.param(what, marks=[] if what == "events" else pytest.mark.slow) for what in SWOLLEN],
)
def test_a_recording_takes_a_bounded_memory_whatever_is_in_it(run: Run, what: str) -> None:
    run.recording.close()
    empty = taken(run.path)
    count, statement = SWOLLEN[what]
    alter(run.path, SERIES.format(count) + statement)
    assert run.path.stat().st_size > 50_000_000
    assert taken(run.path) < empty + BOUND


@pytest.mark.process
@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
def test_ctrl_c_ends_a_long_question_to_a_recording(tmp_path: Path) -> None:
    code = (
        "import sqlite3, sys; from pathlib import Path\n"
        "from trainer.io.recording import file as f\n"
        "f.create(Path(sys.argv[1]), {}, b'').close()\n"
        "with f.understanding('it'):\n"
        "    c = f.connect(Path(sys.argv[1]), 'mode=rw'); print('now', flush=True)\n"
        "    c.execute('WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n) '\n"
        "              'SELECT count(*) FROM n').fetchall()\n"
    )
    asking = subprocess.Popen(
        [sys.executable, "-c", code, str(tmp_path / "it.trainer")],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    with asking:
        assert asking.stdout
        assert asking.stdout.readline() == "now\n"
        stay_for(asking, 0.5)  # it is asking
        asking.send_signal(signal.SIGINT)
        try:
            _, told = asking.communicate(timeout=60)
        finally:
            asking.kill()
    assert "KeyboardInterrupt" in told
