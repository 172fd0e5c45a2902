"""The debrief: the page and its figures."""

import contextlib
import csv
import json
import math
import re
import shutil
import sqlite3
import subprocess
import sys
import threading
from collections import deque
from dataclasses import dataclass, replace
from html.parser import HTMLParser
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from helpers import node
from helpers.contrast import contrast
from helpers.givers import journalled
from helpers.sessions import begin_run, session_over
from helpers.whole_passage import broach_rows
from playwright.sync_api import Browser, expect

from trainer.boat.limits import LimitMonitor
from trainer.config.boat.vessel import load_vessel
from trainer.config.exercise.score_rules import SCORE_MEASURES
from trainer.config.files import ConfigError, shipped_path
from trainer.debrief.page.charts import charts_of, ground_of, unwrap_ordered_courses
from trainer.debrief.page.data import DebriefData, debrief_figures, gather_debrief
from trainer.debrief.page.page import (
    DebriefRequest,
    as_json,
    debrief_file,
    default_page_path,
    draw_track,
    read_dossier,
    render,
)
from trainer.debrief.page.sections import format_value, legend, pressed_together
from trainer.debrief.passage.recording_export import export_file
from trainer.io.recording.recording import RecordedOrder, Recording
from trainer.report import pdf
from trainer.report.html import PAGE_FOLDER
from trainer.report.pdf import print_pdf
from trainer.report.svg import ChartGround, clock, draw_chart, step_of, thin_line, ticks
from trainer.session.past.history import History
from trainer.session.past.options import RunOptions
from trainer.session.stations.roles import Access
from trainer.session.stations.station import Station
from trainer.session.stations.subscriptions import PromptSender, Roster
from trainer.session.stations.view import StateReader
from trainer.session.time.pacer import MonotonicClock, Policy
from trainer.session.time.timekeeping import Timekeeping

STYLE = (PAGE_FOLDER / "debrief.css").read_text(encoding="utf-8")
BROWSER = pdf.find_browser()
browsing = pytest.mark.skipif(BROWSER is None, reason="no Chromium, Chrome or Edge here")


@dataclass
class Panel:
    """A line of the crew, which says each order when its time has come."""

    name: str
    orders: deque[tuple[float, str]]
    wake: threading.Event
    now: float = 0.0
    trouble: str = ""
    dropped: int = 0
    ended: bool = False

    @property
    def due(self) -> bool:
        return bool(self.orders) and self.orders[0][0] <= self.now

    def take(self, most: int) -> list[str]:
        assert most > 10
        if not self.due:
            return []
        line = self.orders.popleft()[1]
        self.wake.set()  # there may be more
        return [line]

    def send(self, line: str) -> None:
        pass

    def close(self, patience: float) -> None:
        pass


@dataclass
class Voyage:
    """How it went."""

    debrief: DebriefData
    monitor: LimitMonitor


def fly(path: Path | None, crews: dict[str, str], **options: Any) -> Voyage:
    """Fly a run at full speed; ``crews`` has lines of SECONDS ORDER by the role of their panel."""
    chosen = RunOptions(**options, given=frozenset(options) - {"exercise"})
    plan, boat, header = begin_run(chosen)
    recording = Recording.create(path, header, boat.records.state.tobytes())
    time = Timekeeping.at(MonotonicClock(), plan.method.step, math.inf, Policy.SLIP)
    sending = PromptSender(Roster(StateReader(boat, time.ledger.summary)))
    session = session_over(
        boat,
        time,
        History(boat, recording),
        sending,
        schedule=plan.schedule,
        monitor=LimitMonitor.over(boat, plan.limits),
    )
    session.last_tick = round((plan.duration or 0.0) / plan.method.step)
    panels = []
    for role, lines in crews.items():
        timed = [line.split(maxsplit=1) for line in lines.strip().splitlines()]
        orders = deque(
            sorted(((float(at), words) for at, words in timed), key=lambda each: each[0])
        )
        panel = Panel(f"{role} panel", orders, session.wake)
        panels.append(panel)
        session.event_log.stations.append(
            Station(panel, Access(role), sending, session.event_log.log)  # type: ignore[arg-type]
        )

    def after_tick(tick: int) -> None:
        for panel in panels:
            panel.now = tick * plan.method.step
            if panel.due:
                session.wake.set()

    session.progress = after_tick
    session.wake.set()
    with np.errstate(all="ignore"):
        session.run()
    assert session.control.failure == "" or not crews
    debrief = gather_debrief(recording, path or Path("memory.trainer"), None)
    recording.close()
    return Voyage(debrief, session.monitors.limits)


# Numbers of the exported tables


EVERYTHING = """
schema = "exercise/1"
name = "All measures <at> once & more"
vessel = "./shallow.toml"
briefing = "A shallow boat in a sea, a jam, a blow."
duration_s = 240
seed = 5

[initial]
speed_kn = 6
depth_m = 12.5

[sea]
sea_state = 5
generator = "filter-1969"

[[orders]]
at_s = 20
order = "course left 170"

[[casualties]]
name = "stern-hard-over"
severity = -0.3
at_s = 100
clear_at_s = 130

[limits]
depth_m_max = 17
pitch_deg_max = 4
speed_kn_min = 5

"""
CREW = {
    "helm": "40 rudder left 20\n60 rudder auto\n110 bell astern full\n140 speed 8",
    "ballast": "104 blow aft\n120 blow stop",
    "instructor": "99 mark the jam comes <now>\n101 bow rise 5\n150 depth 25",
}
RULES: list[dict[str, Any]] = [
    {"measure": "overshoot", "quantity": "depth_m", "target": 25, "from_s": 150, "band": 3},
    {"measure": "overshoot", "quantity": "depth_ft", "target": 60, "to_s": 120},
    {"measure": "overshoot", "quantity": "course", "target": -120},
    {"measure": "time-to", "quantity": "depth", "target": 25, "band": 6, "from_s": 100},
    {"measure": "time-to", "quantity": "course_deg", "target": 190, "band": 60},
    {"measure": "reach", "quantity": "depth", "target": 25, "band": 6, "from_s": 100},
    {"measure": "reach", "quantity": "depth", "target": 14, "band": 6},
    {"measure": "settled", "quantity": "depth", "target": 25, "band": 8, "from_s": 60},
    {"measure": "final", "quantity": "depth", "to_s": 110},
    {"measure": "final", "quantity": "course_deg", "target": 190},
    {"measure": "largest", "quantity": "depth", "target": 15, "to_s": 100},
    {"measure": "highest", "quantity": "showing"},
    {"measure": "final", "quantity": "heavy_t"},
    {"measure": "rms", "quantity": "depth", "target": 15, "to_s": 90},
    {"measure": "rms", "quantity": "course_deg", "from_s": 30},
    {"measure": "rms", "quantity": "speed_kn"},
    {"measure": "in-band", "quantity": "depth", "target": 16, "band": 2.5},
    {"measure": "in-band", "quantity": "pitch_deg", "target": 0, "band": 2, "when": "depth > 16"},
    {"measure": "highest", "quantity": "depth", "when": "speed_kn > 3"},
    {"measure": "lowest", "quantity": "stern"},
    {"measure": "largest", "quantity": "pitch"},
    {"measure": "highest", "quantity": "bank_main_bar"},
    {"measure": "lowest", "quantity": "turns_rpm"},
    {"measure": "activity"},
    {"measure": "activity", "quantity": "rudder", "from_s": 30, "to_s": 90},
    {"measure": "hand-travel", "from_s": 20},
    {"measure": "distance", "when": "speed_kn > 5"},
    {"measure": "broaches"},
    {"measure": "beyond-limits", "from_s": 50},
    {"measure": "beyond-test-depth"},
    {"measure": "time-beyond-test-depth"},
    {"measure": "response", "casualty": "stern-hard-over"},
    {"measure": "response", "casualty": "stern-hard-over", "orders": ["bell", "bow"]},
    {"measure": "reserve-air"},
    {"measure": "reserve-air", "quantity": "bank_main", "to_s": 110},
]


def exercise_text() -> str:
    text = EVERYTHING
    for i, keys in enumerate(RULES):
        given = {"name": f"rule {i}", **keys, "full": 0, "zero": 50}
        lines = [f"{key} = {json.dumps(value)}" for key, value in given.items()]
        text += "[[scores]]\n" + "\n".join(lines) + "\n\n"
    return text


@dataclass
class Kept:
    """A recording with everything in it, and its tables as exported."""

    path: Path
    voyage: Voyage
    rows: list[dict[str, float]]


@pytest.fixture(scope="module")
def kept(tmp_path_factory: pytest.TempPathFactory) -> Kept:
    folder = tmp_path_factory.mktemp("everything")
    (folder / "all.toml").write_text(exercise_text())
    shallow = load_vessel("bb2").text.replace("test_depth_m = 250.0", "test_depth_m = 25.0")
    shallow = shallow.replace("start_depth_m = 60.0", "start_depth_m = 12.5")
    (folder / "shallow.toml").write_text(shallow.replace("collapse_depth_m", "# collapse_depth_m"))
    path = folder / "all.trainer"
    voyage = fly(path, CREW, exercise=str(folder / "all.toml"))
    export_file(path, {"csv": folder / "all.csv"}, None)
    with (folder / "all.csv").open(newline="") as stream:
        rows = [{k: float(v or math.nan) for k, v in row.items()} for row in csv.DictReader(stream)]
    return Kept(path, voyage, rows)


def test_the_ticks_of_a_run_have_numpys_percentiles(kept: Kept) -> None:
    debrief = kept.voyage.debrief
    work = debrief.trajectory.work[~np.isnan(debrief.trajectory.work)]
    found = (*np.percentile(work, (50.0, 99.0)), work.max())
    assert debrief.ticks.work == pytest.approx(found, rel=1e-12)


def value_in(kept: Kept, row: dict[str, float], quantity: str) -> float:
    """Return a quantity in its unit; BB2's stern planes rise with a negative angle."""
    boat = kept.voyage.debrief.trajectory.boat
    pressure = row["bank_main"] * float(boat.vessel.gas) / float(boat.vessel.bank_volume[0])
    values = {
        "showing": shows(boat.vessel, row),
        "depth": row["z"],
        "bank_main_bar": pressure / 1e5,
        "turns_rpm": row["u_c"] * boat.file.propulsion.rps_per_mps * 60.0,
        "stern": -math.degrees(row["delta_s"]),
    }
    return values[quantity]


def shows(vessel: Any, row: dict[str, float]) -> float:
    """Return how high [m] the highest part stands out of the water."""
    heights = []
    for x, z in (
        *((vessel.x_sail, vessel.z_sail), (vessel.ell / 4, vessel.z_deck)),
        (-vessel.ell / 4, vessel.z_deck),
    ):
        up = x * math.sin(row["theta"])
        up -= z * math.cos(row["theta"]) * math.cos(row["phi"])
        heights.append(up - row["z"] - row["eta_wave"])
    return float(max(heights))


def test_every_measure_is_judged_in_one_run(kept: Kept) -> None:
    around = {"aground", "closest-approach", "exposed", "exposed-raise", "time-to-detect"}
    around |= {"time-to-report"}
    around |= {"alert-response"}  # below; the others in tests/boat/world
    assert {keys["measure"] for keys in RULES} == set(SCORE_MEASURES) - around
    values = [each.attained.value for each in kept.voyage.debrief.card.scores]
    assert sum(value is not None and abs(value) > 1e-3 for value in values) >= 20


def test_broaches_and_limits_are_those_that_were_called_out(kept: Kept) -> None:
    called = kept.voyage.monitor.times
    trajectory = kept.voyage.debrief.trajectory
    assert [trajectory.seconds[row] for row in broach_rows(trajectory)] == called["broached"]
    assert len(called["broached"]) >= 2
    assert {"deeper than 17 m", "pitch more than 4 deg"} <= set(called)


def test_the_place_of_a_score_is_where_its_value_stands_in_the_record(kept: Kept) -> None:
    for keys, scored in zip(RULES, kept.voyage.debrief.card.scores, strict=True):
        if keys["measure"] in ("highest", "lowest"):
            row = kept.rows[scored.attained.tick or 0]
            assert value_in(kept, row, keys["quantity"]) == pytest.approx(scored.attained.value)


def test_the_figures_for_programs_are_those_of_the_page(kept: Kept) -> None:
    debrief = kept.voyage.debrief
    told = json.loads(json.dumps(debrief_figures(debrief)))
    assert told["total"] == debrief.card.total
    assert [each["value"] for each in told["scores"]] == [
        each.attained.value for each in debrief.card.scores
    ]
    (jam,) = told["casualties"]
    assert (jam["kind"], jam["begun_s"], jam["ended_s"]) == ("stern-hard-over", 100.0, 130.5)
    assert (jam["order"], jam["order_by"]) == ("blow aft", "ballast at ballast panel")
    assert jam["order_s"] == 104.0
    assert told["marks"][0]["remark"] == "the jam comes <now>"
    assert told["ticks"]["timed"] == 480


# Who is the crew


def test_with_stations_manned_the_instructors_orders_are_not_the_crews(kept: Kept) -> None:
    debrief = kept.voyage.debrief
    given = [each.text for each in debrief.trajectory.orders]
    assert "bow planes rise 5" in given
    assert {each.who.split()[0] for each in debrief.crew} == {"helm", "ballast"}
    assert [(hand.who.split()[0], hand.orders) for hand in debrief.hands] == [
        ("schedule", 3),
        ("helm", 4),
        ("instructor", 2),
        ("ballast", 2),
    ]


def test_alone_on_board_the_instructor_is_the_crew() -> None:
    went = fly(
        None,
        {"instructor": "5 casualty rudder-stuck\n8 speed 12\n20 clear rudder-stuck"},
        duration=30.0,
    )
    assert [each.text for each in went.debrief.crew] == ["speed 12 kn"]
    (found,) = went.debrief.casualties
    assert (found.episode.begun, found.episode.ended) == (10, 41)
    assert found.order
    assert found.order.tick == 16


def test_a_casualty_that_waited_for_a_condition_is_told_like_any_other(tmp_path: Path) -> None:
    (tmp_path / "drill.toml").write_text(
        'schema = "exercise/1"\nname = "Drill"\nbriefing = "Dive."\nduration_s = 60\n'
        "[[orders]]\nat_s = 5\norder = 'depth 80'\n"
        "[[casualties]]\nname = 'rudder-stuck'\nwhen = 'depth > 62'\n"
        "[[casualties]]\nname = 'bow-stuck'\nat_s = 58\n"
    )
    debrief = fly(None, {}, exercise=str(tmp_path / "drill.toml")).debrief
    (rudder, bow) = debrief.casualties
    trajectory = debrief.trajectory
    onset = trajectory.row(rudder.episode.begun)
    assert trajectory.columns["z"][onset] > 62.0
    assert trajectory.columns["z"][onset - 1] <= 62.0
    assert rudder.episode.ended is bow.episode.ended is None
    assert (bow.episode.begun, rudder.order) == (116, None)
    assert rudder.deflection
    assert rudder.deflection.surface in ("stern", "bow")


# Branches


@pytest.fixture(scope="module")
def wound_back(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a recording with a second branch, from 20 s on."""
    path = tmp_path_factory.mktemp("back") / "back.trainer"
    orders = (
        "10 speed 12\n40 mark first try\n40.5 backtrack 20.5\n40.5 run\n41 depth 90\n42 mark second"
    )
    fly(path, {"instructor": orders}, duration=60.0)
    return path


def test_each_branch_is_debriefed_with_its_own_past(wound_back: Path) -> None:
    latest, first = read_dossier(wound_back, None), read_dossier(wound_back, 1)
    assert (latest.branch.id, first.branch.id) == (2, 1)
    assert [float(each.trajectory.seconds[-1]) for each in (first, latest)] == [40.5, 60.0]
    assert [[e.text for e in d.of_kind("mark")] for d in (first, latest)] == [
        ["first try"],
        ["second"],
    ]
    assert np.array_equal(latest.trajectory.ticks, np.arange(121))
    assert "branch 2 of 2" in render(latest)
    assert re.search(r"<td>2 <b>debriefed here</b></td><td>branch 1</td><td>0:20 ", render(latest))


# The page


class Elements(HTMLParser):
    """What a page is made of."""

    def __init__(self) -> None:
        super().__init__()
        self.found: list[tuple[str, dict[str, str | None]]] = []
        self.opened: list[str] = []
        self.words: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.found.append((tag, dict(attrs)))
        if tag not in ("meta", "link", "br"):
            self.opened.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.found.append((tag, dict(attrs)))

    def handle_endtag(self, tag: str) -> None:
        assert self.opened.pop() == tag

    def handle_data(self, data: str) -> None:
        self.words.append(data)


@pytest.fixture(scope="module")
def page(kept: Kept) -> str:
    return render(kept.voyage.debrief)


def test_the_page_is_one_file_that_needs_nothing_else(page: str) -> None:
    elements = Elements()
    own, icons = re.subn(r'<link rel="icon" href="data:image/svg[^"]*">', "", page)
    assert icons == 1  # which is in the page itself
    elements.feed(own)
    assert elements.opened == []
    assert not [tag for tag, _ in elements.found if tag in ("script", "link", "img", "iframe")]
    assert not [keys for _, keys in elements.found if {"src", "onload"} & keys.keys()]
    led = [keys["href"] or "" for _, keys in elements.found if "href" in keys]
    names = {keys["id"] for _, keys in elements.found if "id" in keys}
    assert all(each[0] == "#" and each[1:] in names for each in led)
    assert not re.search(r"https?:|url\(|@import", own)


def test_the_page_shows_what_was_ordered_what_broke_and_what_was_said(page: str) -> None:
    elements = Elements()
    elements.feed(page)
    words = " ".join(elements.words)
    for told in (
        *("All measures <at> once & more", "the jam comes <now>", "Joubert BB2", "BROACHED"),
        *(
            "Depth [m]",
            "Pitch and heel [deg]",
            "Stern planes, rise positive [deg]",
            "Heading [deg]",
        ),
        *("Rudder, right positive [deg]", "Speed [kn]", "Air banks", "limit 17 m"),
        *("C1 stern-hard-over", "blow aft (ballast at ballast panel)", "keeping depth 25 m"),
        *("root of the mean of (depth - 15 m)^2", "480 ticks of 0.5 s timed", "duty cycle"),
    ):
        assert told in words, told
    assert sum(tag == "svg" for tag, _ in elements.found) == 10
    assert all(keys.get("aria-label") for tag, keys in elements.found if tag == "svg")


def press(
    second: float, text: str, *, who: str = "planes at line 2", taken: bool = True
) -> RecordedOrder:
    answer = f"{text}, by hand"
    return journalled(0, round(second / 0.5), who, text, answer, accepted=taken)


def test_keys_pressed_within_a_second_are_one_line_of_the_log() -> None:
    held = [press(0.5 * count, f"stern rise {count}") for count in range(1, 6)]
    other = [press(2.0, "rudder left 5", who="helm at line 3"), press(9.0, "stern rise 6")]
    refused = [press(9.5, "stern rise 7", taken=False), press(10.0, "stern rise 8")]

    groups = pressed_together(sorted([*held, *other, *refused], key=lambda key: key.tick), 0.5)

    assert [[order.text for order in group] for group in groups] == [
        [order.text for order in held],
        *(["rudder left 5"], ["stern rise 6"], ["stern rise 7"], ["stern rise 8"]),
    ]


def test_the_log_is_the_last_part_of_the_page(page: str) -> None:
    parts = re.findall(r'<section id="([a-z]+)"', page) or re.findall(r'id="([a-z]+)"', page)
    assert parts[-1] == "log"


def test_a_turning_circle_is_round_on_the_page() -> None:
    angle = np.linspace(0.0, math.tau, 241)
    columns = {"x": 300.0 * np.sin(angle), "y": 300.0 * np.cos(angle)}
    alone = SimpleNamespace(world=SimpleNamespace(parts={}))
    flown = SimpleNamespace(columns=columns, ticks=np.arange(241), boat=alone)
    debrief = SimpleNamespace(trajectory=flown)
    drawn = draw_track(debrief, ChartGround(0.5 * np.arange(241.0), ((20.0, 40.0),), ()))  # type: ignore[arg-type]
    track, broken = re.findall(r'class="line (?:actual|broken)" d="M([^"]*)"', drawn)
    x, y = np.array([[float(n) for n in place.split()] for place in track.split("L")]).T
    assert np.ptp(x) == pytest.approx(np.ptp(y), rel=0.01)
    assert np.ptp(x) > 200.0
    assert x[0] == pytest.approx(x.max())  # it begins in the east
    assert y[60] == pytest.approx(y.min())  # and goes north, which is up
    assert len(broken.split("L")) == pytest.approx(41, abs=1)
    assert "0:30" in drawn  # marks of time


def test_a_track_has_no_mark_of_a_time_that_is_not_recorded() -> None:
    seconds = np.concatenate((0.5 * np.arange(40), 50.0 + 0.5 * np.arange(140)))
    columns = {"x": 5.0 * seconds, "y": 0.0 * seconds}
    alone = SimpleNamespace(world=SimpleNamespace(parts={}))
    flown = SimpleNamespace(columns=columns, ticks=2 * seconds, boat=alone)
    debrief: Any = SimpleNamespace(trajectory=flown)
    whole = draw_track(debrief, ChartGround(seconds, (), ()))
    drawn = draw_track(debrief, ChartGround(seconds, (), (), holes=((19.5, 50.0),)))
    times = re.findall(r">(\d:\d\d)<", drawn)
    assert set(re.findall(r">(\d:\d\d)<", whole)) - set(times) == {"0:20", "0:30", "0:40"}
    assert {"0:00", "1:00"} <= set(times)


@pytest.mark.parametrize(
    ("value", "shown"),
    [
        (4.054e-16, "0"),
        (-4.054e-16, "0"),
        (0.036991, "0.03699"),
        (1234.56, "1235"),
        (2.5e-7, "2.5e-07"),
        (None, "-"),
    ],
)
def test_what_is_left_of_rounding_is_shown_as_0(value: float | None, shown: str) -> None:
    assert format_value(value) == shown


def test_lines_break_where_no_tick_was_recorded_and_the_page_says_where(kept: Kept) -> None:
    debrief = kept.voyage.debrief
    whole = debrief.trajectory
    rows = np.flatnonzero((whole.ticks < 40) | (whole.ticks >= 90))
    columns = {name: column[rows] for name, column in whole.columns.items()}
    part = replace(whole, ticks=whole.ticks[rows], columns=columns)
    with_hole = replace(debrief, trajectory=part)
    ground = ground_of(with_hole)

    charts = [draw_chart(each, ground) for each in charts_of(part)]
    actual = [re.findall(r'class="line actual" d="([^"]*)"', each)[0] for each in charts]
    assert {path.count("M") for path in actual} == {2}
    track = draw_track(with_hole, ground)
    assert track.count('class="line actual"') == 2
    assert "No tick was recorded between 19.5 s and 45 s." in legend(with_hole)
    assert "recorded" not in legend(debrief)


def test_lines_differ_in_more_than_colour() -> None:
    dashes = {
        name: rule
        for name, rule in re.findall(
            r"svg \.([a-z.-]+) \{ stroke: var\([^}]*?(?:dasharray: ([\d ]+);[^}]*|)\}", STYLE
        )
        if name in ("actual", "ordered", "second", "fine", "beside", "from-here")
    }
    assert len(dashes) == 6
    assert len(set(dashes.values())) == 6


def test_words_and_lines_stand_out_from_the_paper_in_the_light_in_the_dark_and_printed() -> None:
    schemes = re.findall(r":root \{([^}]*)\}", STYLE)
    assert len(schemes) == 3
    for scheme in schemes:
        colours = dict(re.findall(r"--([a-z]+): (#[0-9a-f]+)", scheme))
        for name in ("ink", "soft", "told", "first", "second"):
            assert contrast(colours[name], colours["paper"]) >= 4.5, (name, scheme)


def test_the_same_record_gives_the_same_page(kept: Kept, page: str) -> None:
    assert render(read_dossier(kept.path, None)) == page


def test_a_run_without_exercise_casualty_or_tanks_has_its_page_too(tmp_path: Path) -> None:
    went = fly(tmp_path / "small.trainer", {}, vessel="remus100", duration=20.0, sea="sea-state-2")
    told = render(went.debrief)
    assert "A run without an exercise" in told
    assert "This run has no scoring rules." in told
    assert "Nothing broke." in told
    assert "nan" not in told


def test_a_run_that_has_only_begun_has_its_page(tmp_path: Path) -> None:
    path = tmp_path / "short.trainer"
    fly(path, {}, exercise="stern-plane-jam", duration=0.5)
    told = render(read_dossier(path, None))
    assert "The record ends at 0:00.5; the exercise lasts 10:00." not in told  # overruled: 0.5 s
    assert "nan" not in told


def test_a_record_that_ends_early_says_so_and_what_counts(tmp_path: Path) -> None:
    path = tmp_path / "short.trainer"
    fly(path, {"instructor": "70 quit"}, exercise="heavy-boat")
    told = render(read_dossier(path, None))
    assert "The record ends at 1:10; the exercise lasts 30:00." in told
    assert "<b>Not reached</b>" in told
    assert "the record ends at 70 s" in told


# Files


def test_the_page_goes_beside_the_recording_and_is_told(
    wound_back: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    debrief_file(wound_back, None, None, DebriefRequest())
    made = wound_back.with_name("back.html")
    assert capsys.readouterr().out == f"{made}\n"
    assert made.read_text(encoding="utf-8").startswith("<!DOCTYPE html>")
    assert default_page_path(wound_back, 1).name == "back.branch1.html"

    debrief_file(wound_back, None, None, DebriefRequest())  # its own is made anew
    made.write_text("my notes")
    with pytest.raises(ConfigError, match="is there and is no debrief: say --html FILE"):
        debrief_file(wound_back, None, None, DebriefRequest())
    assert made.read_text() == "my notes"
    made.unlink()


def test_figures_are_printed_without_writing_a_page(
    wound_back: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    before = sorted(wound_back.parent.iterdir())
    debrief_file(wound_back, None, None, DebriefRequest(1), as_json)
    assert json.loads(capsys.readouterr().out)["branch"] == 1
    assert sorted(wound_back.parent.iterdir()) == before


def test_the_recording_is_never_written_over(wound_back: Path) -> None:
    before = wound_back.read_bytes()
    with pytest.raises(ConfigError, match="is an input here; give another name"):
        debrief_file(wound_back, wound_back, None, DebriefRequest())
    assert wound_back.read_bytes() == before


def test_what_is_no_recording_or_of_another_version_is_told(
    wound_back: Path, tmp_path: Path
) -> None:
    with pytest.raises(ConfigError, match=r"nothing\.trainer"):
        read_dossier(tmp_path / "nothing.trainer", None)
    other = tmp_path / "other.trainer"
    shutil.copyfile(wound_back, other)
    with contextlib.closing(sqlite3.connect(other)) as file, file:
        (layout,) = file.execute("SELECT value FROM header WHERE key = 'layout'").fetchone()
        changed = layout.replace('"theta"', '"trim"')
        file.execute("UPDATE header SET value = ? WHERE key = 'layout'", (changed,))
    file.close()
    with pytest.raises(ConfigError, match="another version of the trainer: no theta"):
        read_dossier(other, None)


# Paper


def test_without_a_browser_the_next_step_is_told(
    wound_back: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(pdf, "find_browser", lambda: None)
    with pytest.raises(ConfigError, match="no Chromium, Chrome or Edge is on this machine"):
        debrief_file(wound_back, None, tmp_path / "a.pdf", DebriefRequest())
    assert list(tmp_path.iterdir()) == []


@pytest.mark.process
def test_a_browser_that_prints_nothing_is_told_with_what_it_said(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "page.html").write_text("<p>hello</p>")
    monkeypatch.setattr(pdf, "find_browser", lambda: sys.executable)
    with pytest.raises(ConfigError, match=r"printed nothing: Try .*for more information"):
        print_pdf(tmp_path / "page.html", tmp_path / "page.pdf")


@pytest.mark.process
@browsing
def test_a_browser_opens_the_page_without_an_error_and_prints_it(
    kept: Kept, page: str, tmp_path: Path
) -> None:
    assert BROWSER
    html = tmp_path / "debrief.html"
    html.write_text(page, encoding="utf-8")
    words = ["--headless", "--disable-gpu", "--enable-logging=stderr", "--v=0", "--dump-dom"]
    words += ["--no-sandbox", f"--user-data-dir={tmp_path / 'profile'}", html.as_uri()]

    opened = subprocess.run(
        [BROWSER, *words], capture_output=True, text=True, timeout=120, check=False
    )

    assert "All measures &lt;at&gt; once" in opened.stdout
    assert "CONSOLE" not in opened.stderr

    debrief_file(kept.path, None, tmp_path / "debrief.pdf", DebriefRequest())
    assert (tmp_path / "debrief.pdf").read_bytes().startswith(b"%PDF")
    assert (tmp_path / "debrief.pdf").stat().st_size > 50_000


# Axes


@pytest.mark.parametrize(
    ("span", "most", "step"), [(10, 6, 2.0), (1, 6, 0.2), (700, 7, 100.0), (0.03, 6, 0.005)]
)
def test_ticks_are_round_numbers(span: float, most: int, step: float) -> None:
    assert step_of(span, most) == pytest.approx(step)
    assert len(ticks(0.0, span, step)) <= most + 1


@pytest.mark.parametrize(
    ("seconds", "told"), [(0, "0:00"), (59.96, "1:00"), (90.5, "1:30.5"), (3605, "1:00:05")]
)
def test_a_time_is_told_in_minutes_and_hours(seconds: float, told: str) -> None:
    assert clock(seconds) == told


def test_a_thinned_line_keeps_its_extremes() -> None:
    x = np.arange(10_000.0)
    y = np.sin(x / 700.0)
    y[4321], y[8765] = 5.0, -7.0
    kept_x, kept_y = thin_line(x, y, 400)
    assert kept_x.size <= 404
    assert {5.0, -7.0} <= set(kept_y.tolist())
    assert (kept_x[0], kept_x[-1]) == (0.0, 9999.0)


EVIL = '<script>alert("x")</script>'


def test_names_of_anybody_s_making_come_out_as_text(tmp_path: Path) -> None:
    boat = shipped_path("vessels", "bb2").read_text(encoding="utf-8")
    (tmp_path / "boat.toml").write_text(
        re.sub(r'(?m)^name = ".*"', f"name = '{EVIL}'", boat, count=1)
    )
    (tmp_path / "drill.toml").write_text(
        f"schema = 'exercise/1'\nname = '{EVIL}'\nbriefing = '''{EVIL}'''\nduration_s = 60\n"
        "vessel = './boat.toml'\n"
        f"[[scores]]\nname = '{EVIL}'\nmeasure = 'highest'\nquantity = 'depth'\n"
        "full = 0\nzero = 99\n"
        "[[casualties]]\nname = 'gyro-biased'\nat_s = 20\n"
    )
    path = tmp_path / "it.trainer"
    orders = f"30 mark {EVIL}\n40 rudder left 5"
    fly(path, {"helm": orders}, exercise=str(tmp_path / "drill.toml"))
    with contextlib.closing(sqlite3.connect(path)) as file, file:
        file.execute("UPDATE orders SET who = ?, text = text || ?, answer = ?", (EVIL, EVIL, EVIL))
        file.execute("UPDATE branches SET why = ?", (EVIL,))
        file.execute("UPDATE events SET who = ?", (EVIL,))

    text = render(read_dossier(path, None))

    elements = Elements()
    elements.feed(text)
    assert elements.opened == []
    assert not [tag for tag, _ in elements.found if tag == "script"]
    assert "".join(elements.words).count(EVIL) >= 8  # title, briefing, score, mark, order, who, ...
    assert "alert" not in re.sub(r"&lt;script&gt;alert\(&#34;x&#34;\)&lt;/script&gt;", "", text)


def test_an_ordered_course_is_drawn_without_a_jump_where_the_heading_passes_north() -> None:
    nan = math.nan
    # 180 by the right, then 000 by the left while the boat is a little beyond 180, then by hand
    ordered = np.array([180.0, 180.0, 0.0, 0.0, 0.0, nan, nan])
    heading = np.array([0.0, 180.0, 180.4, 90.0, 1.0, -2.0, -5.0])
    np.testing.assert_array_equal(unwrap_ordered_courses(ordered, heading), ordered)
    # ordered 010 while the boat, gone round once to the right, counts 350 to 371
    ordered, heading = np.full(3, 10.0), np.array([350.0, 360.0, 371.0])
    np.testing.assert_array_equal(unwrap_ordered_courses(ordered, heading), np.full(3, 370.0))
    # still 190 to go by the side that was ordered
    ordered, heading = np.full(2, 200.0), np.array([5.0, 10.0])
    np.testing.assert_array_equal(unwrap_ordered_courses(ordered, heading), ordered)


def test_a_debrief_tells_what_became_of_each_alert(tmp_path: Path) -> None:
    deep = tmp_path / "deep.toml"
    deep.write_text(
        'schema = "exercise/1"\nname = "Deep"\nbriefing = "Deep."\nvessel = "bb2"\n'
        "duration_s = 30\n[initial]\ndepth_m = 230\n"
        "[[scores]]\nname = 'Alerts seen'\nmeasure = 'alert-response'\nfull = 2\nzero = 6\n",
        encoding="utf-8",
    )
    said = "1 relief Ott\n2 ack silent 1\n4 ack 1\n5 blow all"
    fly(tmp_path / "deep.trainer", {"planes": said, "ballast": "6 blow all"}, exercise=str(deep))
    debrief = read_dossier(tmp_path / "deep.trainer", None)
    figures = debrief_figures(debrief)
    assert figures["alerts"] == [
        {
            "number": 1,
            "rank": "alarm",
            "alert": "Near test depth: 30 m above it",
            "raised_s": 0.0,
            "silenced": [{"at": "planes", "seconds": 2.0}],
            "acknowledged_s": 4.0,
            "acknowledged_by": "planes",
            "over_s": None,
        }
    ]
    assert [each["marks"] for each in figures["scores"]] == [pytest.approx(50.0)]
    assert figures["task_marks"][0]["whose"] == "planes (Ott)"
    page = render(debrief)
    assert "<td>planes (Ott) after 2 s</td>" in page
    assert "<td>planes (Ott) after 4 s</td>" in page
    assert "alert-note" not in page


@pytest.mark.process
def test_a_narrow_page_has_no_barrier_and_each_table_is_a_stop_of_the_tab_key(
    page: str, browser: Browser
) -> None:
    shown = browser.new_page(viewport={"width": 360, "height": 740})
    shown.set_content(page)
    shown.evaluate(node.axe())
    assert shown.evaluate(node.BARRIERS) == []
    assert shown.evaluate("document.documentElement.scrollWidth") == 360
    wide = shown.locator(".wide")
    assert wide.evaluate_all("(all) => all.some((each) => each.scrollWidth > each.clientWidth)")
    for each in wide.all():
        each.focus()
        expect(each).to_be_focused()
        expect(each).to_have_accessible_name(re.compile("Table"))
    expect(shown.locator("th:empty")).to_have_count(0)
    shown.close()
