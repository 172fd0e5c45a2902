"""Exercises: their files, what is drawn by the seed, and their command."""

import json
import math
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.nursery import Done, run_trainer
from helpers.orders import read_order
from helpers.places import ROOT

from trainer.authoring.exercise_page import check_exercise
from trainer.boat.boat import Boat
from trainer.boat.casualties import active_casualties
from trainer.boat.helm import obey_order
from trainer.config.exercise.course import course
from trainer.config.exercise.course import lessons as step_lessons
from trainer.config.exercise.exercise import (
    AUTOMATIC_ORDERS,
    Exercise,
    load_exercise,
    parse_exercise,
)
from trainer.config.files import ConfigError, read_text, shipped_names, shipped_path
from trainer.io.orders.grammar import Order, Refused, parse
from trainer.session.past.options import RunOptions
from trainer.session.past.plan import plan_run
from trainer.units import KNOT

NAMES = (
    *("air-bank-failure", "backing", "bottoming", "canyon", "course-changes", "crash-stop"),
    *("crossing-traffic", "depth-changes", "depth-gauge-failure", "emergency-deep"),
    *("fire-aft", "first-depth-change", "flooding-aft", "grounding-forward", "gyro-stuck"),
    *("heavy-boat", "hover-by-pump", "leaking-leg", "loss-of-propulsion", "main-oil-lost"),
    *("ordered-bubble", "periscope-approach", "periscope-depth", "periscope-sea-3"),
    *("port-bus-lost", "power-loss", "rise-jam-shallow", "steady-course", "steering-jam"),
    *("stern-plane-jam", "stern-servo", "surface-and-steer", "visitor-dive", "watch"),
)
KEPT_ALONE = "[[scores]]\nname = 'a'\nmeasure = 'broaches'\nfull = 0\nzero = 1\npart = 'keeping'\n"
SHORTEST = 'schema = "exercise/1"\nname = "Drill"\nbriefing = "Steer."\n'
OPTIONS = RunOptions()


def bb2() -> Boat:
    """Return BB2, not yet started."""
    plan = plan_run(OPTIONS)
    return Boat(plan.file, plan.method)


# Those shipped: tests/analysis/test_exercises_flown.py flies them


def test_the_lessons_and_a_visitors_dive_are_shipped_and_no_companion_is_one() -> None:
    assert shipped_names("exercises") == NAMES
    assert [each.name for each in course() if each.number == math.inf] == ["visitor-dive"]
    assert (ROOT / "configs" / "exercises" / "watch.baseline.toml").exists()


@pytest.mark.parametrize("name", NAMES)
def test_a_shipped_exercise_says_who_works_what_and_ends_within_half_an_hour(name: str) -> None:
    exercise = load_exercise(name)
    assert exercise.heading.hand
    assert exercise.crew.rules
    assert exercise.heading.duration_s
    assert exercise.heading.duration_s <= 1800.0


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
    assert isinstance(obey_order(boat, order), str)
    (found,) = active_casualties(boat)
    assert (found.kind, found.target, found.seconds) == ("propulsion-lost", amount, seconds)

    assert isinstance(obey_order(boat, clear), str)
    assert isinstance(obey_order(boat, replace(clear, subject="propulsion-stuck")), Refused)
    for _ in range(200):
        assert boat.tick() == 0
    assert active_casualties(boat) == []


def test_an_unknown_casualty_is_answered_with_the_nearest() -> None:
    order = read_order("casualty propulsion-los")
    answer = obey_order(bb2(), order)
    assert isinstance(answer, Refused)
    assert answer.reason.endswith("nearest is propulsion-lost")


# Files


def drill(text: str) -> Exercise:
    return parse_exercise(SHORTEST + text, Path("drill.toml"))


def test_the_shortest_file_is_complete() -> None:
    exercise = drill("")
    assert exercise.heading.name == "Drill"
    assert (exercise.schedule, exercise.armed, exercise.sea) == ((), (), None)
    assert (exercise.lost, exercise.crew.rules, exercise.drawn) == ((), (), ())


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
        ("sead = 1", "drill.toml: line 4: sead = 1: no such key; nearest is sea"),
        ("[order]", "drill.toml: line 4: order = {}: no such key; nearest is orders"),
        ("seed = 1.5", "seed = 1.5: must be a whole number"),
        ("step_s = 5", "step_s = 5: must be 0.001 to 2 s"),
        ('equations = "ful"', 'equations = "ful": must be full or modified or basic'),
        ("[sea]", "[sea] has none of them: give one of sea_state, wind_kn, height_m"),
        (
            'sea = "sea-state-55"',
            'drill.toml: line 4: sea = "sea-state-55": no sea "sea-state-55"; ',
        ),
        ('vessel = "bb3"', 'line 4: vessel = "bb3": no vessel "bb3"; nearest is bb2'),
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
        ("[[casualties]]\nname = 'rudder-slow'\nwhen = 'heavy > 9'", "no quantity 'heavy'"),
        (
            "[[casualties]]\nname = 'rudder-slow'\nwhen = 'depth > 9'\nwithin_s = 5",
            "within_s = 5.0: goes with at_s",
        ),
        (
            "[[casualties]]\nname = 'rudder-slow'\nwhen = 'depth > 9'\nlasts_s = 5",
            "lasts_s = 5.0: goes with at_s: a run is planned before when is known to come",
        ),
        (
            "[[casualties]]\nname = 'rudder-slow'\nat_s = 1\nclear_at_s = 9\nlasts_s = 5",
            "give one of clear_at_s, lasts_s",
        ),
        ("hand = ['ruder']", 'hand = ["ruder"]: must list some of rudder, planes, speed'),
        ("allowed = ['dive']", 'allowed = ["dive"]: must list some of course'),
        ("lost = ['deph > 100']", "lost = \"deph > 100\": no quantity 'deph'; nearest is depth"),
        ("lost = 5", "lost = 5: must be a list of 8 texts at most"),
        (
            "hand = ['rudder']\n[[orders]]\nat_s = 1\norder = 'order depth 80'",
            '[orders[0]] order = "order depth 80": nobody mans it',
        ),
        (
            "hand = ['rudder']\n" + KEPT_ALONE,
            '[[scores]] have no part = "task": nothing wins this exercise',
        ),
        ("[[crew]]\nat_s = 1\norder = 'rudder lefy 5'", "did you mean left?"),
        ("[[crew]]\nat_s = 1\norder = 'planesman of'", "say on or off; nearest is planesman of"),
        ("[[crew]]\nat_s = 1\norder = 'clear all'", "no crew orders that"),
        ("[[crew]]\nwhen = 'heavy > 2'\norder = 'bell stop'", "no gauge shows heavy"),
        ("[[crew]]\nwhen = 'east > 2'\norder = 'bell stop'", "no gauge shows east"),
        ("[[crew]]\nwhen = 'north > 2'\norder = 'bell stop'", "no gauge shows north"),
        ("[[crew]]\nwhen = 'deph > 2'\norder = 'bell stop'", "no quantity 'deph'; nearest is dep"),
        ("[[crew]]\norder = 'bell stop'", "give one of at_s, when, ordered, or then = true"),
        ("[[crew]]\nthen = true\norder = 'bell stop'", "there is no rule above"),
        ("[[crew]]\nat_s = 1\nmean_s = 5\norder = 'bell stop'", "mean_s = 5.0: goes with when"),
        ("[crew]\nat_s = 1\norder = 'bell stop'", "one reference crew, its rules [[crew]]"),
        (
            2 * "[[crew]]\nat_s = 1\norder = 'bell stop'\n",
            '[crew[1]] order = "bell stop": is a rule above too; an exercise has one reference',
        ),
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


@pytest.mark.parametrize(
    ("crew", "orders"),
    [
        ("course 045", ("course 045", "course right 20", "course left to 045")),
        ("depth 80", ("depth 80", "periscope depth", "hover on")),
        ("periscope depth", ("depth 80", "periscope depth", "hover on")),
        ("speed 8", ("speed 8",)),
    ],
)
def test_whatever_keeps_what_the_crew_is_ordered_mans_it(
    crew: str, orders: tuple[str, ...]
) -> None:
    names = {order.name for order in map(parse, orders) if isinstance(order, Order)}
    assert {each for each in AUTOMATIC_ORDERS if each in names} == names
    for name in names:
        drill(f"allowed = ['{name}']\n[[orders]]\nat_s = 1\norder = 'order {crew}'")


@pytest.mark.parametrize("order", ["planes emergency", "planes zero", "stern planes emergency"])
def test_a_crew_may_order_both_pairs_which_is_no_planesman(order: str) -> None:
    (rule,) = drill(f"[[crew]]\nat_s = 1\norder = '{order}'\n").crew.rules
    assert rule.order == parse(order)


def test_each_mistake_is_told_with_its_line() -> None:
    with pytest.raises(ConfigError) as wrong:
        drill(
            "step_s = 5\nlost = ['z > 5']\n[initial]\nspeed_kn = 0\n[[orders]]\nat_s = 1\n"
            "order = 'freeze'\n\n[[orders]]\nat_s = 2\norder = 'x'\n"
        )
    lines = [problem.removeprefix("drill.toml: ")[:8] for problem in wrong.value.problems]
    assert sorted(lines) == ["line 14:", "line 4: ", "line 5: ", "line 7: "]


def test_a_text_of_many_lines_does_not_move_the_lines_below_it() -> None:
    text = 'schema = "exercise/1"\nname = "Drill"\nbriefing = """\nseed = 1\n[limits]\n"""\n'
    with pytest.raises(ConfigError, match=r"drill\.toml: line 8: \[limits\] depth_max = 9: "):
        parse_exercise(f"{text}[limits]\ndepth_max = 9\n", Path("drill.toml"))


# What the seed decides


FAULTS = """
[[casualties]]
name = "rudder-stuck"
at_s = 100
within_s = 60
lasts_s = 20
one_of = "fault"

[[casualties]]
name = "stern-stuck"
at_s = 200
one_of = "fault"
"""


def drawn(text: str, seed: int) -> list[tuple[float, str]]:
    return [(each.seconds, each.order.text) for each in drill(text).schedule_of(seed)]


def test_of_a_group_one_casualty_comes_by_the_seed_and_each_in_its_turn() -> None:
    found = [drawn(FAULTS, seed) for seed in range(40)]
    names = {each[0][1] for each in found}
    assert names == {"casualty rudder-stuck", "casualty stern-stuck"}
    times = {each[0][0] for each in found if "rudder" in each[0][1]}
    assert len(times) > 5
    assert all(100.0 <= time < 160.0 and time == int(time) for time in times)
    assert all(each[1][0] == each[0][0] + 20.0 for each in found if len(each) == 2)
    assert drawn(FAULTS, 7) == drawn(FAULTS, 7)


def test_what_comes_up_to_so_much_later_is_cleared_as_much_later() -> None:
    text = "[[casualties]]\nname = 'rudder-stuck'\nat_s = 10\nclear_at_s = 30\nwithin_s = 50\n"
    found = [drawn(text, seed) for seed in range(9)]
    assert len({each[0][0] for each in found}) > 3
    assert all(clear[0] - begin[0] == 20.0 for begin, clear in found)


# By hand


def test_what_the_crew_works_is_put_in_hand_as_it_stands(tmp_path: Path) -> None:
    path = tmp_path / "drill.toml"
    path.write_text(f"{SHORTEST}hand = ['rudder', 'planes', 'speed', 'ballast']\nhand_from_s = 9\n")
    plan = plan_run(RunOptions(exercise=str(path)))
    assert [(each.seconds, each.order.text) for each in plan.schedule] == [
        (9.0, "rudder manual"),
        (9.0, "planes manual"),
        (9.0, "turns 10 kn"),
        (9.0, "trim manual"),
        (9.0, "hover off"),
    ]
    assert plan.judged_by_tasks
    path.write_text(f"{SHORTEST}hand = ['rudder']\nvessel = './none.toml'\n")
    text = read_text(shipped_path("vessels", "bb2"))
    without = re.sub(r"\n\[autopilot\].*?(?=\n\[)", "", text, flags=re.DOTALL)
    (tmp_path / "none.toml").write_text(without)
    assert plan_run(RunOptions(exercise=str(path))).schedule == []


@pytest.mark.parametrize("briefing", ["5", '""', '"\\u001b[2J"', f'"{"x" * 4001}"'])
def test_a_briefing_is_printable_text_of_some_length(briefing: str) -> None:
    text = f'schema = "exercise/1"\nname = "Drill"\nbriefing = {briefing}\n'
    with pytest.raises(ConfigError, match="must be printable text of 1 to 4000 characters"):
        parse_exercise(text, Path("drill.toml"))


def test_a_limit_with_its_words_in_another_order_is_answered_with_itself() -> None:
    with pytest.raises(ConfigError, match="depth_max_m = 90: no such key; nearest is depth_m_max"):
        drill("[limits]\ndepth_max_m = 90\n")


def test_conditions_joined_by_or_are_not_answered_with_an_or() -> None:
    with pytest.raises(ConfigError, match=r"write it as depth > 100, or as speed_kn <= 4\.5"):
        drill('lost = ["depth > 130 or pitch_deg > 20"]\n')


def test_a_hand_that_is_no_list_is_told_alone() -> None:
    with pytest.raises(ConfigError) as wrong:
        drill('hand = "planes"\n[[orders]]\nat_s = 60\norder = "order depth 80"\n')
    assert len(wrong.value.problems) == 1


def test_a_start_at_which_the_boat_cannot_fly_level_names_the_exercises_key(
    tmp_path: Path,
) -> None:
    path = tmp_path / "drill.toml"
    path.write_text(f'{SHORTEST}vessel = "remus100"\n[initial]\nspeed_kn = 10\n')
    with pytest.raises(ConfigError, match=r"speed_kn of an exercise's \[initial\]"):
        plan_run(RunOptions(exercise=str(path))).launch_boat()


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
    assert obey_order(boat, exercise.schedule[0].order) == "casualty my-leak, hole 5 cm2 within 5 s"


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
    assert plan.sea.name == "sea state 2 from 000"

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


def ran(*words: str, typed: str = "") -> Done:
    return run_trainer(*words, typed=typed, timeout=120)


@pytest.mark.process
def test_a_run_of_an_exercise_begins_with_its_briefing_and_ends_by_itself() -> None:
    done = ran("run", "stern-plane-jam", "--speed", "max", typed="help\n")
    assert done.returncode == 0
    lines = done.stdout.splitlines()
    briefing = load_exercise("stern-plane-jam").heading.briefing.splitlines()
    assert lines[: 1 + len(briefing)] == [
        "Passage, fast and deep (stern-plane-jam)",
        *briefing,
    ]
    assert "15 kn, 100 m, course 000" in lines
    assert "computed by the modified set, step 0.5 s" in lines  # the instructor's
    crew = ran("run", "stern-plane-jam", "--speed", "max", "--train", typed="quit\n")
    assert "15 kn, 100 m, course 000" in crew.stdout.splitlines()
    assert not re.search("modified|step 0.5", crew.stdout)
    assert re.search(r"\d+ s: casualty stern-hard-over, ", done.stdout)
    assert "LIMIT: deeper than 140 m" in done.stdout
    assert "simulated   " in done.stderr


@pytest.mark.process
def test_a_headless_run_names_its_events_in_the_summary() -> None:
    done = ran("run", "stern-plane-jam", "--headless", "--speed", "max")
    assert done.returncode == 0
    assert re.search(r"events .*deeper than 140 m 1 time", done.stdout)


@pytest.mark.process
def test_a_headless_run_tells_what_was_refused_of_its_schedule_and_ends_with_code_1(
    tmp_path: Path,
) -> None:
    (tmp_path / "wrong.orders").write_text("5 depth 70\n9 stern planes dive 80\n")
    words = ("--headless", "--speed", "max", "--duration", "20")
    done = ran("run", "--orders", str(tmp_path / "wrong.orders"), *words)
    assert done.returncode == 1
    assert done.stderr == (
        "trainer: 9 s: stern planes dive 80: refused: "
        "the limit of the stern planes is 30 degrees, not 80\n"
    )


@pytest.mark.parametrize("name", ["heavy-boat", "crash-stop"])
def test_no_tank_tells_the_crew_how_heavy_the_boat_begins(name: str) -> None:
    plan = plan_run(RunOptions(exercise=name))
    heavy, forward = plan.initial.heavy_t or 0.0, plan.initial.forward_t or 0.0
    boat, trimmed = Boat(plan.file, plan.method), Boat(plan.file, plan.method)
    replace(plan, initial=replace(plan.initial, heavy_t=None, forward_t=None)).start(trimmed)
    for _ in range(2):  # a replay starts one boat for every branch
        plan.start(boat)
        np.testing.assert_array_equal(boat.state.water, trimmed.state.water)
        assert (boat.state.weight - trimmed.state.weight) / boat.vessel.g == pytest.approx(
            1000.0 * heavy
        )
        assert bool(boat.state.x_g > trimmed.state.x_g + 0.01) is (forward > 0.0)
    boat.tick()  # and so it stays
    now = (boat.state.weight - trimmed.state.weight) / boat.vessel.g
    assert now == pytest.approx(1000.0 * heavy, abs=200.0)


def test_a_boat_that_its_tanks_cannot_bring_into_trim_is_refused() -> None:
    plan = plan_run(RunOptions(exercise="heavy-boat"))
    heavier = replace(plan, initial=replace(plan.initial, heavy_t=60.0))
    with pytest.raises(ConfigError, match=r"heavy_t = 60, .* in trim the depth control tank"):
        heavier.start(Boat(plan.file, plan.method))


@pytest.mark.process
def test_an_orders_file_gives_the_autopilot_nothing_that_the_exercise_has_in_hand(
    tmp_path: Path,
) -> None:
    orders = tmp_path / "auto.orders"
    orders.write_text("9 planes auto\n12 course 090\n15 stern planes dive 5\n60 depth 70\n")
    words = ("--headless", "--speed", "max", "--orders", str(orders))
    done = ran("run", "first-depth-change", *words)
    assert done.returncode == 2
    by_hand = "the planes are in hand in this exercise: stern planes dive 5"
    assert [line.removeprefix("trainer: ") for line in done.stderr.splitlines()] == [
        f"auto.orders:1: planes auto: {by_hand}",
        f"auto.orders:4: depth 70 m: {by_hand}",
    ]
    orders.write_text("9 depth 70\n15 stern planes dive 5\n", encoding="utf-8")
    allowed = ran("run", "depth-gauge-failure", *words, "--no-record")  # and planes from 120 s on
    assert "in hand" not in allowed.stderr


@pytest.mark.process
def test_a_wrong_exercise_or_sea_ends_with_code_2_and_one_line() -> None:
    for words in (("run", "heavyboat"), ("run", "--sea", "sea-state-55")):
        done = ran(*words)
        assert done.returncode == 2
        assert "nearest is" in done.stderr
        assert len(done.stderr.splitlines()) == 1


MISTAKES = {  # a line of the skeleton, the line in its place, and what is told of it
    "table": ("[limits] ", "[limit] ", "limit = .*no such key; nearest is limits"),
    "key": ("duration_s = 600", "duration = 600", "duration = 600: no such key; nearest is dura"),
    "value": ("speed_kn = 10", "speed_kn = -10", r"\[initial\] speed_kn = -10: must be 0.001 to"),
    "reference": ("stern-hard-over", "stern-hardover", 'name = "stern-hardover": no such casualty'),
    "condition": ('"depth > 130"', '"dept > 130"', 'lost = "dept > 130": no quantity .dept.; near'),
    "boat": ('# vessel = "bb2"', 'vessel = "bb3"', 'no vessel "bb3"; nearest is bb2'),
    "key of a score": ('measure = "reach"', 'measur = "reach"', "measur = .*nearest is measure"),
    "its quantity": ('quantity = "depth_m"', 'quantity = "depht_m"', "no such quantity; nearest"),
    "measure": ('measure = "settled"', 'measure = "setled"', "no such measure; nearest is settled"),
    "order": ("order depth 80", "order dpth 80", "did you mean depth?"),
    "time of an order": ("at_s = 60", "at_s = -60", r"\[orders\[0\]\] at_s = -60: must be 0 to"),
    "rule": ("at_s = 1\n", 'when = "stern < x"\n', 'condition "stern < x": write it as'),
    "key of a rule": ('order = "planesman on"', 'oder = "planesman on"', "nearest is order"),
}


def test_the_file_to_begin_with_judges_what_it_breaks_and_its_reference_crew_wins() -> None:
    path = shipped_path("", "exercise-skeleton")
    exercise = parse_exercise(path.read_text(encoding="utf-8"), path)
    broken = {each.row.name for each in exercise.drawn}
    judged = {rule.score.casualty or rule.score.since for rule in exercise.scores}
    assert broken == judged - {None} != set()
    crew = next(line for line in check_exercise(str(path)) if line.startswith("crew"))
    assert re.fullmatch(r"crew    (9\d|100) marks, won", crew)


def test_a_check_tells_every_mistake_of_a_file_at_once(tmp_path: Path) -> None:
    text = shipped_path("", "exercise-skeleton").read_text(encoding="utf-8")
    for sound, wrong, _ in MISTAKES.values():
        assert sound in text
        text = text.replace(sound, wrong, 1)
    path = tmp_path / "drill.toml"
    path.write_text(text, encoding="utf-8")

    with pytest.raises(ConfigError) as error:
        check_exercise(str(path))

    for kind, (*_, told) in MISTAKES.items():
        assert any(re.search(told, each) for each in error.value.problems), kind
    unplaced = [each for each in error.value.problems if not each.startswith("drill.toml: line ")]
    assert unplaced == [each for each in unplaced if each.startswith("no vessel")]


def test_a_condition_and_the_name_beside_it_are_both_told() -> None:
    text = 'schema = "exercise/1"\nname = "X"\nbriefing = "X"\n'
    text += '[[casualties]]\nname = "stern-stuk"\nwhen = "dept > 3"\n'

    with pytest.raises(ConfigError) as error:
        parse_exercise(text, Path("drill.toml"))

    condition, name = error.value.problems
    assert condition.endswith("no quantity 'dept'; nearest is depth")
    assert name.endswith(
        "no such casualty; nearest is stern-stuck; `trainer casualties` lists them"
    )


def test_casualties_of_ones_own_are_known_though_the_head_of_the_file_is_wrong(
    tmp_path: Path,
) -> None:
    own = '[casualty.stern-frozen]\nkind = "stern-stuck"\ndescription = "They stay"\n'
    (tmp_path / "own.toml").write_text(f'schema = "casualties/1"\nname = "Own"\n{own}')
    text = 'schema = "exercise/1"\nbriefing = "X"\ncasualty_table = "./own.toml"\n'
    text += '[[casualties]]\nname = "stern-frozen"\nat_s = 3\n'

    with pytest.raises(ConfigError) as error:
        parse_exercise(text, tmp_path / "drill.toml")

    assert error.value.problems == ("drill.toml: lacks name",)


@pytest.mark.process
def test_the_lists_name_everything_in_79_columns() -> None:
    exercises, casualties = ran("exercises"), ran("casualties")
    lessons, listed, hint = exercises.stdout.split("\n\n")
    names = [line.split()[0] for line in listed.splitlines()[1:]]
    assert sorted(names) == list(NAMES)
    assert listed.startswith("Exercises, easy ones first:  ")
    assert "trainer run NAME --train" in hint
    assert lessons.startswith("Lessons, step by step, for one person alone:\nwheel-and-course ")
    assert [line.split()[0] for line in lessons.splitlines()[1:]] == [
        each.name for each in step_lessons()
    ]
    assert re.search(r"^heavy-boat +6 Trim +30 min 1 ballast$", listed, re.MULTILINE)
    assert (names[0], names[-2], names[-1]) == (
        "first-depth-change",
        "periscope-approach",
        "visitor-dive",
    )  # as the course goes
    assert "stern-hard-over" in casualties.stdout
    assert max(map(len, exercises.stdout.splitlines())) <= 79
    assert list(json.loads(ran("exercises", "--json").stdout)) == names
    assert json.loads(ran("casualties", "--json").stdout)[0]["name"] == "rudder-slow"


# The page


def page(name: str) -> str:
    return (ROOT / "docs" / name).read_text(encoding="utf-8")


def test_the_exercises_of_the_page_are_exercises() -> None:
    found = re.findall(r"```toml\n(.*?)```", page("exercise-files.md"), re.DOTALL)
    assert len(found) >= 2
    for text in found:
        assert parse_exercise(text, Path("page.toml")).schedule_of(1)


def test_a_sea_above_nyquist_for_the_step_is_refused_before_the_run(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"^sea-state-3\.toml: a sea above Nyquist for the step"):
        plan_run(RunOptions(sea="sea-state-3", step=1.0, given=frozenset({"sea", "step"})))
    drill = tmp_path / "drill.toml"
    drill.write_text('schema = "exercise/1"\nname = "x"\nbriefing = "y"\n[sea]\nheight_m = 0.05\n')
    with pytest.raises(ConfigError, match=r"^drill\.toml: a sea above Nyquist for the step"):
        plan_run(RunOptions(exercise=str(drill)))
