"""The debrief beside the reference crew's run: where it went wrong, what cost, who takes over."""

import contextlib
import json
import math
import sqlite3
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.givers import journalled
from helpers.recorded import PANEL, record

from trainer.config.files import ConfigError
from trainer.debrief.charts import ground_of, runs_beside
from trainer.debrief.data import DebriefData, ReferenceComparison, debrief_figures
from trainer.debrief.episodes import read_backs
from trainer.debrief.judgement import costs
from trainer.debrief.page import DebriefRequest, draw_track, read_compared, render
from trainer.debrief.reference import can_fly, first_fault, join_runs, tasks_behind, window_extremes
from trainer.io.recording.facts import REFERENCE_GIVER
from trainer.io.recording.recording import RecordedOrder

pytestmark = pytest.mark.filterwarnings("ignore::RuntimeWarning")
JAM = {86.0: "bell astern full", 88.0: "bow planes rise 30", 130.0: "stern planes rise 12"}


def debriefed(path: Path, **asked: Any) -> DebriefData:
    return read_compared(path, DebriefRequest(**asked))


def beside(debrief: DebriefData) -> ReferenceComparison:
    assert debrief.compared
    return debrief.compared


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
def mastered(idle: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the recording of a crew that gave the very orders of the reference crew."""
    orders = beside(debriefed(idle)).reference.trajectory.orders
    own = [
        each for each in orders if each.giver == REFERENCE_GIVER and "planesman" not in each.text
    ]
    given = [(each.tick / 2.0, each.text) for each in own]
    path = tmp_path_factory.mktemp("mastered") / "mastered.trainer"
    return record(path, "depth-changes", given)


def test_the_reference_run_is_of_the_same_seed_and_wins(idle: Path) -> None:
    debrief = debriefed(idle)
    reference = beside(debrief).reference

    assert reference.rehearsal.plan.seed == debrief.plan.seed
    assert reference.card.verdict
    assert reference.card.verdict.outcome == "won"
    assert (reference.card.total or 0.0) > 85.0
    assert debrief.total == 0.0


def test_who_does_as_the_reference_crew_goes_nowhere_wrong(mastered: Path) -> None:
    debrief = debriefed(mastered)

    assert beside(debrief).fault is None
    assert debrief.total == pytest.approx(beside(debrief).reference.card.total, abs=3.0)
    assert "It did not: every task" in render(debrief)


def test_the_moment_is_where_the_depth_leaves_the_band_about_the_reference_run(idle: Path) -> None:
    """Both bands computed anew: 2 m and the time that full marks leave, 3 m and 10 s."""
    debrief = debriefed(idle)
    compared = beside(debrief)
    reference = compared.reference
    first = next(each for each in reference.card.scores if each.name == "Time to 100 m")
    early = max(180.0 - (first.attained.value or 0.0), 10.0)  # full marks less the reference's
    depths = reference.trajectory.columns["z"]
    own = debrief.trajectory.columns["z"]
    lag = round(early * 2)
    begin = 120  # [tick] when it is ordered
    found = next(
        tick
        for tick in range(begin, 900)
        if not any(abs(own[tick] - z) <= 2.0 for z in depths[max(tick - lag, 0) : tick + lag + 1])
        and own[tick] < min(depths[max(tick - lag, 0) : tick + lag + 1]) - 2.0
    )
    # "Settled" allows 10 s and 3 m: it may be the first
    settled = next(
        tick
        for tick in range(begin, 900)
        if own[tick] < min(depths[max(tick - 20, 0) : tick + 21]) - 3.0
    )

    assert compared.fault
    assert compared.fault.quantity == "depth"
    assert compared.fault.tick == min(found, settled)


def test_extremes_are_those_of_the_rows_about_each() -> None:
    values = np.random.default_rng(1).normal(size=40)
    for most in (0, 1, 3, 8, 40):
        padded = [values[max(i - most, 0) : i + most + 1] for i in range(40)]
        assert list(window_extremes(values, most, np.minimum)) == [each.min() for each in padded]
        assert list(window_extremes(values, most, np.maximum)) == [each.max() for each in padded]


def test_an_exercise_without_an_end_in_sight_is_not_flown_for_the_page(idle: Path) -> None:
    plan = debriefed(idle).plan
    assert can_fly(plan)
    assert not can_fly(replace(plan, duration=None))
    assert not can_fly(replace(plan, duration=1e15))


def test_a_departure_of_less_than_twenty_seconds_is_not_for_good(idle: Path) -> None:
    debrief = debriefed(idle)
    reference = beside(debrief).reference

    def away(seconds: float) -> Any:
        depth = reference.trajectory.columns["z"].copy()
        depth[600 : 600 + round(2 * seconds) + 1] -= 30.0  # while it is at 100 m
        columns = {**reference.trajectory.columns, "z": depth}
        moved = replace(reference.trajectory, columns=columns)
        return first_fault(moved, debrief.card, reference, debrief.plan, "qualified")

    assert away(19.0) is None
    assert away(21.0).tick == 600


def test_a_task_that_has_no_band_is_named_where_no_moment_can_be_told(tmp_path: Path) -> None:
    debrief = debriefed(record(tmp_path / "back.trainer", "backing", {}))
    compared = beside(debrief)
    assert compared.fault is None
    worse = tasks_behind(debrief.card, compared.reference.card)
    assert worse
    assert f"No one moment: {', '.join(worse)} fell short" in render(debrief)


def test_north_is_told_as_000(tmp_path: Path) -> None:
    debrief = debriefed(record(tmp_path / "north.trainer", "gyro-stuck", {}))
    fault = beside(debrief).fault
    assert fault
    assert fault.told.startswith("course 000; the band about the reference run was 000 to 0")


def test_a_late_answer_went_wrong_when_full_marks_ended(jam: Path) -> None:
    debrief = debriefed(jam)
    onset = debrief.casualties[0].episode.begun
    fault = beside(debrief).fault

    assert fault
    assert fault.tick == onset + 24  # 12 s
    assert fault.told == "an answer to stern-hard-over was due within 12 s; it came after 20 s"


def test_the_page_leads_to_that_moment_in_the_charts(idle: Path, jam: Path) -> None:
    told = render(debriefed(idle))
    assert '<a href="#wrong-depth">Go there</a>' in told
    assert 'id="wrong-depth"' in told
    assert '<a href="#wrong-timeline">Go there</a>' in render(debriefed(jam))


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


def test_a_broken_limit_is_told_with_what_it_cost(mastered: Path) -> None:
    debrief = debriefed(mastered)
    verdict = debrief.card.verdict
    assert verdict
    gated = replace(debrief.card, verdict=replace(verdict, gate="depth above 105 m", cap=50.0))
    (worst, *_) = sorted(costs(gated, None), key=lambda each: -each.marks)
    assert worst.told.startswith("A limit was broken (depth above 105 m): it cost ")
    assert worst.told.endswith("since at most 50 are left.")


# The reference from here


def test_the_reference_crew_takes_over_in_time_and_saves_the_boat(jam: Path) -> None:
    debrief = debriefed(jam, reference_from=78.0)
    taken = beside(debrief).from_here
    assert taken

    orders = [each for each in taken.trajectory.orders if each.giver == REFERENCE_GIVER]
    assert (orders[0].text, orders[0].tick) == ("bell astern full", 2 * 82)  # 4 s after it sees
    assert taken.trajectory.ticks[0] == 156
    then = debrief.trajectory.columns["z"][156]
    assert taken.trajectory.columns["z"][0] == then  # from the recorded state, to the bit
    assert taken.card.verdict
    assert taken.card.verdict.outcome != "lost"
    assert (taken.card.total or 0.0) > (debrief.total or 0.0) + 30.0
    assert "reference from 1:18" in render(debrief)


def test_a_run_joined_with_what_follows_has_each_tick_once(jam: Path) -> None:
    debrief = debriefed(jam, reference_from=300.0)
    taken = beside(debrief).from_here
    assert taken
    whole = join_runs(debrief.trajectory, taken.trajectory)
    assert np.array_equal(whole.ticks, np.arange(1201))
    own = debrief.trajectory.columns["z"]
    assert np.array_equal(whole.columns["z"][:601], own[:601])
    assert not np.array_equal(whole.columns["z"], own)
    given = [each.text for each in whole.orders if each.tick < 600 and each.place is None]
    assert given == list(JAM.values())


def test_what_the_reference_crew_had_done_by_then_is_not_done_again(jam: Path) -> None:
    taken = beside(debriefed(jam, reference_from=300.0)).from_here
    assert taken
    given = [each.text for each in taken.trajectory.orders if each.giver == REFERENCE_GIVER]
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
def test_orders_to_the_crew_are_told_with_their_repeats(mastered: Path, repeat: str) -> None:
    trajectory = debriefed(mastered).trajectory
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


def test_the_page_and_the_figures_tell_who_repeated(mastered: Path) -> None:
    debrief = debriefed(mastered)
    told = debrief_figures(debrief)["orders_to_crew"]
    assert [each["order"] for each in told] == ["depth 100 m", "depth 40 m"]
    assert told[0]["repeated_by"] is None
    assert "Orders to the crew" in render(debrief)


def test_the_instructors_words_are_in_the_page_and_escaped(idle: Path) -> None:
    told = render(debriefed(idle))
    assert "Marks and remarks" in told
    assert "nobody &lt;moved&gt;" in told


# What a run counts for


def test_a_casualty_brought_by_hand_makes_a_free_run_without_marks(tmp_path: Path) -> None:
    orders = {70.0: "casualty rudder-stuck"}
    path = record(tmp_path / "free.trainer", "depth-changes", orders, "instructor at a desk")
    debrief = debriefed(path)
    assert debrief.total is None
    assert debrief.free
    assert beside(debrief).fault is None
    told = render(debrief)
    assert "Casualty rudder-stuck at 1:10, by instructor at a desk." in told
    assert "<b>Free</b>, no marks" in told


def test_the_top_says_what_was_by_hand_and_how_sure_the_mark_is(tmp_path: Path) -> None:
    path = record(tmp_path / "sea.trainer", "depth-gauge-failure", {})
    debrief = debriefed(path)
    told = render(debrief)
    assert "By hand: planes; automatic: rudder, speed, ballast; allowed: depth, periscope." in told
    deviation = debrief_figures(debrief)["deviation"]
    assert deviation >= 0.5
    assert f"\N{PLUS-MINUS SIGN}{deviation:.0f} by the sea alone" in told
