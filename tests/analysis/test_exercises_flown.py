"""The shipped exercises flown by nobody, by their reference crews, and by worse ones."""

import functools
import math
import re
import tomllib
from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from helpers.givers import journalled
from helpers.lanes import sample_cases
from helpers.places import ROOT
from helpers.rehearsed import flown, marks_of

from trainer.authoring.exercise_page import (
    baseline_lines,
    baseline_of,
    check_exercise,
    depends_on_seed,
    fly_at,
    plan_exercise,
    save_baseline,
    study_exercise,
)
from trainer.boat.boat import Boat
from trainer.boat.casualties import insert_casualty
from trainer.boat.reference_crew import CrewReaction, ReferenceCrew
from trainer.config.exercise.baseline import kept_baseline
from trainer.config.exercise.exercise import load_exercise
from trainer.config.exercise.reference_crew import Crew, read_crew
from trainer.config.files import ConfigError, Position, path_named, read_text, shipped_names
from trainer.core.digest import core_digest
from trainer.debrief.attainable.explorer import RunExplorer
from trainer.debrief.marks.judgement import judge_run, plain_marks
from trainer.debrief.marks.rehearsal import Rehearsal, fly_rehearsal
from trainer.debrief.marks.scoring import Scorecard
from trainer.debrief.page.data import gather_debrief
from trainer.io.orders.grammar import Refused
from trainer.io.recording.facts import REFERENCE_GIVER, SCHEDULE_GIVER
from trainer.io.recording.recording import Recording
from trainer.session.past.options import RunOptions
from trainer.session.past.plan import Plan, plan_run
from trainer.session.run import run_boat

NAMES = shipped_names("exercises")
# an order of each kind that changes nothing
USELESS = {
    "planes-mode": "bow planes emergency",  # of the pair that is well
    "turns": "turns {speed:g}",
    "pump": "pump depth-control 0.1",
    "blow": "blow stop",
    "bow": "bow planes zero",
    "stern": "stern planes zero",
    "flood": "flood depth-control 0.1",
    "emergency": "blow stop",
    "loads": "loads back",
    "bus": "bus tie open",
    "fight": "fight fire forward",
    "ventilation": "ventilation run",
    "breaker": "breaker port shut",
    "isolate": "isolate vital",  # which feeds nothing yet
    "drain": "drain centre",
}


def by_crew(name: str) -> Rehearsal:
    return flown(name).flights["crew"]


def reference(name: str) -> Scorecard:
    card = flown(name).crew
    assert card is not None
    return card


def outcome(card: Scorecard) -> str:
    assert card.verdict is not None
    return card.verdict.outcome


def with_ways(plan: Plan, hand: str, **ways: float) -> Crew:
    """Return the reference crew with other ways at the planes or the rudder."""
    return replace(plan.crew, **{hand: replace(getattr(plan.crew, hand), **ways)})


# Each at its own seed


@pytest.mark.long
@pytest.mark.parametrize("name", sample_cases(NAMES, *NAMES[::5]))
def test_nobody_aboard_earns_nothing(name: str) -> None:
    card = flown(name).nobody
    assert (card.total or 0.0) <= 1.0
    assert outcome(card) != "won"


@pytest.mark.parametrize("name", NAMES)
def test_a_check_finds_nothing_wrong_in_a_shipped_exercise(
    monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    kept = flown(name)
    monkeypatch.setattr("trainer.authoring.exercise_page.fly_both", lambda _: kept)
    lines = check_exercise(name)
    assert any(re.match(r"nobody  (0 marks|void), ", line) for line in lines)
    assert any(re.match(r"crew    (8[5-9]|9\d|100) marks, won", line) for line in lines)


@pytest.mark.parametrize("name", NAMES)
def test_a_baseline_is_kept_that_is_not_stale(name: str) -> None:
    path = path_named(name, "exercises")
    kept = kept_baseline(path)
    assert kept is not None
    assert kept.crew is not None
    text = read_text(path)
    now, same = flown(name), kept.fits(text) and kept.heading.core == core_digest()
    stale = f"a mark moved by 5: trainer exercise baseline {name} (text and core the same: {same})"
    assert now.nobody_marks == pytest.approx(dict(kept.marks), abs=5.0), stale
    assert now.nobody.total or pytest.approx(kept.nobody.total, abs=5.0) == 0.0, stale
    assert reference(name).total == pytest.approx(kept.crew.total, abs=5.0), stale
    assert kept.fits(text), f"the text has changed: trainer exercise baseline {name}"


# nothing presses, as their texts for the instructor say
PATIENT = ("bottoming", "canyon", "heavy-boat")
# [s] when something first asks for an answer, where that is not the first order or casualty
ASKED_S = {
    "crossing-traffic": 120.0,  # its ships come near
    "hover-by-pump": 60.0,  # she has begun to sink
    "depth-gauge-failure": 150.0,
    **dict.fromkeys(("flooding-aft", "steering-jam", "stern-plane-jam"), 66.0),
    "rise-jam-shallow": 101.0,
    "loss-of-propulsion": 486.0,
    **dict.fromkeys(("main-oil-lost", "port-bus-lost"), 64.0),
    **dict.fromkeys(("grounding-forward", "leaking-leg"), 60.0),
    "periscope-approach": 720.0,  # emergency deep
    "fire-aft": 110.0,  # its smoke is seen
}


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_marks_fall_by_how_late_a_crew_is_and_no_tick_decides(name: str) -> None:
    crew, best = flown(name).plan.crew, reference(name).total or 0.0
    late = {s: marks_of(name, crew, CrewReaction(late=s)) for s in (5.0, 15.0, 40.0, 60.0)}
    totals = [best, *(card.total or 0.0 for card in late.values())]
    assert all(worse <= better + 1.0 for better, worse in pairwise(totals)), totals
    for card in late.values():
        assert (outcome(card) == "won") is ((card.total or 0.0) >= 60.0)


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in NAMES if name not in PATIENT])
def test_two_minutes_after_something_asks_for_an_answer_it_is_too_late(name: str) -> None:
    plan = flown(name).plan.alone()
    asking = [e.seconds for e in plan.schedule if e.order.name in ("order", "tell", "casualty")]
    begun = ASKED_S.get(name, min(asking))
    judge = functools.partial(judge_run, plan=plan, nobody=flown(name).nobody_marks)
    run = RunExplorer(plan, fly_rehearsal(plan).trajectory, judge)
    run.fly_again()
    tick = round((begun + 120.0) / plan.method.step)
    assert not run.point(min(tick, run.last)).won


def useless_crews(plan: Plan) -> Iterator[Crew]:
    """Yield who gives one useless answer to one casualty of an exercise that is to be answered."""
    onsets = {
        part.name: entry.seconds
        for entry in plan.schedule
        if entry.order.name == "casualty"
        for part in plan.casualties[entry.order.subject].broken
    }
    for rule in plan.scores:
        onset = onsets.get(rule.score.casualty or "")
        wanted = [word for word in USELESS if word in (rule.score.orders or USELESS)]
        if rule.part == "answer" and onset is not None and wanted:
            order = USELESS[wanted[0]].format(speed=plan.initial.speed_kn)
            yield read_crew({"crew": [{"at_s": onset + 3.0, "order": order}]}, Position("test", ""))


@pytest.mark.parametrize("name", NAMES)
def test_one_useless_order_at_the_right_second_earns_next_to_nothing(name: str) -> None:
    plan = flown(name).plan
    crews = list(useless_crews(plan))
    assert bool(crews) is any(rule.part == "answer" for rule in plan.scores)
    for crew in crews:
        assert (marks_of(name, crew).total or 0.0) <= 20.0


def test_an_emergency_blow_that_is_taken_back_earns_next_to_nothing() -> None:
    orders = [{"at_s": 103, "order": "emergency blow"}, {"at_s": 104, "order": "blow stop"}]
    crew = read_crew({"crew": orders}, Position("test", ""))
    assert (marks_of("air-bank-failure", crew).total or 0.0) <= 20.0


@pytest.mark.parametrize("name", ["stern-plane-jam", "rise-jam-shallow"])
def test_a_crew_that_answers_a_jam_15_s_late_does_not_pass(name: str) -> None:
    late = marks_of(name, flown(name).plan.crew, CrewReaction(late=15.0))
    assert (late.total or 0.0) <= 60.0


NOVICES: dict[str, tuple[str, dict[str, float]]] = {  # without lead
    "depth-changes": ("planesman", {"bubble_deg_per_m": 0.95, "bubble_s": 0.0, "stern_s": 0.0}),
    "course-changes": ("helmsman", {"rudder_s": 0.0}),
}


@pytest.mark.parametrize("name", NOVICES)
def test_a_novice_earns_something_and_far_from_all(name: str) -> None:
    hand, ways = NOVICES[name]
    novice = marks_of(name, with_ways(flown(name).plan, hand, **ways))
    assert 20.0 <= (novice.total or 0.0) <= 80.0


@pytest.mark.parametrize("name", NAMES)
def test_a_broken_gate_never_leaves_more_than_50(name: str) -> None:
    plan = flown(name).plan
    turns = read_crew({"crew": [{"at_s": 70, "order": "blow stop"}]}, Position("test", ""))
    for flight in (*flown(name).flights.values(), fly_rehearsal(plan, turns)):
        card = judge_run(flight.trajectory, plan, {})
        assert card.verdict
        if card.verdict.gate:
            assert card.total is None or card.total <= 50.0
        if outcome(card) == "lost":
            assert card.total is None or card.total <= 25.0


def test_a_boat_laid_on_the_ground_badly_leaves_50() -> None:
    text = (ROOT / "configs/exercises/bottoming.toml").read_text()
    hasty = {
        "speed_kn < 0.5": "speed_kn < 2.5",
        "astern two-thirds": "stop",
        "depth 91": "depth 94",
    }
    for well, hastily in hasty.items():
        text = text.replace(well, hastily)
    crew = read_crew({"crew": tomllib.loads(text)["crew"]}, Position("test", ""))
    card = marks_of("bottoming", crew)
    assert card.verdict
    assert outcome(card) == "not reached"
    assert re.match(r"laid on the ground badly at 10:0.*: way 0\.8", card.verdict.reason)
    assert card.total == 50.0


# Marks at the seams


def drill(folder: Path, more: str) -> str:
    """Return the path of a short exercise: a depth change, planes by hand."""
    path = folder / "drill.toml"
    path.write_text(
        'schema = "exercise/1"\nname = "Drill"\nbriefing = "Dive."\nduration_s = 240\n'
        f"hand = ['planes']\n{more}\n"
        "[[orders]]\nat_s = 10\norder = 'order depth 70'\n"
        "[[scores]]\nname = 'Deep'\nmeasure = 'final'\nquantity = 'depth'\nfull = 69\nzero = 62\n"
    )
    return str(path)


DIVE = "[[crew]]\nat_s = 1\norder = 'planesman on'\n"


def test_an_exercise_is_won_by_its_tasks(tmp_path: Path) -> None:
    went = fly_at(drill(tmp_path, DIVE))
    assert went.crew
    assert (went.crew.total, outcome(went.crew)) == (100.0, "won")
    assert outcome(went.nobody) == "not reached"
    assert went.nobody.verdict
    assert went.nobody.verdict.reason == "Deep"


def test_sixty_marks_win(tmp_path: Path) -> None:
    plan = plan_exercise(drill(tmp_path, DIVE))
    went = fly_rehearsal(plan, plan.crew).trajectory
    for deep, wins in ((66.21, True), (66.19, False)):  # 60 of 100 marks are at 66.2 m
        depth = went.columns["z"].copy()
        depth[-1] = deep
        card = judge_run(replace(went, columns={**went.columns, "z": depth}), plan, {})
        assert (outcome(card) == "won") is wins


def test_a_check_says_that_the_reference_crew_does_not_win(tmp_path: Path) -> None:
    idle = "[[crew]]\nat_s = 1\norder = 'planesman off'\n"
    for rules, wins in ((DIVE, True), (idle, False)):
        told = check_exercise(drill(tmp_path, rules))
        assert any("the reference crew does not win" in line for line in told) is not wins


def test_a_limit_broken_for_two_seconds_leaves_50(tmp_path: Path) -> None:
    went = fly_at(drill(tmp_path, f"{DIVE}[limits]\ndepth_m_max = 65\n"))
    assert went.crew
    assert went.crew.total == 50.0
    assert went.crew.verdict
    assert went.crew.verdict.reason.startswith("deeper than 65 m at ")


def test_a_limit_broken_for_less_than_two_seconds_costs_nothing(tmp_path: Path) -> None:
    plan = plan_exercise(drill(tmp_path, f"{DIVE}[limits]\npitch_deg_max = 20\n"))
    went = fly_rehearsal(plan, plan.crew).trajectory
    # 5 ticks of 0.5 s are 2 s from first to last: 2.5 of the 5 deg times 30 s that break it wholly
    for ticks, total in ((4, 100.0), (5, 100.0 - 50.0 * 2.5 / 150.0)):
        pitch = went.columns["theta"].copy()
        pitch[100 : 100 + ticks] = math.radians(21.0)
        card = judge_run(replace(went, columns={**went.columns, "theta": pitch}), plan, {})
        assert card.verdict
        assert (card.verdict.cap or 100.0) == pytest.approx(total)


@pytest.mark.parametrize("text", ["allow planes", "casualty rudder-stuck"])
def test_a_run_that_the_instructor_made_free_has_no_marks(tmp_path: Path, text: str) -> None:
    plan = plan_exercise(drill(tmp_path, DIVE))
    went = fly_rehearsal(plan, plan.crew).trajectory
    by_hand = journalled(99, 40, "instructor at console", text)
    card = judge_run(replace(went, orders=(*went.orders, by_hand)), plan, {})
    assert (card.total, outcome(card)) == (None, "free")
    assert card.verdict
    assert card.verdict.reason == f"{text} at 0:20, by instructor at console"
    of_the_exercise = replace(by_hand, giver=SCHEDULE_GIVER)
    assert judge_run(replace(went, orders=(*went.orders, of_the_exercise)), plan, {}).total == 100.0


def test_a_lost_exercise_leaves_25(tmp_path: Path) -> None:
    went = fly_at(drill(tmp_path, f"lost = ['depth > 66 for 5 s']\n{DIVE}"))
    assert went.crew
    assert (went.crew.total, outcome(went.crew)) == (25.0, "lost")
    brief = fly_at(drill(tmp_path, f"lost = ['depth > 66 for 500 s']\n{DIVE}"))
    assert brief.crew
    assert outcome(brief.crew) == "won"


def test_a_boat_that_turned_over_has_no_marks(tmp_path: Path) -> None:
    plan = plan_exercise(drill(tmp_path, DIVE))
    went = fly_rehearsal(plan, plan.crew).trajectory
    pitch = went.columns["theta"].copy()
    pitch[100] = math.radians(46.0)
    over = replace(went, columns={**went.columns, "theta": pitch})
    card = judge_run(over, plan, {})
    assert card.total is None
    assert card.verdict
    assert card.verdict.void
    assert outcome(card) == "lost"


def test_a_run_that_ends_early_is_not_won(tmp_path: Path) -> None:
    plan = plan_exercise(drill(tmp_path, DIVE))
    short = fly_rehearsal(replace(plan, duration=200.0), plan.crew).trajectory
    card = judge_run(short, plan, {})
    assert card.verdict
    assert card.verdict.reason == "the record ends at 3:20"


def test_in_basic_width_bands_and_zeros_are_half_as_wide_again() -> None:
    plan, nobody = flown("depth-changes").plan, flown("depth-changes").nobody_marks
    hand, ways = NOVICES["depth-changes"]
    novice = fly_rehearsal(plan, with_ways(plan, hand, **ways)).trajectory
    basic, qualified = (judge_run(novice, plan, nobody, width) for width in ("basic", "qualified"))
    assert (basic.total or 0.0) > (qualified.total or 0.0) + 5.0


def test_what_nobody_gets_is_taken_off(tmp_path: Path) -> None:
    plan = plan_exercise(drill(tmp_path, DIVE))
    went = fly_rehearsal(plan, plan.crew).trajectory
    short = replace(went, columns={**went.columns, "z": went.columns["z"] - 3.6})  # 66.4 m
    half = judge_run(short, plan, {"Deep": 40.0}).scores[0]
    assert 40.0 < (half.marks or 0.0) < 80.0
    assert half.earned == pytest.approx(100.0 * ((half.marks or 0.0) - 40.0) / 60.0)
    assert judge_run(short, plan, {"Deep": 49.9}).total == pytest.approx(
        100.0 * ((half.marks or 0.0) - 49.9) / 50.1
    )
    idle, earning = (judge_run(went, plan, {"Deep": free}).scores[0] for free in (60.0, 40.0))
    assert idle.earned is None  # nothing to be earned
    assert idle.told == "Deep: does not count, a boat with nobody aboard has it as well"
    assert earning.told == "Deep: 100"


# The same again


def test_marks_are_the_same_to_the_bit_when_flown_again() -> None:
    again, first = fly_at("stern-plane-jam"), flown("stern-plane-jam")
    assert again.crew
    assert first.crew
    assert [each.earned for each in again.crew.scores] == [e.earned for e in first.crew.scores]
    assert again.crew.total == first.crew.total


def test_a_recorded_run_has_the_marks_of_its_rehearsal(tmp_path: Path) -> None:
    orders = [
        each for each in by_crew("depth-changes").trajectory.orders if each.giver == REFERENCE_GIVER
    ]
    lines = [f"{each.tick * 0.5:g} {each.text}" for each in orders if "man o" not in each.text]
    (tmp_path / "crew.orders").write_text("\n".join(lines) + "\n")
    record = tmp_path / "it.trainer"
    options = RunOptions(
        exercise="depth-changes",
        headless=True,
        speed=math.inf,
        record=record,
        orders_file=tmp_path / "crew.orders",
    )
    assert run_boat(options) == 0
    recording = Recording.look(record)
    card = gather_debrief(recording, record, None).card
    recording.close()
    assert card.total == reference("depth-changes").total
    assert [each.marks for each in card.scores] == [
        each.marks for each in reference("depth-changes").scores
    ]


# The reference crew


def test_the_crew_sees_what_the_gauges_show() -> None:
    plan = plan_exercise("depth-gauge-failure")
    boat = Boat(plan.file, plan.method)
    plan.start(boat)
    rules = read_crew(
        {"crew": [{"when": "depth > 20", "order": "bell stop"}]}, Position("test", "")
    )
    aboard = ReferenceCrew(boat, rules)
    assert aboard.look() == []
    assert isinstance(insert_casualty(boat, "depth-gauge-biased", 0.5, 0.0), str)
    assert boat.tick() == 0
    assert boat.state.z < 18.0  # the boat itself has not moved
    (given,) = aboard.look()
    assert not isinstance(given.reply, Refused)
    assert aboard.look() == []  # once


def test_a_rule_waits_for_the_one_above_and_its_own_time() -> None:
    table = {
        "crew": [
            {"at_s": 5, "order": "rudder left 5"},
            {"then": True, "after_s": 3, "order": "rudder amidships"},
            {"when": "time > 2", "every_s": 4, "to_s": 11, "order": "pump depth-control 1"},
        ]
    }
    plan = replace(plan_exercise("depth-changes"), duration=20.0)
    went = fly_rehearsal(plan, read_crew(table, Position("test", ""))).trajectory
    given = [(each.tick * 0.5, each.text) for each in went.orders if each.giver == REFERENCE_GIVER]
    assert given == [
        (2.5, "pump depth-control 1 t"),
        (5.0, "rudder left 5"),
        (6.5, "pump depth-control 1 t"),
        (8.0, "rudder amidships"),
        (10.5, "pump depth-control 1 t"),
    ]


def test_the_helmsman_turns_the_long_way_where_that_is_ordered(tmp_path: Path) -> None:
    path = tmp_path / "drill.toml"
    path.write_text(
        'schema = "exercise/1"\nname = "Drill"\nbriefing = "Turn."\nduration_s = 400\n'
        "hand = ['rudder']\n[[orders]]\nat_s = 10\norder = 'order course left 090'\n"
        "[[crew]]\nat_s = 1\norder = 'helmsman on'\n"
    )
    plan = plan_exercise(str(path))
    heading = np.degrees(fly_rehearsal(plan, plan.crew).trajectory.columns["psi"])
    assert heading[-1] == pytest.approx(-270.0, abs=2.0)


def test_reactions_are_drawn_by_their_seed() -> None:
    draws = [[CrewReaction(jitter=5.0, seed=seed).delay() for _ in range(3)] for seed in (1, 1, 2)]
    assert draws[0] == draws[1] != draws[2]
    assert all(0.0 <= delay <= 5.0 for each in draws for delay in each)


# What a check refuses


KEPT = (
    "[[scores]]\nname='Kept'\nmeasure='in-band'\nquantity='depth'\ntarget=60\nband=2\n"
    "full=95\nzero=20\n"
)


@pytest.mark.parametrize(
    ("more", "message"),
    [
        ("", None),
        (
            KEPT + "to_s=9\n",
            r'line \d+: \[scores\[0\]\] name = "Kept": gives 100 marks with nobody aboard',
        ),
        (
            "[[orders]]\nat_s = 5\norder = 'stern planes dive 80'\n",
            r"line \d+: \[orders\[0\]\] order = .*a run refuses it: the limit of the stern",
        ),
        (
            "[[crew]]\nat_s = 5\norder = 'stern planes dive 80'\n",
            r"line \d+: \[crew\[0\]\] order = .*the boat refuses it: the limit",
        ),
    ],
)
def test_a_check_refuses_what_only_a_run_would_find(
    tmp_path: Path, more: str, message: str | None
) -> None:
    path = drill(tmp_path, more)
    if message is None:
        assert check_exercise(path)
        return
    with pytest.raises(ConfigError, match=message):
        check_exercise(path)


def test_a_speed_at_which_the_crew_cannot_take_over_is_told_at_a_key_of_the_file(
    tmp_path: Path,
) -> None:
    path = Path(drill(tmp_path, "[initial]\nspeed_kn = 60\n"))
    path.write_text(path.read_text().replace("['planes']", "['planes', 'speed']"))
    told = r'line 5: hand = \["planes", "speed"\]: begins with "turns 60 kn", and a run refuses'
    with pytest.raises(ConfigError, match=told):
        check_exercise(str(path))


def test_a_check_notes_a_score_whose_casualty_nothing_breaks(tmp_path: Path) -> None:
    answer = (
        "[[scores]]\nname='Answer'\nmeasure='response'\ncasualty='bow-hard-over'\n"
        "full=10\nzero=40\n"
    )
    breaks = "[[casualties]]\nname='bow-hard-over'\nseverity=0.1\nat_s=100\n"
    for more, noted in ((answer, True), (answer + breaks, False)):
        told = check_exercise(drill(tmp_path, more))
        note = "note    score Answer: nothing here breaks bow-hard-over: it counts if you do"
        assert (note in told) is noted


def test_an_exercise_won_by_standing_still_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "drill.toml"
    path.write_text(
        'schema = "exercise/1"\nname = "Drill"\nbriefing = "Stay."\nduration_s = 60\n'
        f"hand = ['planes']\n{KEPT}"
    )
    with pytest.raises(ConfigError, match="this exercise is won by standing still"):
        check_exercise(str(path))


def test_an_exercise_that_is_lost_at_its_start_is_refused(tmp_path: Path) -> None:
    lost = "lost = ['depth > 30', 'depth > 30 for 5 s', 'time > 100']\n"  # it begins at 60 m
    name = drill(tmp_path, KEPT)
    Path(name).write_text(Path(name).read_text().replace("duration_s", f"{lost}duration_s", 1))
    with pytest.raises(ConfigError, match="lost at its start") as refused:
        check_exercise(name)
    assert str(refused.value).count("lost at its start") == 1


def test_a_boat_that_an_exercise_misnames_is_told_once(tmp_path: Path) -> None:
    name = drill(tmp_path, 'vessel = "bb3"')
    with pytest.raises(ConfigError) as refused:
        check_exercise(name)
    (problem,) = refused.value.problems
    assert 'vessel = "bb3": no vessel "bb3"; nearest is bb2' in problem


# All seeds


def seeds_of(name: str) -> int:
    """Return the seeds an exercise is tried at; one where no flight depends on it."""
    return 20 if depends_on_seed(name, plan_exercise(name)) else 1


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_nobody_aboard_earns_little_and_the_reference_crew_is_good_at_any_seed(name: str) -> None:
    flown_ones = study_exercise(name, seeds_of(name)).flown
    totals = [(each.crew.total or 0.0) if each.crew else 0.0 for each in flown_ones]
    assert all((each.nobody.total or 0.0) <= 40.0 for each in flown_ones)
    assert np.mean(totals) >= 90.0
    assert min(totals) >= 70.0


# Texts and files


HIDDEN = r"\b(hidden|jam\w*|cure|fail\w*|lost|flood\w*|stuck|heavy|light|sticks|bank)\b"


@pytest.mark.parametrize("name", NAMES)
def test_both_texts_fit_on_a_console_and_the_crews_tells_nothing_hidden(name: str) -> None:
    exercise = load_exercise(name)
    heading = exercise.heading
    assert heading.instructor
    for text in (heading.briefing, heading.instructor):
        assert max(map(len, text.splitlines())) <= 79
        assert len(text.splitlines()) <= 12
    assert not re.search(HIDDEN, heading.briefing, re.IGNORECASE)
    assert not re.search(HIDDEN, heading.name, re.IGNORECASE)


def test_the_page_names_every_exercise_with_its_title() -> None:
    text = (ROOT / "docs" / "exercises.md").read_text(encoding="utf-8")
    for name in NAMES:
        assert f"| `{name}` | {load_exercise(name).heading.name} |" in text


def test_a_baseline_reads_back_as_it_was_written(tmp_path: Path) -> None:
    path = drill(tmp_path, DIVE)
    found = study_exercise(path, 3)
    assert save_baseline(found) == tmp_path / "drill.baseline.toml"
    kept = kept_baseline(Path(path))
    assert kept
    assert kept.crew
    assert (kept.crew.total, kept.crew.outcome) == (100.0, "won")
    assert kept.fits(read_text(Path(path)))
    assert kept.heading.core == baseline_of(found).heading.core
    assert plan_run(RunOptions(exercise=path)).baseline == kept
    assert plain_marks(
        fly_rehearsal(plan_exercise(path)).trajectory, plan_exercise(path)
    ) == pytest.approx(dict(kept.marks), abs=0.01)


def test_a_baseline_of_one_seed_is_the_mean_of_one_seed() -> None:
    lines = list(baseline_lines(study_exercise("first-depth-change", 1)))

    assert any(line.startswith("mean of 1 seed  ") for line in lines)
