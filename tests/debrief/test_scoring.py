"""Scoring: what rules may say, what the measures make of numbers, and exercises of one's own."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.boats import make_boat
from helpers.givers import journalled
from helpers.nursery import Done, run_trainer
from helpers.passages import BB2, alert, take_measure, trajectory

from trainer.boat.calls import Rank
from trainer.config.exercise.exercise import ExerciseLimits, load_exercise, parse_exercise
from trainer.config.exercise.score_rules import ALERT_RANKS, ScoreRule
from trainer.config.files import ConfigError, shipped_names
from trainer.debrief.marks import tallied_record
from trainer.debrief.marks.reference import alerts_until
from trainer.debrief.marks.scoring import (
    formula_of,
    marks_of,
    score_rules,
    unit_of,
)
from trainer.debrief.passage.ships_met import Detection, LookOut
from trainer.debrief.passage.trajectory import Trajectory
from trainer.io.recording.recording import RecordedOrder
from trainer.session.stations.alerts import SEEN_RANKS, Alert
from trainer.units import KNOT

SHORTEST = 'schema = "exercise/1"\nname = "Drill"\nbriefing = "Steer."\n'
MARKS = {"full": 0, "zero": 10}


def rules(text: str) -> tuple[ScoreRule, ...]:
    return parse_exercise(SHORTEST + text, Path("drill.toml")).scores


def rule(**keys: Any) -> ScoreRule:
    """Return the rule with these keys."""
    given = {"name": "it", **MARKS, **keys}
    lines = [
        f"{key} = {value!r}".replace("(", "[").replace(")", "]") for key, value in given.items()
    ]
    (found,) = rules("[[scores]]\n" + "\n".join(lines))
    return found


def taken(flown: Trajectory, **keys: Any) -> tuple[float | None, int | None]:
    """Return value and tick of a rule."""
    found = take_measure(flown, rule(**keys))
    return found.value, found.tick


def order(number: int, tick: int, text: str, who: str = "diving at panel") -> RecordedOrder:
    return journalled(number, tick, who, text)


# The measures by hand


def seen_after(*alerts: Alert, **keys: Any) -> tuple[float | None, str]:
    """Return the mean time to acknowledge, in a passage of 100 ticks of 0.5 s."""
    flown = replace(trajectory(z=[60.0] * 100), alerts=alerts)
    attained = take_measure(flown, rule(measure="alert-response", full=5, zero=20, **keys))
    return attained.value, attained.why


def test_the_time_to_acknowledge_is_the_mean_of_all_alerts_that_are_owed_it() -> None:
    first, second = alert(10, 30, "planes"), alert(20, 50, "helm")
    assert seen_after(first) == (10.0, "")
    assert seen_after(first, second) == (12.5, "")
    assert seen_after(first, alert(20)) == (15.0, "")  # nobody saw it: 20 s
    assert seen_after(first, alert(70)) == (10.0, "")  # the record ends too early for it
    assert seen_after(first, alert(70, 90, "planes")) == (10.0, "")
    assert seen_after(first, alert(20, 21)) == (10.0, "")  # a graver one replaced it
    assert seen_after(first, alert(20, rank=Rank.EMERGENCY)) == (10.0, "")  # it takes none
    assert seen_after(alert(0, 2, "planes")) == (5.0, "")  # no better than full


def test_the_time_to_acknowledge_looks_at_a_rank_and_a_time() -> None:
    alarm, warning = alert(10, 30, "planes"), alert(20, 50, "helm", Rank.WARNING)
    assert seen_after(alarm, warning, rank="warning") == (15.0, "")
    assert seen_after(alarm, warning, to_s=8) == (10.0, "")
    assert seen_after(alarm, rank="warning") == (None, "no such alert came")
    assert not take_measure(trajectory(), rule(measure="alert-response", full=5, zero=20)).counts
    assert [each.value for each in SEEN_RANKS] == [*ALERT_RANKS]
    told = formula_of(rule(measure="alert-response", full=5, zero=20, rank="alarm"))
    assert told.startswith("mean time from each alert of rank alarm to its acknowledgement")
    assert rule(measure="alert-response", full=5, zero=20).part == "answer"


def test_who_takes_over_acknowledges_what_is_owed_then() -> None:
    flown = replace(
        trajectory(z=[60.0] * 100), alerts=(alert(10, 30, "planes"), alert(50), alert(20, 90, "x"))
    )
    kept = alerts_until(flown, 40)
    assert [(each.raised.tick, each.seen and each.seen.tick) for each in kept] == [
        (10, 30),
        (20, 40),
    ]


def test_overshoot_is_how_far_it_went_beyond_seen_from_where_it_began() -> None:
    went = trajectory(z=[60, 90, 104, 101, 99])
    depth = {"measure": "overshoot", "quantity": "depth_m", "target": 100}
    assert taken(went, **depth) == (4.0, 2)
    upward = trajectory(z=[140, 120, 97, 99, 101])
    assert taken(upward, **depth) == (3.0, 2)


def test_a_target_that_is_never_reached_has_no_overshoot_and_earns_nothing() -> None:
    went = trajectory(z=[60, 90, 99, 98])
    met = score_rules(went, (rule(measure="overshoot", quantity="depth", target=100),))
    assert met.scores[0].attained.why == "the target was never reached"
    assert met.scores[0].marks == 0.0
    near = {"measure": "overshoot", "quantity": "depth", "target": 100, "band": 2}
    assert taken(went, **near) == (0.0, 2)


def test_time_to_counts_from_the_window_to_where_it_stays_in_its_band() -> None:
    went = trajectory(z=[60, 99, 90, 99, 101, 100])
    depth = {"measure": "time-to", "quantity": "depth", "target": 100, "band": 1}
    assert taken(went, **depth) == (1.5, 3)
    assert taken(went, **depth, from_s=1.0) == (0.5, 3)
    short = trajectory(z=[60, 99, 90])
    assert taken(short, **depth) == (None, None)
    assert take_measure(short, rule(**depth)).why == "not in the band at the end, 9 m beyond it"
    far = trajectory(z=[60, 258, 260.6])
    assert take_measure(far, rule(**depth)).why == "not in the band at the end, 160 m beyond it"


def test_a_window_that_ends_on_the_way_has_the_time_at_its_mean_pace() -> None:
    z = [60, 70, 80, 90, 99, 100]
    depth = {"measure": "time-to", "quantity": "depth", "target": 100, "band": 1}
    assert taken(trajectory(z=z), **depth, to_s=1.5) == (pytest.approx(1.5 * 39 / 30), 3)  # type: ignore[comparison-overlap]
    assert taken(trajectory(z=z), **depth, to_s=2.0) == (2.0, 4)  # no jump at the end of a window
    away = trajectory(z=[60, 50, 50, 50])
    assert taken(away, **depth, to_s=1.0) == (None, None)


def test_to_reach_a_target_the_boat_has_to_have_been_elsewhere() -> None:
    depth = {"quantity": "depth", "target": 100, "band": 1}
    assert taken(trajectory(z=[60, 99, 90, 99, 101]), measure="reach", **depth) == (1.5, 3)
    there, passing = trajectory(z=[100, 90, 99, 100]), trajectory(z=[99.5, 105, 112, 120])
    for measure in ("reach", "settled"):
        for went in (there, passing):
            why = take_measure(went, rule(measure=measure, **depth)).why
            assert why == "already within 1 m of it when it was ordered"
    assert marks_of(rule(measure="reach", **depth), None) == 0.0


def test_settled_is_the_share_of_the_last_two_minutes() -> None:
    z = np.full(1001, 100.0)  # 500 s, a tick each 0.5 s
    z[:700] = 60.0
    z[800] = 110.0
    depth = {"measure": "settled", "quantity": "depth", "target": 100, "band": 1}
    assert taken(trajectory(z=z), **depth) == (pytest.approx(100 * 240 / 241), 800)  # type: ignore[comparison-overlap]
    assert taken(trajectory(z=z), **depth, to_s=405)[0] == pytest.approx(100 * 110 / 241)


def test_final_is_the_value_or_the_distance_at_the_end_of_the_window() -> None:
    went = trajectory(psi=np.radians([0, 350, 355]))
    assert taken(went, measure="final", quantity="course_deg")[0] == pytest.approx(355.0)
    assert taken(went, measure="final", quantity="course_deg", target=10) == (  # type: ignore[comparison-overlap]
        pytest.approx(15.0),
        2,
    )
    assert taken(went, measure="final", quantity="course", target=10, to_s=0.5)[0] == pytest.approx(
        20.0
    )


def test_the_largest_of_a_distance_is_from_its_target() -> None:
    went = trajectory(z=[80, 83, 76])
    assert taken(went, measure="largest", quantity="depth", target=80) == (4.0, 2)


def test_heavy_is_weight_less_buoyancy() -> None:
    buoyancy = float(BB2.vessel.buoyancy)
    went = trajectory(weight=[buoyancy, buoyancy + 2000.0 * float(BB2.vessel.g)])
    assert taken(went, measure="final", quantity="heavy_t")[0] == pytest.approx(2.0)


def test_conditions_hold_together() -> None:
    went = trajectory(z=[60, 75, 90, 110], theta=np.radians([9, -5, -4, 9]))
    pitch = {"measure": "in-band", "quantity": "pitch_deg", "target": -5, "band": 0.5}
    assert taken(went, **pitch, when="depth > 70 and depth < 100")[0] == pytest.approx(50.0)


def test_a_tick_beyond_a_band_counts_in_part_to_half_as_far_again() -> None:
    depth = {"measure": "in-band", "quantity": "depth", "target": 100, "band": 4}
    for off, share in ((4.0, 100.0), (5.0, 50.0), (6.0, 0.0), (-5.5, 25.0)):
        assert taken(trajectory(z=[100 + off] * 4), **depth)[0] == pytest.approx(share)


def test_the_rms_of_a_condition_that_held_for_a_moment_has_no_value() -> None:
    z = np.full(400, 103.0)
    depth = {"measure": "rms", "quantity": "depth", "target": 100, "when": "speed_kn < 1"}
    slow = np.where(np.arange(400) < 59, 0.0, 5.0)
    assert taken(trajectory(z=z, u=slow), **depth) == (None, None)
    slow[59] = 0.0
    assert taken(trajectory(z=z, u=slow), **depth) == (3.0, 0)


def test_a_window_may_begin_with_a_casualty() -> None:
    given = [order(2, 1, "casualty stern-stuck", "schedule")]
    went = trajectory(orders=given, jam=[0, 0, 1, 1, 1], z=[90, 50, 60, 70, 65])
    since = {"measure": "highest", "quantity": "depth", "since": "stern-stuck"}
    assert taken(went, **since) == (70.0, 3)
    assert taken(went, **since, to_s=0.5) == (60.0, 2)
    assert take_measure(trajectory(z=[1, 2]), rule(**since)).counts is False
    assert "from stern-stuck on" in formula_of(rule(**since))


def test_rms_is_the_root_of_the_mean_square_and_its_place_the_worst() -> None:
    went = trajectory(z=[100, 103, 96, 100])  # sqrt((9 + 16) / 4) = 2.5
    assert taken(went, measure="rms", quantity="depth", target=100) == (2.5, 2)


def test_without_a_target_it_is_what_was_ordered_at_each_tick() -> None:
    went = trajectory(z=[60, 62, 80], ordered_depth=[60, 60, 80])
    assert taken(went, measure="in-band", quantity="depth", band=1) == (  # type: ignore[comparison-overlap]
        pytest.approx(200 / 3),
        1,
    )


def test_a_course_goes_the_short_way_round() -> None:
    went = trajectory(psi=np.radians([358, 362, 723]))
    assert taken(went, measure="rms", quantity="course_deg", target=0)[0] == pytest.approx(
        np.sqrt((4 + 4 + 9) / 3)
    )
    assert taken(went, measure="time-to", quantity="course", target=0, band=2.5) == (None, None)


def test_extremes_have_their_value_and_their_tick() -> None:
    went = trajectory(theta=np.radians([1, -7, 5]), u=np.array([2, 8, 5]) * KNOT)
    pitch = {"quantity": "pitch_deg"}
    assert taken(went, measure="highest", **pitch) == (pytest.approx(5.0), 2)  # type: ignore[comparison-overlap]
    assert taken(went, measure="lowest", **pitch) == (pytest.approx(-7.0), 1)  # type: ignore[comparison-overlap]
    assert taken(went, measure="largest", **pitch) == (pytest.approx(7.0), 1)  # type: ignore[comparison-overlap]
    assert taken(went, measure="highest", quantity="speed_kn") == (pytest.approx(8.0), 1)  # type: ignore[comparison-overlap]
    assert taken(went, measure="highest", quantity="speed_m_s") == (pytest.approx(8 * KNOT), 1)  # type: ignore[comparison-overlap]


def test_planes_are_as_active_as_what_they_move_in_a_minute() -> None:
    went = trajectory(delta_s=np.radians([0, 1, -1, 0]), delta_b=np.radians([0, 0, 0, 2]))
    # 1 + 2 + (1 + 2) degrees in 1.5 s
    assert taken(went, measure="activity") == (pytest.approx(240.0), 3)  # type: ignore[comparison-overlap]
    assert taken(went, measure="activity", quantity="bow") == (pytest.approx(80.0), 3)  # type: ignore[comparison-overlap]
    assert taken(went, measure="activity", to_s=0.5) == (pytest.approx(120.0), 1)  # type: ignore[comparison-overlap]
    assert take_measure(went, rule(measure="activity", to_s=0)).counts is False
    by_hand = {"stern_by_hand": np.array([0.0, 0.0, 1.0, 0.0])}
    hands = replace(went, columns={**went.columns, **by_hand})
    assert taken(hands, measure="hand-travel")[0] == pytest.approx(80.0)


def test_distance_is_run_only_while_the_condition_holds() -> None:
    went = trajectory(x=[0, 3, 6, 9], y=[0, 4, 8, 12], u=[5, 5, 5, 0])
    assert taken(went, measure="distance") == (15.0, 3)
    assert taken(went, measure="distance", when="speed_m_s > 1") == (10.0, 2)


def test_limits_are_passed_for_as_long_as_they_are() -> None:
    limits = ExerciseLimits(depth_m_max=100.0, pitch_deg_max=5.0)
    went = trajectory(limits, z=[99, 101, 102, 99], theta=np.radians([0, 0, -6, -6]))
    assert taken(went, measure="beyond-limits") == (1.5, 1)
    assert taken(trajectory(), measure="beyond-limits") == (0.0, None)


def test_beyond_test_depth_is_by_the_lowest_point_of_the_hull() -> None:
    # 0.4 of 70.2 m by the sine of 30 degrees is 14.04 m
    went = trajectory(z=[240, 251, 245, 240, 255], theta=np.radians([0, 0, -30, 0, 0]))
    assert taken(went, measure="beyond-test-depth") == (pytest.approx(9.04), 2)  # type: ignore[comparison-overlap]
    assert taken(went, measure="time-beyond-test-depth") == (1.5, 1)
    assert taken(went, measure="beyond-test-depth", to_s=0.5) == (1.0, 1)
    assert taken(went, measure="time-beyond-test-depth", from_s=1.5) == (0.5, 4)


def test_a_boat_above_test_depth_is_beyond_it_by_nothing() -> None:
    for measure in ("beyond-test-depth", "time-beyond-test-depth"):
        assert taken(trajectory(z=[240, 250]), measure=measure) == (0.0, None)


def test_a_frozen_depth_is_not_held_against_the_crew() -> None:
    went = trajectory(z=[260, 260, 251], held_depth=[1, 1, 0])
    assert taken(went, measure="beyond-test-depth") == (1.0, 2)
    assert taken(went, measure="time-beyond-test-depth") == (0.5, 2)


@pytest.mark.parametrize("measure", ["beyond-test-depth", "time-beyond-test-depth"])
def test_a_boat_without_test_depth_is_not_judged_by_it(measure: str) -> None:
    boat = make_boat("bb2", "modified")
    hull = replace(boat.file.hull, test_depth_m=None)
    boat.file = replace(boat.file, hull=hull)
    found = take_measure(replace(trajectory(z=[500.0]), boat=boat), rule(measure=measure))
    assert (found.why, found.counts) == ("this boat has no test depth", False)


def test_an_answer_is_the_crews_next_order_after_the_onset() -> None:
    given = [
        order(1, 1, "bow planes dive 5"),  # at the tick, before it
        order(2, 1, "casualty stern-stuck", "schedule"),
        order(3, 2, "clear stern-stuck", "instructor at console"),
        order(4, 4, "bell astern full"),
        order(5, 5, "bow planes rise 9"),
    ]
    went = trajectory(orders=given, jam=[0, 0, 1, 1, 1, 1])
    jam = {"measure": "response", "casualty": "stern-stuck"}
    assert taken(went, **jam) == (1.5, 4)
    assert taken(went, **jam, orders=["bow"]) == (2.0, 5)
    assert take_measure(went, rule(**jam, orders=["blow"])).why == "it was not answered"
    assert take_measure(trajectory(), rule(**jam)).counts is False


def test_an_order_that_is_soon_turned_round_is_no_answer() -> None:
    jam = {"measure": "response", "casualty": "stern-stuck"}

    def answered(back: int) -> float | None:
        given = [order(1, 4, "bell astern full"), order(2, 10, "bow planes rise 9")]
        given.append(order(3, back, "bell ahead full"))
        return taken(trajectory(orders=given, jam=[0, 0, *[1] * 60]), **jam)[0]

    assert answered(44) == 4.5  # the next one
    assert answered(45) == 1.5  # after 20 s it stood


def test_in_a_freeze_an_answer_comes_at_the_tick_of_the_casualty_itself() -> None:
    given = [order(1, 1, "casualty stern-stuck", "instructor at x"), order(2, 1, "bell stop")]
    went = trajectory(orders=given, jam=[0, 0, 1, 1])
    assert taken(went, measure="response", casualty="stern-stuck") == (0.0, 1)


def test_each_ship_earns_its_own_part_of_the_marks(monkeypatch: pytest.MonkeyPatch) -> None:
    def value(*marked: int | None, false: tuple[int, ...] = ()) -> float | None:
        ships = tuple(Detection(str(i), 0, 0, each) for i, each in enumerate(marked))
        monkeypatch.setattr(tallied_record, "look_out", lambda _: LookOut(ships, false))
        return taken(trajectory(), measure="time-to-detect", full=10, zero=100)[0]

    assert value(20, 40, 60) == pytest.approx((10 + 20 + 30) / 3)
    assert value(20, 40, None) == pytest.approx((10 + 20 + 100) / 3)
    assert value(2, 40, 600) == pytest.approx((10 + 20 + 100) / 3)
    assert value(20, 40, 60, false=(4,)) == pytest.approx((10 + 20 + 30 + 30) / 3)
    assert value(None, None) is None


def test_air_is_the_least_share_of_what_the_banks_hold_full() -> None:
    main, emergency = (float(full) for full in BB2.vessel.bank_full)
    went = trajectory(bank_main=[main, main / 2, main], bank_emergency=[emergency] * 3)
    assert taken(went, measure="reserve-air", quantity="bank_main") == (pytest.approx(50.0), 1)  # type: ignore[comparison-overlap]
    both = 100.0 * (main / 2 + emergency) / (main + emergency)
    assert taken(went, measure="reserve-air") == (pytest.approx(both), 1)  # type: ignore[comparison-overlap]


def test_a_boat_without_the_part_is_not_judged_by_it() -> None:
    went = trajectory()
    lone = Trajectory(
        make_boat("remus100", "modified"),
        went.limits,
        (),
        went.ticks,
        went.columns,
        went.lateness,
        went.work,
    )
    found = take_measure(lone, rule(measure="lowest", quantity="bank_main"))
    assert (found.why, found.counts) == ("this boat has no bank_main", False)
    assert take_measure(lone, rule(measure="reserve-air")).counts is False


# Marks


@pytest.mark.parametrize(
    ("full", "zero", "value", "marks"),
    [(2, 12, 7, 50), (2, 12, 0, 100), (2, 12, 13, 0), (90, 50, 60, 25), (90, 50, 99, 100)],
)
def test_marks_are_in_proportion_between_full_and_none(
    full: float, zero: float, value: float, marks: float
) -> None:
    judged = rule(measure="broaches", full=full, zero=zero)
    assert marks_of(judged, value) == pytest.approx(marks)


def test_the_total_is_by_weight_and_of_what_counts_only() -> None:
    card = score_rules(
        trajectory(z=[100, 105]),
        rules(
            "[[scores]]\nname='a'\nmeasure='highest'\nquantity='depth'\nfull=100\nzero=110\n"
            "weight=3\n"
            "[[scores]]\nname='b'\nmeasure='lowest'\nquantity='depth'\nfull=100\nzero=90\n"
            "[[scores]]\nname='late'\nmeasure='lowest'\nquantity='depth'\nfull=1\nzero=9\n"
            "from_s=60\n"
        ),
    )
    assert [each.marks for each in card.scores] == [pytest.approx(50.0), 100.0, None]
    assert card.total == pytest.approx((3 * 50 + 100) / 4)
    assert card.scores[2].attained.why == "the record ends at 0.5 s"


def test_a_condition_that_is_never_met_earns_nothing() -> None:
    card = score_rules(trajectory(), (rule(measure="distance", when="depth > 50", full=9, zero=0),))
    assert card.total == 0.0
    assert card.scores[0].attained.why == "never depth > 50"


def test_a_run_without_rules_has_no_marks() -> None:
    assert score_rules(trajectory(), ()).total is None


# What a file may say


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("measure='overshot'", 'measure = "overshot": no such measure; nearest is overshoot'),
        ("measure='rms'", "[scores[0]] rms lacks quantity"),
        ("measure='alert-response'\nrank='alarms'", 'rank = "alarms"'),
        ("measure='response'\ncasualty='stern-stuck'\nrank='alarm'", "response has no use for it"),
        ("measure='rms'\nquantity='deph'", 'quantity = "deph": no such quantity; nearest is depth'),
        ("measure='rms'\nquantity='pitch'", "nobody orders it as such (depth, course, speed are)"),
        ("measure='broaches'\nquantity='depth'", 'quantity = "depth": broaches has no use for it'),
        ("measure='activity'\nquantity='depth'", "activity is of rudder or stern or bow"),
        ("measure='response'", "response lacks casualty"),
        ("measure='response'\ncasualty='stern-stuk'", "no such casualty; nearest is stern-stuck"),
        (
            "measure='response'\ncasualty='stern-stuck'\nfrom_s=5",
            "from_s = 5.0: response has no use",
        ),
        (
            "measure='response'\ncasualty='stern-stuck'\norders=['clear']",
            'orders = ["clear"]: must list',
        ),
        ("measure='broaches'\nfrom_s=9\nto_s=5", "to_s = 5.0: is before from_s"),
        ("measure='broaches'\nwhen='deph < 5'", "no quantity 'deph'; nearest is depth"),
        ("measure='broaches'\nzero=0", "zero = 0.0: must not be the value of full"),
        ("measure='broaches'\nweight=0", "weight = 0: must be above 0 to 1000"),
        ("measure='broaches'\nwieght=1", "wieght = 1: no such key; nearest is weight"),
        ("measure='overshoot'\nquantity='depth'", "overshoot lacks target"),
    ],
)
def test_a_wrong_rule_is_refused_with_table_key_value_and_what_would_be_right(
    text: str, message: str
) -> None:
    zero = "" if "zero" in text else "zero=3\n"
    with pytest.raises(ConfigError) as wrong:
        rules(f"[[scores]]\nname='it'\nfull=0\n{zero}{text}\n")
    assert any(message in problem for problem in wrong.value.problems), wrong.value.problems
    assert all(problem.startswith("drill.toml: ") for problem in wrong.value.problems)


def test_two_rules_of_one_name_are_refused() -> None:
    row = "[[scores]]\nname='it'\nmeasure='broaches'\nfull=0\nzero=3\n"
    with pytest.raises(ConfigError, match='two \\[\\[scores\\]\\] have the name "it"'):
        rules(row + row)


def test_a_formula_says_in_words_what_is_computed_from_when_to_when() -> None:
    judged = rule(
        measure="time-to", quantity="depth", target=100, band=2, from_s=60, when="speed > 3"
    )
    assert formula_of(judged) == (
        "time until depth is within 2 m of 100 m, for 30 s or to the end; where a window ends "
        "before, at its mean pace, from 60 s while speed > 3"
    )
    assert unit_of(judged) == "s"
    assert unit_of(rule(measure="highest", quantity="depth_ft")) == "ft"
    assert formula_of(rule(measure="rms", quantity="course")) == (
        "root of the mean of (course - what is ordered)^2, a term for each tick; no value where "
        "a condition holds for less than 30 s"
    )


@pytest.mark.parametrize("name", shipped_names("exercises"))
def test_every_shipped_exercise_is_scored_within_its_length(name: str) -> None:
    exercise = load_exercise(name)
    assert len(exercise.scores) >= 2
    end = exercise.heading.duration_s or 0.0
    assert all((each.score.from_s or 0.0) < end for each in exercise.scores)


# Exercises of one's own


def ran(folder: Path, *words: str) -> Done:
    return run_trainer(*words, cwd=folder, timeout=120)


@pytest.mark.process
def test_a_new_exercise_is_valid_has_the_name_given_and_is_never_written_over(
    tmp_path: Path,
) -> None:
    made = ran(tmp_path, "exercise", "new", "drill.toml", "--name", 'Lost in "fog"')
    assert made.stdout == "drill.toml written; next: trainer exercise check drill.toml\n"
    exercise = load_exercise(str(tmp_path / "drill.toml"))
    assert exercise.heading.name == 'Lost in "fog"'
    assert len(exercise.scores) == 5
    told = ran(tmp_path, "exercise", "check", "drill.toml")
    assert "crew    100 marks, won" in told.stdout, told.stderr

    before = (tmp_path / "drill.toml").read_bytes()
    again = ran(tmp_path, "exercise", "new", "drill.toml")
    assert (again.returncode, again.stderr) == (
        2,
        "trainer: drill.toml is there already: give a new name\n",
    )
    assert (tmp_path / "drill.toml").read_bytes() == before


@pytest.mark.process
def test_a_new_exercise_can_begin_as_a_shipped_one_with_comments(tmp_path: Path) -> None:
    words = ("exercise", "new", "drill.toml", "--from", "stern-plane-jam", "--name", "Our jam")
    assert ran(tmp_path, *words).returncode == 0
    text = (tmp_path / "drill.toml").read_text()
    assert text.startswith("# Copied from stern-plane-jam.")
    assert "# The gate: what must not be passed.\n[limits]" in text
    mine, shipped = load_exercise(str(tmp_path / "drill.toml")), load_exercise("stern-plane-jam")
    assert mine.heading.name == "Our jam"
    assert [each.score for each in mine.scores] == [each.score for each in shipped.scores]
    other = ran(tmp_path, "exercise", "new", "other.toml", "--from", "stern-plane-jm")
    assert other.returncode == 2
    assert "nearest is stern-plane-jam" in other.stderr


@pytest.mark.process
def test_a_name_that_cannot_be_leaves_no_file(tmp_path: Path) -> None:
    done = ran(tmp_path, "exercise", "new", "drill.toml", "--name", "x" * 56)
    assert done.returncode == 2
    assert "must have 1 to 55 characters" in done.stderr
    assert list(tmp_path.iterdir()) == []


@pytest.mark.process
def test_a_check_tells_what_an_exercise_is_or_all_that_is_wrong(tmp_path: Path) -> None:
    told = ran(tmp_path, "exercise", "check", "crash-stop").stdout
    assert "name    Stop when told" in told
    assert "hand    speed, ballast" in told
    assert "limit   pitch_deg_max 15" in told
    assert "score   60 % of tasks Way run until stopped: sum of the way" in told
    assert "nobody  0 marks, not reached: " in told
    assert "crew    100 marks, won" in told
    assert "note" not in told

    (tmp_path / "drill.toml").write_text(SHORTEST + "speed = 5\n[limits]\ndepth_max = 9\n")
    wrong = ran(tmp_path, "exercise", "check", "drill.toml")
    assert wrong.returncode == 2
    assert len(wrong.stderr.splitlines()) == 2


@pytest.mark.process
def test_a_check_notes_what_may_not_be_meant(tmp_path: Path) -> None:
    (tmp_path / "drill.toml").write_text(
        SHORTEST + 'vessel = "remus100"\nduration_s = 60\n'
        "[[orders]]\nat_s = 90\norder = 'depth 5'\n"
        "[[scores]]\nname='late'\nmeasure='lowest'\nquantity='depth'\nfull=1\nzero=9\nfrom_s=70\n"
        "[[scores]]\nname='air'\nmeasure='lowest'\nquantity='bank_main'\nfull=1\nzero=9\n"
    )
    done = ran(tmp_path, "exercise", "check", "drill.toml")
    assert done.returncode == 0, done.stderr
    notes = [line for line in done.stdout.splitlines() if line.startswith("note")]
    assert notes == [
        "note    score late: begins after the end",
        "note    score air: this boat has no bank_main; it will not count",
        "note    depth 5 m: comes when the exercise is over",
    ]
