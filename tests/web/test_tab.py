"""A boat in a page: orders, readings, recordings and time are those of the session, to the bit."""

import hashlib
import math
import shutil
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest
from helpers.altered import alter
from helpers.exported import Row
from helpers.givers import giver_at
from helpers.orders import answer_of
from helpers.recorded import record
from helpers.tab import fly

from trainer.boat.boat import Boat
from trainer.boat.depths import DepthGuard
from trainer.boat.export.orders import order_rows
from trainer.boat.mute_crew import MuteCrew
from trainer.cli.export import boat_at_start
from trainer.debrief.marks.rehearsal import Departure
from trainer.debrief.marks.rehearsal import fly as flown_by_orders
from trainer.debrief.page.boat_page import boat_for_page, boat_of, boat_of_visitors
from trainer.io.recording.recording import RecordedOrder, Recording
from trainer.session.past.options import RunOptions
from trainer.session.past.plan import plan_run
from trainer.session.stations.channels import CHANNELS
from trainer.session.stations.past import PRESENT_CHANNELS
from trainer.session.stations.view import Pace, Picture, StateReader
from trainer.session.time.ledger import Ledger

pytestmark = pytest.mark.process

BOATS = ("bb2", "remus100", "sdv-mk9")
PLANT_ORDERS = [
    *("casualty oil-leak-header", "casualty port-bus-lost", "casualty fire-aft", "bus tie shut"),
    *("stern planes hand", "bow planes emergency", "isolate rudder", "hydraulic pump 2 stop"),
    *("fight fire aft", "ventilation secure"),
]
SEA_ORDERS = ("sea state 4", "sea from 045", "sea calm")


def digest_of(boat: Boat) -> str:
    """Return the SHA-256 of a boat's state."""
    return hashlib.sha256(boat.records.state.tobytes()).hexdigest()


def wordings(boat: Boat) -> list[str]:
    """Return orders of every row of a boat, with some numbers where one is taken."""
    found = []
    for row in map(Row, order_rows(boat)):
        low, high = row.typed
        numbers = {max(low, 0.0), *(math.floor(part * high) / 1000.0 for part in (370, 1000))}
        numbers |= {-1.0} if low < 0.0 else set()
        typed = [f"{row.words} {number:.3f}" for number in sorted(numbers)]
        found += typed if row.takes_number else [row.words]
    return [*found, *(["course 360"] if boat.automatic else [])]


# A kiosk


@pytest.mark.parametrize("angle", [-20, -8, 20])
def test_a_kiosks_lever_and_guard_are_those_of_a_session_to_the_bit(angle: int) -> None:
    boat, dive = boat_of_visitors(RunOptions(vessel="bb2"))
    page = boat_for_page(boat, "visitor") | {"visitors": dive}
    start = digest_of(boat)
    guard = DepthGuard(dive["guarded"])
    words = f"lever {'dive' if angle < 0 else 'rise'} {abs(angle)}"
    answer_of(boat, words)
    guarded = 0
    for _ in range(300):
        boat.tick()
        if order := guard.order(boat):
            answer_of(boat, order.text)
            guarded += 1

    deeds = [("order", words), ("fly", 300), ("digest",), ("order", "restart"), ("digest",)]
    answers = fly(page, *deeds)

    assert answers[2] == digest_of(boat)
    assert answers[-1] == start  # the next dive begins as the first did
    assert bool(guarded) == (angle < 0)


# Orders


@pytest.mark.parametrize("vessel", BOATS)
def test_every_order_writes_what_the_helm_writes(vessel: str) -> None:
    boat = boat_at_start(RunOptions(vessel=vessel))
    s = boat.state
    s.psi, s.ordered_psi, s.delta_r, s.u_c = 14.1, 2.5, -0.1, 0.7
    page = boat_for_page(boat, "instructor")
    start = boat.snapshot()
    said = [*wordings(boat), *SEA_ORDERS]
    said += [f"casualty {each['name']}" for each in page["casualties"]]
    expected = []
    for words in said:
        boat.restore(start)
        answer_of(boat, words)
        expected.append(digest_of(boat))

    numbers = start["whole"][0].tolist()
    deeds = [each for words in said for each in (("set", numbers), ("order", words), ("digest",))]
    answers = fly(page, *deeds)

    assert len(said) > 60
    for place, words in enumerate(said):
        assert answers[3 * place + 1]["ok"], (words, answers[3 * place + 1])
        assert answers[3 * place + 2] == expected[place], words


MEANT = (
    *("rudder port 15", "rud l 15", "hard left", "stern dive 12deg", "bow rise 4"),
    *("ahead 2/3", "bell astern full", "ahead one third", "depth 200 ft", "course 360"),
    *("speed 4 m/s", "turns -3", "rpm 40", "rpm -7.5 rpm", "vent all open"),
    *("flood depth-control 2.5 t", "blow mid", "clear all", "periscope", "planes auto"),
    *("casualty rudder-slow 0.5 ramp 20", "casualty stern-hard-over -0.5"),
    *("emergency blow", "pump trim aft 3", "drain centre"),
)


def test_words_mean_what_the_grammar_makes_of_them() -> None:
    boat = boat_at_start(RunOptions(vessel="bb2"))
    page = boat_for_page(boat, "instructor")
    answer_of(boat, "casualty gyro-biased")
    start = boat.snapshot()
    numbers = start["whole"][0].tolist()
    deeds = [each for words in MEANT for each in (("set", numbers), ("order", words), ("digest",))]

    answers = fly(page, ("order", "casualty gyro-biased"), ("digest",), *deeds)

    assert answers[1] == digest_of(boat)
    for words, answer, digest in zip(MEANT, answers[3::3], answers[4::3], strict=True):
        boat.restore(start)
        answer_of(boat, words)
        assert answer["ok"], (words, answer)
        assert digest == digest_of(boat), words


REFUSED = {
    "rudder left 40": "this boat takes 0 to",
    "rpm 900": "this boat takes -",
    "hover on": "not in this page",
    "order depth 80": "not in this page",
    "rudder 15": "say which way",
    "depth -5": "takes no sign",
    "fly": "is no order",
    "casualty kraken": "no casualty kraken",
    "casualty rudder-slow 7": "severity 7",
    "time 100": "x0.5 to x50",
    "time max": "x0.5 to x50",
    "backtrack 5 min": "before the start",
    "take over": "no replay",
    "restore here-and-there": "no snapshot",
    "<b>depth 5</b>": "is no order",
}


def test_what_cannot_be_done_is_refused_and_changes_nothing() -> None:
    boat = boat_at_start(RunOptions(vessel="bb2"))
    deeds = [each for words in REFUSED for each in (("order", words), ("digest",))]

    answers = fly(boat_for_page(boat, "instructor"), *deeds)

    for (words, why), answer, digest in zip(
        REFUSED.items(), answers[::2], answers[1::2], strict=True
    ):
        assert not answer["ok"], words
        assert why in answer["text"]
        assert digest == digest_of(boat), words


# Readings


@pytest.mark.parametrize("vessel", BOATS)
@pytest.mark.parametrize("ticks", [8, 300])  # 8: rates of the tick before would be others
def test_every_channel_shows_what_a_station_shows(vessel: str, ticks: int) -> None:
    boat = boat_at_start(RunOptions(vessel=vessel, sea="sea-state-2"))
    page = boat_for_page(boat, "instructor")
    orders = ["course 200", "depth 8", "casualty depth-gauge-biased", "casualty rudder-slow 0.4"]
    orders += PLANT_ORDERS if boat.file.plant else []
    for words in orders:
        answer_of(boat, words)
    for _ in range(ticks):
        boat.tick()
    reader = StateReader(boat, Ledger(boat.method.step).summary)
    frame = reader.frame(Picture(ticks, boat.records.state.tobytes(), Pace()))
    channels = page["channels"]  # of those the periscope's have no past
    shown = [name for name in channels if name not in PRESENT_CHANNELS]
    had = [each for each in CHANNELS.values() if each.lack(boat) is None]
    assert len(shown) == len(had) - len(PRESENT_CHANNELS) - 1  # the ghost's
    deeds = [("order", words) for words in orders]

    values = fly(page, *deeds, ("fly", ticks), *(("values", name) for name in shown))

    for name, found in zip(shown, values[len(orders) + 1 :], strict=True):
        for field, text in zip(CHANNELS[name].fields, found, strict=True):
            wanted = field.text(frame)
            if field.unit:
                assert bool(wanted) == bool(text), f"{name}.{field.name}: {text!r} for {wanted!r}"
                least = 1.1 * 10.0**-field.decimals  # the last digit may be rounded otherwise
                assert not wanted or abs(float(wanted) - float(text)) < least, (name, field.name)
            else:
                assert text == wanted, f"{name}.{field.name}"


# Recordings


@pytest.fixture(scope="module")
def drill(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a recording of an exercise with casualties, a crew's orders and a mark."""
    crew = {60.0: "depth 80", 61.5: "rudder left 10", 90.0: "mark <b>good</b>", 140.0: "course 30"}
    return record(tmp_path_factory.mktemp("drill") / "drill.trainer", "stern-plane-jam", crew)


def test_a_page_has_every_recorded_state_to_the_bit(drill: Path) -> None:
    boat, told_of = boat_of(drill)
    page = boat_for_page(boat, "instructor") | {"recording": told_of}
    recording = Recording.look(drill)
    states = dict(recording.states(1))
    recording.close()
    last = max(states)
    ticks = sorted({*range(0, last, 97), 120, 121, last})

    found = fly(page, *(("visit", tick) for tick in ticks))

    assert last > 500
    assert found == [hashlib.sha256(states[tick]).hexdigest() for tick in ticks]


def test_a_recording_is_what_was_ordered_and_what_it_was_about(drill: Path) -> None:
    _, told_of = boat_of(drill)
    (branch,) = told_of["branches"]

    exercise = dict(told_of["exercise"])
    assert exercise["title"] == "Passage, fast and deep"
    assert any("On passage: course 000" in words for _, words in told_of["exercise"])
    assert branch["after"] == []  # the core predicts all that nobody ordered
    assert sum(len(writes) for _, writes in branch["before"]) < 100


def test_what_the_core_does_not_predict_is_kept_as_it_was(drill: Path, tmp_path: Path) -> None:
    changed = tmp_path / "changed.trainer"
    shutil.copy(drill, changed)
    recording = Recording.look(drill)
    states = dict(recording.states(1))
    recording.close()
    numbers = np.frombuffer(states[300]).copy()
    numbers[7] += 1.0
    alter(changed, "UPDATE states SET state = ? WHERE tick = 300", numbers.tobytes())

    boat, told_of = boat_of(changed)
    page = boat_for_page(boat, "instructor") | {"recording": told_of}
    odd, next_one = fly(page, ("visit", 300), ("visit", 301))

    assert odd == hashlib.sha256(numbers.tobytes()).hexdigest()
    assert next_one == hashlib.sha256(states[301]).hexdigest()


@pytest.mark.parametrize("moment", [40.0, 61.5, 133.0])
def test_taking_over_ends_in_the_bits_of_a_resumed_run(moment: float, drill: Path) -> None:
    boat, told_of = boat_of(drill)
    page = boat_for_page(boat, "instructor") | {"recording": told_of}
    recording = Recording.look(drill)
    tick = round(moment / boat.method.step)
    state = recording.state_at(1, tick)
    end = recording.last_tick(1)
    scheduled = {each.tick: each.text for each in recording.orders(1) if each.entry is not None}
    recording.close()
    breaks = {at: text for at, text in scheduled.items() if text.startswith(("casualty", "clear"))}
    assert breaks
    assert state is not None
    boat.restore(np.frombuffer(state, boat.records.state.dtype))
    for words, ticks in (("rudder right 8", 40), ("depth 55", 300)):
        answer_of(boat, words)
        for _ in range(ticks):
            boat.tick()
            if boat.ticks in breaks:  # the exercise goes on by its own schedule
                answer_of(boat, breaks[boat.ticks])

    back = f"backtrack {(end - tick) * boat.method.step:.1f}"
    answers = fly(
        page,
        ("order", back),
        ("order", "rudder right 8"),
        ("fly", 40),
        ("order", "depth 55"),
        ("fly", 300),
        ("digest",),
    )

    assert answers[0]["ok"], answers[0]
    assert answers[-1] == digest_of(boat)


def test_branches_begin_each_at_its_parents_moment(drill: Path, tmp_path: Path) -> None:
    path = tmp_path / "branches.trainer"
    shutil.copy(drill, path)
    boat, _ = boat_of(drill)
    recording = Recording.reopen(path)
    flown = {1: dict(recording.states(1))}
    for parent, tick, words in (
        (1, 100, "depth 60"),
        (2, 150, "rudder left 3"),
        (1, 60, "turns 4"),
    ):
        moment = recording.moment(parent, tick)
        assert moment is not None
        boat.restore(np.frombuffer(moment.state, boat.records.state.dtype))
        number = recording.fork(moment, f"to tick {tick}")
        order = recording.order(tick, giver_at("instructor"), words)
        recording.answered(order, answer_of(boat, words), accepted=True)
        flown[number] = {}
        for _ in range(80):
            boat.tick()
            recording.state(boat.ticks, boat.records.state.tobytes())
            flown[number][boat.ticks] = boat.records.state.tobytes()
    recording.close()
    start, told_of = boat_of(path)
    page = boat_for_page(start, "instructor") | {"recording": told_of}

    found = fly(
        page,
        ("visit", 60),
        ("visit", 61),
        ("visit", 140),
        ("order", "branch 3"),
        ("digest",),
        ("visit", 149),
        ("visit", 40),
    )

    present = [flown[1][60], flown[4][61], flown[4][140]]
    third = [flown[3][230], flown[2][149], flown[1][40]]
    digests = [hashlib.sha256(state).hexdigest() for state in (*present, *third)]
    assert [each for each in found if isinstance(each, str)] == digests


def test_a_replay_shows_the_branch_again_and_a_new_one_begins_where_it_is_taken_over(
    drill: Path,
) -> None:
    boat, told_of = boat_of(drill)
    page = boat_for_page(boat, "instructor") | {"recording": told_of}
    recording = Recording.look(drill)
    end = recording.last_tick(1)
    state = recording.state_at(1, end - 100)
    recording.close()
    assert state is not None

    answers = fly(
        page,
        ("order", "replay 100"),
        ("order", "rudder left 5"),
        ("fly", 100),
        ("digest",),
        ("order", "take over"),
        ("order", "rudder left 5"),
        ("order", "branch 1"),
        ("digest",),
        ("sent",),
    )

    assert not answers[1]["ok"]
    assert answers[3] == hashlib.sha256(state).hexdigest()
    assert "branch 3 begins" in answers[4]["text"]  # the second is the way shown
    assert ["back", "take over"] in [each["fields"][2:] for each in answers[-1]]
    assert answers[5]["ok"]
    assert "branch 4 begins" in answers[6]["text"]
    assert answers[7] != answers[3]


# Time


def test_time_goes_as_fast_as_it_is_ordered() -> None:
    page = boat_for_page(boat_at_start(RunOptions(vessel="bb2")), "instructor")

    found = fly(
        page,
        ("order", "run"),
        ("pass", [10_000, False]),
        ("order", "time 50"),
        ("pass", [10_000, False]),
        ("order", "time 0.5"),
        ("pass", [10_000, False]),
        ("order", "freeze"),
        ("pass", [10_000, False]),
        ("order", "step 7"),
        ("pass", [0, False]),
    )

    assert [found[place] for place in (1, 3, 5, 7, 9)] == [20, 1020, 1030, 1030, 1037]


@pytest.mark.parametrize("asleep", [3_600_000, 4_000])
def test_a_tab_that_was_asleep_goes_on_from_where_it_stood_and_says_so(asleep: int) -> None:
    page = boat_for_page(boat_at_start(RunOptions(vessel="bb2")), "instructor")

    _, before, _, after, sent = fly(
        page,
        ("order", "run"),
        ("pass", [5_000, False]),
        ("sent",),
        ("pass", [asleep, True]),
        ("sent",),
    )

    assert before == 10
    assert after == 11  # the tick that was due, and no burst
    gaps = [each["fields"][3] for each in sent if each["kind"] == "TRE"]
    assert len(gaps) == 1
    assert "asleep for" in gaps[0]


def test_a_short_delay_is_made_up() -> None:
    page = boat_for_page(boat_at_start(RunOptions(vessel="bb2")), "instructor")

    found = fly(page, ("order", "run"), ("pass", [5_000, False]), ("pass", [2_000, True]))

    assert found[1:] == [10, 14]


# The way shown


def orders_of(path: Path) -> dict[int, list[RecordedOrder]]:
    """Return the orders of a recording by tick."""
    by_tick: dict[int, list[RecordedOrder]] = {}
    with closing(Recording.look(path)) as recording:
        for each in recording.orders(1):
            by_tick.setdefault(each.tick, []).append(each)
    return by_tick


def test_a_page_shows_the_way_that_a_session_would_from_where_it_broke(tmp_path: Path) -> None:
    path = record(tmp_path / "run.trainer", "stern-plane-jam", {})
    boat, facts = boat_of(path)
    begun, last = facts["way"]["branch"]["begun"], facts["way"]["branch"]["last"]
    plan = plan_run(RunOptions(exercise="stern-plane-jam", given=frozenset({"exercise"})))
    boat_there, crew = Boat(plan.file, plan.method), plan.crew
    plan.start(boat_there)
    due = orders_of(path)
    start = Departure(0, boat_there.snapshot(), (), MuteCrew(boat_there, crew))
    _, there = flown_by_orders(plan, start, due, speaks_from=begun, until=last)

    page = boat_for_page(boat, "instructor") | {"recording": facts}
    asked = [("order", "demonstrate"), ("fly", last - begun - 1), ("order", "rudder left 5")]
    answers = fly(
        page,
        ("digest",),
        *asked,
        ("values", "time"),
        ("sent",),
        ("visit", last),
        ("fly", 1),
        ("digest",),
        ("sent",),
        ("order", "demonstrate off"),
        ("order", "run"),
        ("order", "demonstrate"),
    )

    assert answers[1]["ok"], answers[1]
    assert answers[2] == last - 1
    assert answers[3]["text"] == "the reference crew shows the way: demonstrate off ends it"
    assert answers[4][-1] == "yes"
    said = [each["fields"][3] for each in answers[5] if each["kind"] == "TRE"]
    assert said[:2] == ["shown: bell astern full", "shown: bow planes rise 30"]
    assert answers[6] == hashlib.sha256(there.state.tobytes()).hexdigest()
    assert answers[8] == answers[0]  # back, to the bit
    assert any("the way has been shown" in each["fields"][-1] for each in answers[9])
    assert answers[10]["text"] == "the way is not being shown"
    assert answers[12]["text"] == "time runs: freeze first"


def test_a_page_without_a_reference_crew_says_so(tmp_path: Path) -> None:
    drill = tmp_path / "drill.toml"
    drill.write_text('schema = "exercise/1"\nname = "Alone"\nbriefing = "Sail."\nduration_s = 20\n')
    boat, facts = boat_of(record(tmp_path / "run.trainer", str(drill), {}))
    assert "way" not in facts
    page = boat_for_page(boat, "instructor") | {"recording": facts}
    (answer,) = fly(page, ("order", "demonstrate"))
    assert answer["text"].startswith("this page has no reference crew")
