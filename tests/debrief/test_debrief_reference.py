"""The debrief beside the reference crew's run: what each minute cost, and who takes over."""

import contextlib
import json
import math
import re
import sqlite3
from dataclasses import replace
from functools import cache, partial
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.few_points import look_at_few_moments
from helpers.givers import journalled
from helpers.recorded import PANEL, record

from trainer.config.exercise.outcome import Outcome
from trainer.config.files import ConfigError
from trainer.debrief.attainable.changes import FaultKind
from trainer.debrief.attainable.curve import AttainableCurve
from trainer.debrief.attainable.explorer import RunExplorer
from trainer.debrief.attainable.words import TEXT_COLUMNS, text_axis
from trainer.debrief.marks.judgement import costs
from trainer.debrief.marks.reference import can_fly, join_runs
from trainer.debrief.page.charts import attainable_chart, ground_of, runs_beside
from trainer.debrief.page.data import (
    DebriefData,
    ReferenceComparison,
    debrief_figures,
    judge_as_changed,
    order_givers,
    reference_from,
)
from trainer.debrief.page.page import DebriefRequest, as_text, draw_track, read_compared, render
from trainer.debrief.page.sections import OLDER_RULES, verdict
from trainer.debrief.passage.episodes import read_backs
from trainer.debrief.passage.trajectory import Trajectory
from trainer.debrief.trainees.history import came_of
from trainer.debrief.trainees.progress import run_of
from trainer.io.recording.facts import REFERENCE_GIVER, plan_of
from trainer.io.recording.recording import RecordedOrder
from trainer.report.svg import RIGHT_EDGE_PX, draw_chart

pytestmark = pytest.mark.filterwarnings("ignore::RuntimeWarning")
JAM = {86.0: "bell astern full", 88.0: "bow planes rise 30", 130.0: "stern planes rise 12"}


def debriefed(path: Path, **asked: Any) -> DebriefData:
    """Return the debrief of a recording that looks at few moments, made once for all tests."""
    return made_once(path, path.stat().st_mtime_ns, DebriefRequest(**asked))


@cache
def made_once(path: Path, _changed: int, asked: DebriefRequest) -> DebriefData:
    with pytest.MonkeyPatch.context() as patch:
        look_at_few_moments(patch)
        return read_compared(path, asked)


@cache
def debriefed_finely(path: Path) -> DebriefData:
    """Return the debrief of a recording as a user has it: it flies a hundred times."""
    return read_compared(path, DebriefRequest())


def beside(debrief: DebriefData) -> ReferenceComparison:
    assert debrief.compared
    return debrief.compared


def curve_of(debrief: DebriefData) -> AttainableCurve:
    curve = beside(debrief).curve
    assert curve
    return curve


@pytest.fixture(scope="module")
def idle(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a recording of two depth changes that nobody carried out."""
    path = tmp_path_factory.mktemp("idle") / "idle.trainer"
    return record(path, "depth-changes", {70.0: "mark nobody <moved>"}, "instructor at a desk")


@pytest.fixture(scope="module")
def jam(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a recording of jammed planes answered too late."""
    return record(tmp_path_factory.mktemp("jam") / "jam.trainer", "stern-plane-jam", JAM)


@pytest.fixture(scope="module")
def jammed(jam: Path) -> DebriefData:
    """Return the debrief of it, with the reference crew from a moment on."""
    return debriefed(jam, reference_from=78.0)


@pytest.mark.slow
def test_the_reference_run_is_of_the_same_seed_and_wins(idle: Path) -> None:
    debrief = debriefed(idle)
    reference = beside(debrief).reference

    assert reference.rehearsal.plan.seed == debrief.plan.seed
    assert reference.card.verdict
    assert reference.card.verdict.outcome == "won"
    assert (reference.card.total or 0.0) > 85.0
    assert debrief.total == 0.0


@pytest.mark.slow
def test_who_does_as_the_reference_crew_loses_nothing_at_any_minute(
    idle: Path, tmp_path: Path
) -> None:
    orders = beside(debriefed(idle)).reference.trajectory.orders
    own = [
        each for each in orders if each.giver == REFERENCE_GIVER and "planesman" not in each.text
    ]
    given = [(each.tick / 2.0, each.text) for each in own]
    debrief = debriefed_finely(record(tmp_path / "mastered.trainer", "depth-changes", given))

    assert curve_of(debrief).changes == ()
    assert debrief.total == pytest.approx(beside(debrief).reference.card.total, abs=3.0)
    assert "No minute cost marks" in render(debrief)


def test_the_curve_goes_from_the_reference_crew_s_mark_to_the_crew_s_own(idle: Path) -> None:
    debrief = debriefed(idle)
    curve = curve_of(debrief)

    assert curve.points[0].marks == beside(debrief).reference.card.total
    assert curve.points[-1].marks == debrief.total == 0.0
    marks = [point.marks for point in curve.points]
    assert max(after - before for before, after in pairwise(marks)) < 3.0  # nobody earns any
    assert curve.until_won is not None
    assert 120 < curve.until_won < 2 * 300  # the first depth is ordered at 60 s
    assert sum(change.marks for change in curve.changes) == pytest.approx(-marks[0], abs=5.0)


def test_an_exercise_without_an_end_in_sight_is_not_flown_for_the_page(idle: Path) -> None:
    plan = debriefed(idle).plan
    assert can_fly(plan)
    assert not can_fly(replace(plan, duration=None))
    assert not can_fly(replace(plan, duration=1e15))


def test_an_order_that_did_not_come_is_named_with_the_time_at_which_it_was_due(
    tmp_path: Path,
) -> None:
    debrief = debriefed(record(tmp_path / "back.trainer", "backing", {}))
    (change, *_) = curve_of(debrief).changes
    assert (change.fault, change.order) == (FaultKind.MISSING, "bell astern two-thirds")
    assert change.tick == 128
    assert '"bell astern two-thirds" was due at 1:04 and did not come' in " ".join(
        as_text(debrief).split()
    )


def test_the_page_leads_to_each_change_in_the_charts(jammed: DebriefData) -> None:
    told = render(jammed)
    assert '<a href="#change0-attainable">Go there</a>' in told
    assert 'id="change0-attainable"' in told
    assert "What could still be earned [marks]" in told


def test_a_page_without_the_boat_has_the_orders_that_lead_to_each_moment(
    jammed: DebriefData,
) -> None:
    (change, *_) = curve_of(jammed).changes
    told = render(jammed)
    assert change.tick
    lapse = f"<code>backtrack {600 - change.tick / 2:g} s</code>"
    assert f"Play from here: <code>branch 1</code>, {lapse}" in told
    assert f"<code>trainer resume {jammed.source.name}</code>" in told
    assert "data-orders" not in told
    flown = render(jammed, boat="<p>the boat</p>")
    assert f'data-orders="branch 1; backtrack {600 - change.tick / 2:g} s; run"' in flown
    assert "trainer resume" not in flown


def test_all_planned_orders_are_of_one_row(jammed: DebriefData) -> None:
    trajectory = jammed.trajectory
    planned = [
        replace(
            journalled(i, 100 + i, "instructor", "depth 80", ""), giver=plan_of("instructor", i)
        )
        for i in (1, 2, 3)
    ]
    givers = order_givers(replace(trajectory, orders=(*trajectory.orders, *planned)))
    assert [(each.who, each.orders) for each in givers][-1] == ("instructor at the plan", 3)


@pytest.mark.parametrize("rules", [{}, {"rules": "1"}])
def test_a_debrief_of_an_older_recording_says_that_it_is_marked_by_today_s_rules(
    jammed: DebriefData, rules: dict[str, str]
) -> None:
    older = {key: value for key, value in jammed.header.items() if key != "rules"}
    for show in (render, as_text):
        assert OLDER_RULES.partition(":")[0] not in " ".join(show(jammed).split())
        told = " ".join(show(replace(jammed, header={**older, **rules})).split())
        assert OLDER_RULES.partition(":")[0] in told


def test_the_values_of_an_axis_have_eighty_pixels(jammed: DebriefData) -> None:
    ends = {float(x) for x in re.findall(r'class="tick end" x="([\d.]+)"', render(jammed))}
    assert min(ends) >= 80.0


def test_the_chart_has_the_figure_of_each_change_and_none_lies_on_another(
    jammed: DebriefData,
) -> None:
    changes, chart = curve_of(jammed).changes, attainable_chart(jammed)
    assert chart
    fall = f"{changes[0].marks:+.0f}"
    drawn = re.compile(r'class="figure" x="([\d.]+)" y="([\d.]+)">([^<]+)<')
    assert [words for *_, words in drawn.findall(render(jammed))].count(fall) == 1
    crowded = replace(chart, figures=((70.0, "-20"), (71.0, "-30"), (599.0, "-9"), (600.0, "-7")))
    places = drawn.findall(draw_chart(crowded, ground_of(jammed)))
    assert [words for *_, words in places] == ["-20", "-30", "-9", "-7"]
    (_, first, _), (_, second, _), (_, third, _), (x, fourth, _) = places
    assert first != second
    assert third != fourth
    assert float(x) < RIGHT_EDGE_PX - 10.0  # not beyond the edge


@pytest.mark.parametrize(
    ("end", "moments"),
    [
        (600.0, ["0:00", "2:00", "4:00", "6:00", "8:00", "10:00"]),
        (650.0, ["0:00", "2:00", "4:00", "6:00", "8:00", "10:00"]),  # no room for 10:50
        (700.0, ["0:00", "2:00", "4:00", "6:00", "8:00", "10:00", "11:40"]),
        (0.5, ["0:00", "0:00.5"]),
    ],
)
def test_the_axis_in_a_terminal_names_moments_where_they_are(
    end: float, moments: list[str]
) -> None:
    axis = text_axis(0.0, end)
    assert axis.split() == moments
    assert len(f"      {axis}") <= 80
    if "4:00" in moments:
        assert axis.index("4:00") == round(240.0 / end * (TEXT_COLUMNS - 1))


def test_the_text_for_a_terminal_fits_eighty_columns(jammed: DebriefData) -> None:
    lines = as_text(jammed).splitlines()
    assert max(map(len, lines)) < 80
    assert any(line.startswith(" 100 |#") for line in lines)


def test_a_limit_stays_in_sight_and_the_sum_of_the_marks_is_folded(idle: Path) -> None:
    flown = debriefed(idle)
    assert flown.card.verdict
    capped = replace(flown.card, verdict=replace(flown.card.verdict, cap=50.0))
    page = str(verdict(replace(flown, card=capped, changed=None)))

    shown, fold = page.split("<details>")
    assert "At most 50 marks: " in shown
    assert "total = tasks" not in shown
    assert fold.startswith("<summary>How the marks came about</summary><p>Tasks ")


def test_without_keeping_lost_the_losses_are_all_that_lacks(idle: Path) -> None:
    debrief = debriefed(idle)
    verdict = debrief.card.verdict
    assert verdict
    tasks = [each for each in costs(debrief.card, None) if each.marks > 0.0]
    whole = 0.7 + 0.003 * verdict.keeping
    assert sum(each.marks for each in tasks) == pytest.approx((100.0 - verdict.tasks) * whole)
    assert len(debrief.costs) == 3
    assert "the reference crew" in debrief.costs[0].told
    assert debrief.costs[0].marks >= debrief.costs[1].marks >= debrief.costs[2].marks


def test_a_broken_limit_is_told_with_what_it_cost(idle: Path) -> None:
    card = beside(debriefed(idle)).reference.card
    verdict = card.verdict
    assert verdict
    gated = replace(card, verdict=replace(verdict, gate="depth above 105 m", cap=50.0))
    (worst, *_) = sorted(costs(gated, None), key=lambda each: -each.marks)
    assert worst.told.startswith("A limit was broken (depth above 105 m): it cost ")
    assert worst.told.endswith("since at most 50 are left.")


# The reference from here


def test_the_reference_crew_takes_over_in_time_and_saves_the_boat(jammed: DebriefData) -> None:
    taken = beside(jammed).from_here
    assert taken

    orders = [each for each in taken.trajectory.orders if each.giver == REFERENCE_GIVER]
    assert (orders[0].text, orders[0].tick) == ("bell astern full", 156)  # overdue
    assert taken.trajectory.ticks[0] == 156
    then = jammed.trajectory.columns["z"][156]
    assert taken.trajectory.columns["z"][0] == then  # from the recorded state, to the bit
    assert taken.card.verdict
    assert taken.card.verdict.outcome != "lost"
    assert (taken.card.total or 0.0) > (jammed.total or 0.0) + 30.0
    assert "reference from 1:18" in render(jammed)


def taken_over(debrief: DebriefData, seconds: float) -> Trajectory:
    """Return the run of the reference crew from a moment on, without a curve."""
    run = RunExplorer(debrief.plan, debrief.trajectory, partial(judge_as_changed, debrief))
    run.fly_again()
    return reference_from(debrief, run, round(2 * seconds)).trajectory


def test_a_run_joined_with_what_follows_has_each_tick_once(jammed: DebriefData) -> None:
    whole = join_runs(jammed.trajectory, taken_over(jammed, 300.0))
    assert np.array_equal(whole.ticks, np.arange(1201))
    own = jammed.trajectory.columns["z"]
    assert np.array_equal(whole.columns["z"][:601], own[:601])
    assert not np.array_equal(whole.columns["z"], own)
    given = [each.text for each in whole.orders if each.tick < 600 and each.entry is None]
    assert given == list(JAM.values())


def test_what_the_reference_crew_had_done_by_then_is_not_done_again(jammed: DebriefData) -> None:
    orders = taken_over(jammed, 100.0).orders  # the planes are still jammed
    given = [each.text for each in orders if each.giver == REFERENCE_GIVER]
    assert "bell astern full" not in given
    assert any(text.startswith("stern planes") for text in given)  # its planesman is at work


@pytest.mark.parametrize("seconds", [600.0, 7200.0])
def test_a_moment_beyond_the_record_is_told_with_its_end(jam: Path, seconds: float) -> None:
    with pytest.raises(ConfigError, match=rf"{seconds:g}: not within .* of 0 to 600 s"):
        debriefed(jam, reference_from=seconds)


def test_an_exercise_without_a_reference_crew_has_its_page(tmp_path: Path) -> None:
    (tmp_path / "drill.toml").write_text(
        'schema = "exercise/1"\nname = "Drill"\nbriefing = "Dive."\nduration_s = 60\n'
        '[[scores]]\nname = "Deep"\nmeasure = "highest"\nquantity = "depth"\nfull = 80\nzero = 60\n'
    )
    path = record(tmp_path / "drill.trainer", str(tmp_path / "drill.toml"), {5.0: "depth 70"})
    debrief = debriefed(path)
    assert debrief.compared is None
    assert "no reference crew to compare with" in render(debrief)
    assert debrief_figures(debrief)["reference"] is None
    with pytest.raises(ConfigError, match="--reference-from: this exercise has no reference crew"):
        debriefed(path, reference_from=20.0)


def test_a_recording_without_orders_to_the_crew_in_its_states_has_its_page(jam: Path) -> None:
    other = jam.with_name("older.trainer")
    other.write_bytes(jam.read_bytes())
    with contextlib.closing(sqlite3.connect(other)) as file, file:
        (layout,) = file.execute("SELECT value FROM header WHERE key = 'layout'").fetchone()
        names = [name.replace("crew_", "once_") for name in json.loads(layout)]
        file.execute("UPDATE header SET value = ? WHERE key = 'layout'", (json.dumps(names),))
    debrief = debriefed(other)
    assert np.isnan(debrief.trajectory.ordered("depth")).all()
    assert "Depth [m]" in render(debrief)


# Charts and track


def test_the_charts_show_what_the_crew_was_ordered_and_the_reference_run(idle: Path) -> None:
    debrief = debriefed(idle)
    ordered = debrief.trajectory.ordered("depth")
    assert math.isnan(ordered[119])
    assert (ordered[130], ordered[1000]) == (100.0, 40.0)
    told = render(debrief)
    assert told.count(">reference</text>") >= 8  # in every chart, and beside its orders
    assert told.count('class="line beside"') >= 8
    assert 'class="order-beside"' in told


def test_the_track_of_the_reference_run_is_laid_under(idle: Path) -> None:
    debrief = debriefed(idle)
    drawn = draw_track(debrief, ground_of(debrief), runs_beside(debrief))
    assert drawn.index('class="line beside"') < drawn.index('class="line actual"')


# Read-backs


def entry(number: int, second: float, who: str, text: str, answer: str) -> RecordedOrder:
    return journalled(number, round(2 * second), who, text, answer, accepted=bool(number))


@pytest.mark.parametrize("repeat", ["stand by", "tell stand by"])  # the second in older files
def test_orders_to_the_crew_are_told_with_their_repeats(idle: Path, repeat: str) -> None:
    trajectory = beside(debriefed(idle)).reference.trajectory
    said = (
        entry(1, 60, "schedule", "order depth 100 m", "ordered: depth 100 m"),
        entry(2, 62, PANEL, "depth 90 aye", "WRONG REPEAT: depth 90; ordered is depth 100 m"),
        entry(3, 64.5, PANEL, "aye", "depth 100 m aye"),
        entry(4, 480, "schedule", "order depth 40 m", "ordered: depth 40 m"),
        entry(5, 500, "instructor at a desk", "tell stand by", "told: stand by"),
        entry(6, 503, PANEL, "aye", f"{repeat} aye"),
    )
    first, second, words = read_backs(replace(trajectory, orders=said))

    assert (first.told, first.axis, first.wrong) == ("depth 100 m", "depth", ("depth 90",))
    assert first.repeated is said[2]
    depth = trajectory.columns["z"]
    kept = first.carried_out
    assert kept is not None
    assert np.all(np.abs(depth[kept : 2 * 480 + 1] - 100.0) <= 3.0)
    assert abs(depth[kept - 1] - 100.0) > 3.0
    assert second.repeated is None
    assert (words.told, words.axis, words.carried_out) == ("stand by", "words", None)
    assert words.repeated is said[5]


def test_the_page_and_the_figures_tell_who_repeated(idle: Path) -> None:
    debrief = debriefed(idle)
    told = debrief_figures(debrief)["orders_to_crew"]
    assert [each["order"] for each in told] == ["depth 100 m", "depth 40 m"]
    assert told[0]["repeated_by"] is None
    assert "Orders to the crew" in render(debrief)


# What a run counts for


def test_a_casualty_brought_by_hand_makes_a_free_run_without_marks(tmp_path: Path) -> None:
    orders = {70.0: "casualty rudder-stuck"}
    path = record(tmp_path / "free.trainer", "depth-changes", orders, "instructor at a desk")
    debrief = debriefed(path)
    assert debrief.total is None
    assert debrief.free
    assert debrief.costs == ()  # of marks that there are not
    assert beside(debrief).curve is None
    told = render(debrief)
    assert "There is no curve: a free run has no marks." in told
    assert "Casualty rudder-stuck at 1:10, by instructor at a desk." in told
    assert "<b>Free</b>, no marks" in told
    assert "go back to before that order, or begin again" in told


@pytest.mark.slow
def test_the_top_says_what_was_by_hand_and_how_sure_the_mark_is(tmp_path: Path) -> None:
    path = record(tmp_path / "sea.trainer", "depth-gauge-failure", {})
    debrief = debriefed(path)
    told = render(debrief)
    assert "By hand: planes; automatic: rudder, speed, ballast; allowed: depth, periscope." in told
    deviation = debrief_figures(debrief)["deviation"]
    assert deviation >= 0.5
    assert f"\N{PLUS-MINUS SIGN}{deviation:.0f} by the sea alone" in told


def test_the_top_says_what_model_people_say_of_the_mark_and_nothing_where_none_flew(
    tmp_path: Path,
) -> None:
    debrief = debriefed(record(tmp_path / "jam.trainer", "stern-plane-jam", {}))
    baseline = debrief.plan.baseline
    assert baseline
    assert baseline.people
    error = baseline.people.standard_error
    assert error > 15.0
    assert f"of 100 marks, \N{PLUS-MINUS SIGN}{error:.0f} from run to run" in render(debrief)
    assert f"only beyond {2.8 * error:.0f} marks" in render(debrief)
    assert f"of 100 marks, \N{PLUS-MINUS SIGN}{error:.0f} from run to run" in as_text(debrief)
    assert debrief_figures(debrief)["standard_error"] == error
    assert (run_of(debrief, Outcome.LOST).standard_error, came_of(debrief).standard_error) == (
        error,
        error,
    )

    assert baseline.crew
    by_sea = replace(baseline, crew=replace(baseline.crew, deviation=2.0))
    both = render(replace(debrief, plan=replace(debrief.plan, baseline=by_sea)))
    assert "\N{PLUS-MINUS SIGN}2 by the sea alone, \N{PLUS-MINUS SIGN}" in both
    assert f"only beyond {2.8 * error:.0f} marks" in both

    plan = replace(debrief.plan, baseline=replace(baseline, people=None))
    alone = replace(debrief, plan=plan)
    assert "from run to run" not in render(alone)
    assert debrief_figures(alone)["standard_error"] is None
    assert run_of(alone, Outcome.LOST).standard_error is None
