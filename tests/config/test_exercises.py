"""Exercises: their files, the shipped ones run without a crew and with one."""

import json
import math
import re
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.places import ROOT

from trainer.boat.boat import Boat
from trainer.boat.casualties import active
from trainer.boat.helm import obey
from trainer.boat.limits import NOTICES, LimitMonitor
from trainer.config.exercise import Exercise, key_tables, load_exercise, parse_exercise
from trainer.config.files import ConfigError, shipped_names
from trainer.io.line import Joined
from trainer.io.orders.grammar import Order, Refused, parse
from trainer.io.orders.schedule import Scheduled
from trainer.io.recording.recording import NoRecording
from trainer.session.history import History
from trainer.session.options import RunOptions
from trainer.session.plan import plan_run
from trainer.session.session import Session
from trainer.session.stations.access import Access
from trainer.session.stations.station import Station
from trainer.session.stations.subscriptions import Promptly, Roster
from trainer.session.stations.view import StateReader
from trainer.session.time.pacer import MonotonicClock, Policy
from trainer.session.time.timekeeping import Timekeeping
from trainer.units import KNOT

NAMES = (
    *("air-bank-failure", "course-changes", "crash-stop", "depth-changes", "depth-gauge-failure"),
    *("emergency-deep", "flooding-aft", "heavy-boat", "loss-of-propulsion", "periscope-depth"),
    *("steering-jam", "stern-plane-jam"),
)
SHORTEST = 'schema = "exercise/1"\nname = "Drill"\nbriefing = "Steer."\n'
OPTIONS = RunOptions()
COLUMNS = ("t", "z", "psi", "u", "theta", "phi", "delta_s", "delta_b", "weight")


@dataclass
class Trace:
    """A recorder that keeps the rows."""

    rows: list[Sequence[float]] = field(default_factory=list)
    trouble: str = ""

    def row(self, values: Sequence[float]) -> None:
        self.rows.append(values)


@dataclass
class Ear:
    """A console's sender that keeps what is said."""

    said: list[str] = field(default_factory=list)
    dropped: int = 0
    trouble: str = ""

    def send(self, line: str) -> None:
        self.said.append(line)

    def close(self, _seconds: float) -> None:
        pass


@dataclass
class Played:
    """How an exercise went."""

    boat: Boat
    monitor: LimitMonitor
    said: list[str]
    trace: dict[str, np.ndarray]

    def at(self, name: str, seconds: float) -> float:
        """Return a column at a time, in its own unit."""
        return float(self.trace[name][round(seconds / self.boat.method.step)])


def play(name: str, crew: str = "") -> Played:
    """Play an exercise at full speed with the orders of a crew, lines of SECONDS ORDER."""
    plan = plan_run(RunOptions(exercise=name))
    boat = Boat(plan.file, plan.method)
    plan.start(boat)
    monitor = LimitMonitor.over(boat, plan.limits)
    schedule = list(plan.schedule)
    for line in crew.strip().splitlines():
        seconds, words = line.split(maxsplit=1)
        order = parse(words)
        assert isinstance(order, Order), line
        schedule.append(Scheduled(float(seconds), order, 0))
    schedule.sort(key=lambda entry: entry.seconds)
    trace, ear = Trace(), Ear()
    time = Timekeeping.at(MonotonicClock(), plan.method.step, math.inf, Policy.SLIP)
    assert plan.duration is not None
    last = round(plan.duration / plan.method.step)
    sending = Promptly(Roster(StateReader(boat, time.ledger.summary)))
    history = History(boat, NoRecording())
    session = Session(
        boat, time, history, trace, COLUMNS, sending, schedule=schedule, monitor=monitor
    )
    session.last_tick = last
    line = Joined("ear", None, ear)  # type: ignore[assignment]
    session.event_log.stations.append(
        Station(line, Access("instructor"), sending, session.event_log.log)  # type: ignore[arg-type]
    )
    with np.errstate(all="ignore"):
        session.run()
    failure = session.control.failure
    assert failure.startswith("collapse") or failure == ""
    assert boat.state.tick == last or failure
    assert not [line for line in ear.said if "refused" in line]
    columns = np.array(trace.rows).T
    return Played(boat, monitor, ear.said, dict(zip(COLUMNS, columns, strict=True)))


def bb2() -> Boat:
    """Return BB2, not yet started."""
    plan = plan_run(OPTIONS)
    return Boat(plan.file, plan.method)


def degrees(angle: float) -> float:
    return math.degrees(angle)


# Without a crew


def test_twelve_exercises_are_shipped() -> None:
    assert shipped_names("exercises") == NAMES


@pytest.mark.parametrize("name", NAMES)
def test_a_shipped_exercise_says_what_is_expected_on_a_narrow_console(name: str) -> None:
    heading = load_exercise(name).heading
    assert "Win: " in heading.briefing
    assert max(map(len, heading.briefing.splitlines())) <= 79
    assert heading.duration_s
    assert heading.duration_s <= 1800.0


def test_depths_are_changed_and_reached_within_the_limits() -> None:
    went = play("depth-changes")
    assert went.at("z", 360) == pytest.approx(100.0, abs=1.0)
    assert went.at("z", 1080) == pytest.approx(40.0, abs=1.0)
    assert went.monitor.times == {}


def test_courses_are_changed_the_way_that_was_ordered() -> None:
    went = play("course-changes")
    assert degrees(went.at("psi", 360)) == pytest.approx(90.0, abs=1.0)
    assert degrees(went.at("psi", 660)) == pytest.approx(180.0, abs=1.0)
    assert degrees(went.at("psi", 1200)) == pytest.approx(0.0, abs=1.0)
    assert went.monitor.times == {}


def test_a_heavy_boat_is_carried_by_its_planes() -> None:
    went = play("heavy-boat")
    assert went.at("z", 1800) == pytest.approx(80.0, abs=1.0)
    assert degrees(went.at("delta_s", 1800)) < -3.0
    assert degrees(went.at("delta_b", 1800)) > 15.0
    assert set(went.monitor.times) == set()


def test_at_periscope_depth_in_sea_state_6_the_slow_boat_broaches() -> None:
    went = play("periscope-depth")
    fast, slow = went.trace["z"][400:720], went.trace["z"][1200:]
    assert fast.min() > 13.0
    assert slow.min() < 13.0
    assert went.monitor.times["broached"][0] > 360.0
    assert any("BROACHED" in line for line in went.said)


def test_a_jam_of_the_stern_planes_is_noticed_and_costs_depth() -> None:
    went = play("stern-plane-jam")
    assert degrees(went.at("delta_s", 90)) == pytest.approx(6.0, abs=0.1)  # the tail's own sign
    assert degrees(went.trace["theta"].min()) < -20.0
    assert went.trace["z"].max() > 140.0
    assert went.at("z", 600) == pytest.approx(100.0, abs=1.0)
    assert set(went.monitor.times) - NOTICES == {"pitch above 20 deg", "depth above 130 m"}


def test_flooding_aft_takes_a_boat_down_by_the_stern_that_nobody_helps() -> None:
    went = play("flooding-aft")
    assert went.at("weight", 240) - went.at("weight", 0) == pytest.approx(33e4, rel=0.1)
    assert degrees(went.at("theta", 300)) > 15.0
    assert "depth above 180 m" in went.monitor.times
    assert went.trace["z"].max() > 350.0


def test_a_boat_that_loses_her_propeller_loses_way_and_sinks_until_it_turns_again() -> None:
    went = play("loss-of-propulsion")
    assert went.at("z", 480) == pytest.approx(70.0, abs=0.5)
    assert went.at("u", 1200) < 2.5 * KNOT
    assert went.trace["z"].max() > 79.0
    assert went.at("z", 1500) == pytest.approx(70.0, abs=1.0)


def test_a_blow_that_loses_its_bank_does_not_bring_the_boat_up() -> None:
    went = play("air-bank-failure")
    bank = went.boat.state.bank_main / went.boat.vessel.bank_full[0]
    assert 0.5 < bank < 0.99
    assert went.trace["z"].min() > 80.0
    assert went.at("z", 600) > 130.0


# The same, won by a crew


CREWS = {
    "heavy-boat": "700 pump depth-control 8\n700 pump trim aft 3",
    "periscope-depth": "361 speed 7",
    "stern-plane-jam": """
        66 bell astern full
        66 bow planes rise 30
        72 blow forward
        112 vent forward open
        115 blow stop
        115 planes auto
        115 speed 10""",
    "flooding-aft": """
        80 speed 12
        80 drain aft
        80 pump depth-control 15
        100 blow aft
        125 blow stop""",
    "loss-of-propulsion": "490 pump depth-control 3\n1000 hover on\n1230 hover off\n1260 depth 70",
    "air-bank-failure": "120 emergency blow\n300 blow stop",
}


@pytest.mark.parametrize(("name", "crew"), CREWS.items())
def test_an_exercise_can_be_won_by_hand(name: str, crew: str) -> None:
    won = {"air-bank-failure": {"surfaced"}}.get(name, set())
    went = play(name, crew)
    assert set(went.monitor.times) - NOTICES <= won
    end = {"heavy-boat": 80.0, "stern-plane-jam": 100.0, "flooding-aft": 150.0}
    end |= {"loss-of-propulsion": 70.0, "periscope-depth": 17.5, "air-bank-failure": 4.3}
    assert went.trace["z"][-1] == pytest.approx(end[name], abs=1.0)
    assert abs(degrees(float(went.trace["theta"][-1]))) < 6.0


# Orders about casualties


@pytest.mark.parametrize(
    ("line", "amount", "seconds"),
    [
        ("casualty propulsion-lost", 1.0, 10.0),
        ("casualty propulsion-lost 0.5", 0.5, 10.0),
        ("casualty propulsion-lost ramp 30", 1.0, 30.0),
        ("casualty propulsion-lost 0.5 ramp 30", 0.5, 30.0),
    ],
)
def test_a_casualty_is_as_severe_and_sudden_as_ordered_else_as_its_table_says(
    line: str, amount: float, seconds: float
) -> None:
    boat = bb2()
    plan_run(OPTIONS).start(boat)
    order, clear = parse(line), parse("clear propulsion-lost")
    assert isinstance(order, Order)
    assert isinstance(clear, Order)
    assert isinstance(obey(boat, order), str)
    (found,) = active(boat)
    assert (found.kind, found.target, found.seconds) == ("propulsion-lost", amount, seconds)

    assert isinstance(obey(boat, clear), str)
    assert isinstance(obey(boat, replace(clear, subject="propulsion-stuck")), Refused)
    for _ in range(200):
        assert boat.tick() == 0
    assert active(boat) == []


def test_an_unknown_casualty_is_answered_with_the_nearest() -> None:
    order = parse("casualty propulsion-los")
    assert isinstance(order, Order)
    answer = obey(bb2(), order)
    assert isinstance(answer, Refused)
    assert answer.reason.endswith("nearest is propulsion-lost")


# Files


def drill(text: str) -> Exercise:
    return parse_exercise(SHORTEST + text, Path("drill.toml"))


def test_the_shortest_file_is_complete() -> None:
    exercise = drill("")
    assert exercise.heading.name == "Drill"
    assert (exercise.schedule, exercise.armed, exercise.sea) == ((), (), None)


def test_what_happens_at_set_times_is_in_order_of_time() -> None:
    exercise = drill(
        '[[orders]]\nat_s = 90\norder = "depth 80"\n'
        '[[casualties]]\nname = "rudder-slow"\nseverity = 0.123456789\nramp_s = 12.5\n'
        "at_s = 30\nclear_at_s = 60\n"
    )
    assert [(e.seconds, e.order.name, e.order.text) for e in exercise.schedule] == [
        (30.0, "casualty", "casualty rudder-slow 0.123457 ramp 12.5 s"),
        (60.0, "clear", "clear rudder-slow"),
        (90.0, "depth", "depth 80 m"),
    ]
    assert exercise.schedule[0].order.numbers == (0.123456789, 12.5)
    assert exercise.schedule[0].order.word == "ramp"


def test_a_casualty_waits_for_its_condition() -> None:
    exercise = drill('[[casualties]]\nname = "flooding-aft"\nseverity = 0.5\nwhen = "depth > 61"\n')
    boat = bb2()
    replace(plan_run(OPTIONS), armed=exercise.armed).start(boat)
    boat.state.ordered_depth = 70.0
    for _ in range(600):
        assert boat.state.flood_aft == 0.0 or boat.state.z > 60.9
        if boat.state.z > 62.0:
            break
        assert boat.tick() == 0
    assert boat.state.flood_aft > 0.0


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("sead = 1", "drill.toml: sead = 1: no such key; nearest is sea"),
        ("[order]", "drill.toml: order = {}: no such key; nearest is orders"),
        ("seed = 1.5", "seed = 1.5: must be a whole number"),
        ("step_s = 5", "step_s = 5: must be 0.001 to 2 s"),
        ("duration_s = 0", "duration_s = 0: must be 0.001 to"),
        ('equations = "ful"', 'equations = "ful": must be full or modified or basic'),
        ("[initial]\nspeed_kn = 0", "[initial] speed_kn = 0: must be 0.001 to 60 kn"),
        ("[initial]\ndeth_m = 9", "[initial] deth_m = 9: no such key; nearest is depth_m"),
        ("[limits]\ndepth_max = 9", "[limits] depth_max = 9: no such key; nearest is depth_m_max"),
        ("[sea]\nsea_state = 9", "[sea] sea_state = 9: must be 0 to 8"),
        ("[sea]", "[sea] has none of them: give one of sea_state, wind_kn, height_m"),
        ('sea = "sea-state-55"', 'no sea "sea-state-55"; nearest is sea-state-5'),
        (
            "[[orders]]\nat_s = 1\norder = 'rudder lefy 15'",
            '[orders[0]] order = "rudder lefy 15": "lefy" after "rudder"; did you mean left?',
        ),
        ("[[orders]]\nat_s = 1\norder = 'status'", 'order = "status": has no place in a schedule'),
        ("[[orders]]\nat_s = 1\norder = '#'", 'order = "#": is no order'),
        ("[[orders]]\norder = 'freeze'", "[orders[0]] lacks at_s"),
        ("orders = 5", "orders = 5: must be 0 to 500 tables [[orders]]"),
        (
            "[[casualties]]\nname = 'ruder-slow'\nat_s = 1",
            '[casualties[0]] name = "ruder-slow": no such casualty; nearest is rudder-slow',
        ),
        ("[[casualties]]\nname = 'rudder-slow'", "[casualties[0]] give one of at_s, when"),
        (
            "[[casualties]]\nname = 'rudder-slow'\nat_s = 1\nwhen = 'depth > 9'",
            "[casualties[0]] give one of at_s, when",
        ),
        (
            "[[casualties]]\nname = 'rudder-slow'\nat_s = 9\nclear_at_s = 5",
            "clear_at_s = 5.0: is before at_s",
        ),
        (
            "[[casualties]]\nname = 'rudder-slow'\nat_s = 9\nrule = 'again'",
            'rule = "again": goes with when',
        ),
        (
            "[[casualties]]\nname = 'rudder-slow'\nat_s = 9\nseverity = 5",
            "[casualties[0]] severity = 5.0: must be above 0 to 1 for rudder-slow",
        ),
        (
            "[[casualties]]\nname = 'rudder-stuck'\nat_s = 9\nramp_s = 5",
            "[casualties[0]] ramp_s = 5.0: rudder-stuck comes at once",
        ),
        ("[[casualties]]\nname = 'rudder-slow'\nwhen = 'deph > 9'", "nearest is depth"),
    ],
)
def test_a_wrong_file_is_refused_with_table_key_value_and_limit(text: str, message: str) -> None:
    with pytest.raises(ConfigError) as wrong:
        drill(text)
    assert any(message in problem for problem in wrong.value.problems), wrong.value.problems
    assert all(
        problem.startswith(("drill.toml: ", "no sea")) and "\n" not in problem
        for problem in wrong.value.problems
    )


def test_all_that_is_wrong_is_told_at_once() -> None:
    with pytest.raises(ConfigError) as wrong:
        drill("step_s = 5\n[initial]\nspeed_kn = 0\n[[orders]]\nat_s = 1\norder = 'x'\n")
    assert len(wrong.value.problems) == 3


@pytest.mark.parametrize("briefing", ["5", '""', '"\\u001b[2J"', f'"{"x" * 4001}"'])
def test_a_briefing_is_printable_text_of_some_length(briefing: str) -> None:
    text = f'schema = "exercise/1"\nname = "Drill"\nbriefing = {briefing}\n'
    with pytest.raises(ConfigError, match="must be printable text of 1 to 4000 characters"):
        parse_exercise(text, Path("drill.toml"))


def test_a_name_that_is_nearly_right_is_answered_with_the_right_one() -> None:
    with pytest.raises(ConfigError, match='no exercise "heavyboat"; nearest is heavy-boat; shipp'):
        load_exercise("heavyboat")


def test_files_that_an_exercise_names_are_looked_for_beside_it(tmp_path: Path) -> None:
    (tmp_path / "swell.toml").write_text("[sea]\nheight_m = 2\n")
    (tmp_path / "mine.toml").write_text('[casualty.my-leak]\nkind = "leak-auxiliary"\n')
    (tmp_path / "drill.toml").write_text(
        f"{SHORTEST}sea = './swell.toml'\nvessel = './boat.toml'\ncasualty_table = 'mine.toml'\n"
        "[[casualties]]\nname = 'my-leak'\nat_s = 5\n"
    )
    exercise = load_exercise(str(tmp_path / "drill.toml"))
    assert exercise.sea
    assert exercise.sea.sea.height_m == 2.0
    assert exercise.heading.vessel == str(tmp_path / "boat.toml")
    assert "my-leak" in exercise.casualties
    boat = bb2()
    plan = replace(plan_run(OPTIONS), casualties=exercise.casualties)
    plan.start(boat)
    assert obey(boat, exercise.schedule[0].order) == "casualty my-leak, severity 1 within 5 s"


# What overrules what


def test_the_command_line_overrules_the_exercise_and_the_exercise_the_vessel(
    tmp_path: Path,
) -> None:
    path = tmp_path / "drill.toml"
    path.write_text(
        f'{SHORTEST}vessel = "sdv-mk9"\nequations = "full"\nstep_s = 0.1\nseed = 9\n'
        'duration_s = 60\nintegrator = "rk4"\n[initial]\nspeed_kn = 4\n[sea]\nsea_state = 2\n'
    )
    said = RunOptions(exercise=str(path))
    plan = plan_run(said)
    assert plan.file.path.stem == "sdv-mk9"
    assert (plan.method.equations, plan.method.step, plan.method.rates) == ("full", 0.1, "exact")
    assert (plan.seed, plan.duration, plan.sea.sea.sea_state) == (9, 60.0, 2.0)

    given: dict[str, Any] = {"vessel": "remus100", "equations": "basic", "step": 0.05, "seed": 2}
    given |= {"duration": 5.0, "integrator": "euler"}
    plan = plan_run(replace(said, **given, given=frozenset(given), sea="sea-state-1"))
    assert plan.file.path.stem == "remus100"
    assert (plan.method.equations, plan.method.step, plan.method.rates) == ("basic", 0.05, "lagged")
    assert (plan.seed, plan.duration, plan.sea.sea.sea_state) == (2, 5.0, 1.0)
    assert plan.initial.speed_kn == 4.0


def test_what_nobody_says_is_the_vessels_own() -> None:
    boat = bb2()
    plan_run(OPTIONS).start(boat)
    s = boat.state
    assert (s.u, s.z, s.psi, s.seed, s.sea_height) == (10.0 * KNOT, 60.0, 0.0, 1.0, 0.0)


# The command


def ran(*words: str, typed: str = "") -> "subprocess.CompletedProcess[str]":
    return subprocess.run(
        [sys.executable, "-c", "from trainer.cli.main import main; main()", *words],
        input=typed,
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )


def test_a_run_of_an_exercise_begins_with_its_briefing_and_ends_by_itself() -> None:
    done = ran("run", "stern-plane-jam", "--speed", "max", typed="help\n")
    assert done.returncode == 0
    lines = done.stdout.splitlines()
    briefing = load_exercise("stern-plane-jam").heading.briefing.splitlines()
    assert lines[: 1 + len(briefing)] == ["Stern planes jam to dive at 15 knots", *briefing]
    assert "15 kn, 100 m, course 000; modified set, step 0.5 s" in lines
    assert "[60 s] casualty stern-hard-over -0.2: casualty stern-hard-over, severity -0.2" in lines
    assert re.search(r"\ntick 2\d\d \(1\d\d.*s\): LIMIT: depth above 130 m\n", done.stdout)
    assert "simulated   600.0 s in 1200 ticks" in done.stderr
    assert "events      pitch above 20 deg 1 time" in done.stderr


def test_a_headless_run_names_its_events_in_the_summary() -> None:
    done = ran(
        *("run", "periscope-depth", "--headless", "--speed", "max", "--duration", "17m"),
        *("--vessel", "bb2"),
    )
    assert done.returncode == 0
    assert re.search(r"events .*broached \d+ times? \(first at 9\d\d", done.stdout)


def test_a_wrong_exercise_or_sea_ends_with_code_2_and_one_line() -> None:
    for words in (("run", "heavyboat"), ("run", "--sea", "sea-state-55")):
        done = ran(*words)
        assert done.returncode == 2
        assert "nearest is" in done.stderr
        assert len(done.stderr.splitlines()) == 1


def test_the_lists_name_everything_in_79_columns() -> None:
    exercises, casualties = ran("exercises"), ran("casualties")
    assert [line.split()[0] for line in exercises.stdout.splitlines()] == list(NAMES)
    assert "stern-hard-over" in casualties.stdout
    assert max(map(len, exercises.stdout.splitlines())) <= 79
    assert list(json.loads(ran("exercises", "--json").stdout)) == list(NAMES)
    assert json.loads(ran("casualties", "--json").stdout)[0]["name"] == "rudder-slow"


# The page


def page() -> str:
    return (ROOT / "docs" / "exercises.md").read_text(encoding="utf-8")


def test_the_page_has_the_table_of_every_key() -> None:
    assert key_tables() in page()


def test_the_exercises_of_the_page_are_exercises() -> None:
    found = re.findall(r"```toml\n(.*?)```", page(), re.DOTALL)
    assert len(found) >= 2
    for text in found:
        assert parse_exercise(text, Path("page.toml")).schedule


def test_the_page_names_every_shipped_exercise() -> None:
    assert all(f"`{name}`" in page() for name in NAMES)


def test_a_sea_above_nyquist_for_the_step_is_refused_before_the_run(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"^sea-state-3\.toml: a sea above Nyquist for the step"):
        plan_run(RunOptions(sea="sea-state-3", step=1.0, given=frozenset({"sea", "step"})))
    drill = tmp_path / "drill.toml"
    drill.write_text('schema = "exercise/1"\nname = "x"\nbriefing = "y"\n[sea]\nheight_m = 0.05\n')
    with pytest.raises(ConfigError, match=r"^drill\.toml: a sea above Nyquist for the step"):
        plan_run(RunOptions(exercise=str(drill)))
