"""What Rerun's viewer is given, as numbers and words; the library itself is not needed here."""

import math
import threading
from typing import Any

import numpy as np
import pytest
from helpers.boats import make_boat

from trainer.boat.boat import Boat
from trainer.config.exercise.exercise import ExerciseLimits
from trainer.config.extras import advise_install
from trainer.config.files import ConfigError
from trainer.core.kernel import Numbers
from trainer.session.past.layout import LAYOUT
from trainer.session.past.options import RunOptions
from trainer.session.rerun import feed as feeds
from trainer.session.rerun.batch import (
    Batch,
    BatchCollector,
    Block,
    Changes,
    Subject,
    TakenNews,
    TakenPicture,
    Times,
    Track,
    states,
)
from trainer.session.rerun.charts import casualty_lanes, charts_of, lanes_of, ledger_columns
from trainer.session.rerun.feed import CHUNK_STATES, MAX_WAITING_STATES, Feed, Log
from trainer.session.rerun.request import VIEWER_PORT, open_log, parse_address
from trainer.session.rerun.shape import Fin, fins_of, hull_mesh, sail_mesh, size_of
from trainer.session.stations.station import News
from trainer.session.stations.subscriptions import PromptSender, Roster
from trainer.session.stations.view import Pace, StateReader
from trainer.session.time.ledger import Ledger

VESSELS = ("bb2", "remus100", "sdv-mk9")
PATIENCE = 60.0  # [s] for another thread
RUNNING, HURRIED = Pace(speed=1.0), Pace(speed=math.inf)


def block_of(rows: int, **columns: object) -> Block:
    """Return a block whose states are zero but for some columns."""
    whole = np.zeros((rows, len(LAYOUT)))
    for name, values in columns.items():
        whole[:, LAYOUT.index(name)] = values  # type: ignore[call-overload]
    ticks = np.arange(rows)
    branch = np.ones(rows, np.int64)
    return Block(Times(ticks, 0.5 * ticks), whole, branch, np.zeros(rows, np.bool_))  # type: ignore[arg-type]


def state_of(tick: int, **places: float) -> bytes:
    """Return a state that is zero but for its tick and some places."""
    whole = np.zeros(len(LAYOUT))
    whole[LAYOUT.index("tick")] = tick
    for name, value in places.items():
        whole[LAYOUT.index(name)] = value
    return whole.tobytes()


def taken(
    tick: int, timed: int | None = None, pace: Pace = RUNNING, **places: float
) -> TakenPicture:
    """Return a picture as a tick hands it over, the work of tick n being n us."""
    timed = tick - 1 if timed is None else timed
    return TakenPicture(tick, state_of(tick, **places), pace, timed, 0, 1000 * timed)


# The shape


def test_the_hull_is_as_long_broad_and_high_as_the_vessel_file_says() -> None:
    size = size_of(make_boat("bb2"))
    points = hull_mesh(size).points

    extent = points.max(axis=0) - points.min(axis=0)

    assert extent == pytest.approx([70.2, 9.6, 10.6], rel=1e-3)
    assert points[:, 0].max() == pytest.approx(32.3287)  # of the origin the nose is ahead
    assert size.sail is not None
    assert sail_mesh(size, size.sail).points[:, 2].min() == pytest.approx(-11.3724)


@pytest.mark.parametrize("vessel", VESSELS)
def test_every_boat_has_a_closed_hull_and_its_normals_point_outward(vessel: str) -> None:
    size = size_of(make_boat(vessel))
    mesh = hull_mesh(size)
    middle = np.abs(mesh.points[:, 0] - (size.nose - 0.4 * size.length)) < 0.1 * size.length

    outward = mesh.points[middle] * [0.0, 1.0, 1.0] - [0.0, 0.0, size.axis]

    assert np.all(np.einsum("ij,ij->i", mesh.normals()[middle], outward) > 0.0)
    assert np.isfinite(mesh.normals()).all()
    assert mesh.triangles.max() < len(mesh.points)


def trailing_edge(fin: Fin, block: Block) -> Numbers:
    """Return how far port and down the trailing edge of a fin goes, its chord being 1."""
    angle = float(fin.angle(block)[0])
    return math.sin(angle) * np.cross(fin.outward, (-1.0, 0.0, 0.0))[1:] * (-1.0, 1.0)


@pytest.mark.parametrize("vessel", VESSELS)
def test_a_right_rudder_has_its_trailing_edge_to_starboard(vessel: str) -> None:
    boat = make_boat(vessel)
    right = block_of(1, delta_r=boat.toward["rudder"] * 0.2)
    fins = [fin for fin in fins_of(boat, size_of(boat)) if abs(fin.outward[2]) > 0.5]

    for fin in fins:
        assert trailing_edge(fin, right)[0] < 0.0, fin.name


@pytest.mark.parametrize("vessel", VESSELS)
def test_planes_on_rise_go_up_aft_and_down_forward(vessel: str) -> None:
    boat = make_boat(vessel)
    toward = boat.toward
    rise = block_of(1, delta_s=toward["stern"] * 0.2, delta_b=toward["bow"] * 0.2)

    for fin in fins_of(boat, size_of(boat)):
        down = trailing_edge(fin, rise)[1]
        level = abs(fin.outward[1]) < 0.5
        assert down == 0.0 if level else down * (1 if fin.plane == "delta_b" else -1) > 0.0


def test_planes_stand_where_the_coefficients_say_that_their_lift_acts() -> None:
    boat = make_boat("bb2")
    stocks = {fin.name: fin.stock for fin in fins_of(boat, size_of(boat))}

    assert stocks["bow_port"][0] == pytest.approx(10.465, abs=1.0)  # sail_plane_position
    assert -11.37 < stocks["bow_port"][2] < -5.77  # between the sail's top and the deck
    assert stocks["tail_upper_port"][0] == pytest.approx(-31.924, abs=2.0)


# Charts and lanes


def test_a_chart_shows_an_order_only_while_it_is_kept() -> None:
    charts = {chart.name: chart for chart in charts_of(make_boat("bb2"))}
    block = block_of(
        3,
        z=50.0,
        ordered_depth=60.0,
        stern_by_hand=[0, 1, 1],
        bow_by_hand=[0, 1, 1],
        hover=[0, 0, 1],
    )

    columns = charts["depth"].columns(block)

    assert charts["depth"].labels == ["true", "ordered"]
    assert columns[:, 0].tolist() == [-50.0, -50.0, -50.0]  # deeper is lower
    assert columns[:, 1] == pytest.approx([-60.0, math.nan, -60.0], nan_ok=True)


def test_right_and_rise_are_up_on_the_chart_of_surfaces() -> None:
    boat = make_boat("bb2")
    toward = boat.toward
    chart = next(chart for chart in charts_of(boat) if chart.name == "surfaces")
    block = block_of(
        1,
        delta_r=toward["rudder"] * math.radians(10.0),
        delta_s=toward["stern"] * math.radians(5.0),
        ordered_s=toward["stern"] * math.radians(7.0),
        command_s=toward["stern"] * math.radians(6.0),
        stern_by_hand=1.0,
    )

    shown = dict(zip(chart.labels, chart.columns(block)[0].tolist(), strict=True))

    assert shown["rudder"] == pytest.approx(10.0)
    assert shown["stern"] == pytest.approx(5.0)
    assert shown["stern ordered"] == pytest.approx(7.0)


def test_tanks_and_banks_are_shown_by_how_full_they_are() -> None:
    boat = make_boat("bb2")
    charts = {chart.name: chart for chart in charts_of(boat)}
    half = 0.5 * float(boat.vessel.capacity[0])
    block = block_of(1, water_forward=half, bank_main=boat.vessel.bank_full[0], flood_aft=2000.0)

    def shown(name: str, label: str) -> float:
        columns = dict(zip(charts[name].labels, charts[name].columns(block)[0], strict=True))
        return float(columns[label])

    assert shown("ballast", "forward") == pytest.approx(50.0)
    assert shown("air", "main") == pytest.approx(100.0)
    assert shown("flooding", "aft") == pytest.approx(2.0)


def test_a_boat_without_tanks_has_no_charts_or_lanes_of_them() -> None:
    boat = make_boat("remus100")

    assert {"ballast", "air"}.isdisjoint(chart.name for chart in charts_of(boat))
    assert {"lanes/blow", "lanes/hover"}.isdisjoint(lane.path for lane in lanes_of(boat))


def test_no_two_charts_or_lines_of_a_chart_have_one_name() -> None:
    charts = charts_of(make_boat("bb2"))

    assert len({chart.path for chart in charts}) == len(charts)
    assert all(len(set(chart.labels)) == len(chart.labels) for chart in charts)


def test_lanes_say_in_words_what_is_so() -> None:
    block = block_of(
        1, rudder_by_hand=1.0, blow_forward=1.0, blow_aft=2.0, vent_mid=1.0, held_depth=1.0
    )

    lanes = {lane.path: lane for lane in lanes_of(make_boat("bb2"))}
    words = {path: lane.word(int(lane.codes(block)[0])) for path, lane in lanes.items()}

    assert words["lanes/rudder"] == "hand"
    assert words["lanes/stern"] == "auto"
    assert words["lanes/blow"] == "forward, aft (emergency)"
    assert words["lanes/vents"] == "mid"
    assert words["lanes/held"] == "depth"
    assert words["lanes/hover"] == ""
    assert words["lanes/run"] == "branch 1"


def test_a_casualty_has_a_lane_wherever_its_slot_is() -> None:
    block = block_of(4)
    block.whole[:, LAYOUT.index("casualty[0]")] = [0, 5, 0, 0]
    block.whole[:, LAYOUT.index("casualty[1]")] = [0, 0, 5, 5]
    block.whole[:, LAYOUT.index("casualty_ticks[1]")] = [0, 0, 3, -3]

    (lane,) = casualty_lanes(block)
    words = [lane.word(code) for code in lane.codes(block).tolist()]

    assert lane.path == "lanes/rudder-stuck"
    assert words == ["", "acting", "acting", "being cleared"]


# The track


def sailed(track: Track, block: Block, pieces: int) -> list[tuple[float, ...]]:
    """Return the track of a block handed over in pieces: start, end, and when each ended."""
    found = []
    for rows in np.array_split(np.arange(len(block.whole)), pieces):
        mask = np.isin(np.arange(len(block.whole)), rows)
        part = Block(
            block.times.at(mask), block.whole[mask], block.branch[mask], block.replaying[mask]
        )
        for times, strips in track.pieces(part):
            ends = strips.reshape(-1, 6).tolist()
            found += [
                (*line, when) for line, when in zip(ends, times.seconds.tolist(), strict=True)
            ]
    return found


def test_the_track_is_one_line_however_it_was_handed_over() -> None:
    block = block_of(60, x=3.0 * np.arange(60), z=50.0)

    whole = sailed(Track(10.0), block, 1)

    assert [line[0] for line in whole[1:]] == [line[3] for line in whole[:-1]]
    assert whole[0][:3] == (0.0, 0.0, 50.0)
    assert {line[3] - line[0] for line in whole} == {9.0, 12.0}
    for pieces in (3, 30):
        again = sailed(Track(10.0), block, pieces)
        assert again[0][:3] == whole[0][:3]
        assert [line[0] for line in again[1:]] == [line[3] for line in again[:-1]]
        assert abs(again[-1][3] - whole[-1][3]) < 10.0


def test_no_line_leads_back_to_where_the_run_was_wound_back_to() -> None:
    block = block_of(40, x=10.0 * np.tile(np.arange(20), 2))
    block.times.ticks[20:] -= 20
    other = block_of(4, x=[0.0, 10.0, 500.0, 510.0])
    other.branch[2:] = 2

    lines = sailed(Track(10.0), block, 1) + sailed(Track(10.0), other, 1)

    assert max(abs(line[3] - line[0]) for line in lines) < 21.0


# From the tick to the batch


def test_a_change_is_found_across_batches_of_one_row() -> None:
    changes = Changes()

    found = [changes.of("x", np.array([value])).tolist() for value in (1.0, 1.0, 2.0, 2.0)]

    assert found == [[True], [False], [True], [False]]
    assert changes.of("x", np.array([2.0, 3.0, 3.0])).tolist() == [False, True, False]


def test_the_work_of_a_tick_is_entered_at_that_tick() -> None:
    gathering = BatchCollector(0.5)

    batches = [gathering.batch([taken(0, 0), taken(1)]), gathering.batch([taken(2), taken(2, 2)])]

    worked = [
        (tick, seconds, us)
        for batch in batches
        for tick, seconds, (us, _) in zip(
            *batch.worked.times, ledger_columns(batch.worked), strict=True
        )
    ]
    assert worked == [(1, 0.5, 1.0), (2, 1.0, 2.0)]
    assert [batch.block.times.ticks.tolist() for batch in batches] == [[0, 1], [2]]


def test_time_in_the_viewer_goes_on_when_the_run_is_wound_back() -> None:
    again = Pace(branch=2)
    news = TakenNews(1, "moment", "wound back")

    batch = BatchCollector(0.5).batch(
        [taken(1), taken(2), taken(1, pace=again), news, taken(2, pace=again)]
    )

    assert batch.block.times.ticks.tolist() == [1, 2, 1, 2]
    assert batch.block.times.seconds.tolist() == [0.5, 1.0, 1.5, 2.0]
    assert batch.told.times.seconds.tolist() == [1.5]
    assert batch.told.texts == ("wound back",)


def test_ticks_that_were_lost_leave_their_time() -> None:
    batch = BatchCollector(0.5).batch([taken(1), taken(5)])

    assert batch.block.times.seconds.tolist() == [0.5, 2.5]


def test_states_of_another_version_are_read_by_name() -> None:
    layout = ("z", "gone", "u")

    whole = states([np.array([60.0, 1.0, 5.0]).tobytes()], layout)

    assert whole[0, LAYOUT.index("z")] == 60.0
    assert whole[0, LAYOUT.index("u")] == 5.0
    assert whole.sum() == 65.0


# Feeds


class Bucket:
    """A sink that takes what it may."""

    name, period, patience, needed = "bucket", 0.01, PATIENCE, True

    def __init__(self, *, leaks: str = "") -> None:
        self.ticks: list[int] = []
        self.open_, self.closed = threading.Event(), False
        self.open_.set()
        self._leaks = leaks

    def open(self) -> None:
        pass

    def write(self, batch: Batch) -> None:
        self.open_.wait(PATIENCE)
        if self._leaks:
            raise OSError(self._leaks)
        self.ticks += batch.block.times.ticks.tolist()

    def close(self) -> None:
        self.closed = True


def test_a_feed_carries_every_tick_in_order_and_closes_its_sink() -> None:
    bucket = Bucket()
    feed = Feed(bucket, 0.5)
    for tick in range(3 * CHUNK_STATES):
        feed.hand(taken(tick, pace=HURRIED))
    feed.close()

    assert bucket.ticks == list(range(3 * CHUNK_STATES))
    assert bucket.closed
    assert feed.trouble == ""


def fill(feed: Feed, pace: Pace, count: int) -> None:
    """Hand over so many ticks; they share one state, so that a test needs no memory."""
    state = state_of(1)
    for tick in range(count):
        feed.hand(TakenPicture(tick, state, pace, 0, 0, 0))


def test_where_time_is_kept_a_hung_sink_costs_ticks_their_picture_and_no_time(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(feeds, "MAX_TICK_WAIT_S", 10.0 * PATIENCE)  # no tick may wait for room
    bucket = Bucket()
    bucket.open_.clear()
    feed = Feed(bucket, 0.5)

    ticks = threading.Thread(
        target=fill, args=(feed, RUNNING, MAX_WAITING_STATES + 2 * CHUNK_STATES), daemon=True
    )
    ticks.start()
    ticks.join(0.5 * PATIENCE)
    waited = ticks.is_alive()
    bucket.open_.set()
    feed.close()

    assert not waited
    assert 0 < feed.lost <= 2 * CHUNK_STATES
    assert len(bucket.ticks) + feed.lost == MAX_WAITING_STATES + 2 * CHUNK_STATES
    assert f"{feed.lost} ticks are missing" in feed.trouble


def test_at_full_speed_the_tick_waits_for_room_and_nothing_is_lost() -> None:
    bucket = Bucket()
    bucket.open_.clear()
    feed = Feed(bucket, 0.5)
    threading.Timer(0.2, bucket.open_.set).start()

    fill(feed, HURRIED, MAX_WAITING_STATES + 2 * CHUNK_STATES)
    feed.close()

    assert feed.lost == 0
    assert len(bucket.ticks) == MAX_WAITING_STATES + 2 * CHUNK_STATES


@pytest.mark.parametrize("pace", [RUNNING, HURRIED])
def test_a_sink_that_fails_is_told_in_one_line_and_the_run_goes_on(pace: Pace) -> None:
    feed = Feed(Bucket(leaks="no space\nleft at all"), 0.5)

    fill(feed, pace, MAX_WAITING_STATES + CHUNK_STATES)
    feed.close()

    assert feed.trouble == "bucket: no space; nothing more goes there"


def test_a_feed_that_hangs_at_the_end_is_left_behind() -> None:
    bucket = Bucket()
    bucket.open_.clear()
    bucket.patience = 0.05
    feed = Feed(bucket, 0.5)
    feed.hand(taken(1))

    feed.close()

    assert "its end is missing" in feed.trouble
    bucket.open_.set()


def log_to(boat: Boat, *sinks: Bucket) -> Log:
    """Return a log before a publisher that sends promptly."""
    ledger = Ledger(0.5)
    publisher = PromptSender(Roster(StateReader(boat, ledger.summary)))
    return Log(publisher, ledger, [Feed(sink, 0.5) for sink in sinks])


def test_one_sink_that_fails_leaves_the_other_its_ticks(capsys: pytest.CaptureFixture[str]) -> None:
    good, bad = Bucket(), Bucket(leaks="gone")
    log = log_to(make_boat("bb2"), bad, good)
    for tick in range(100):
        log.offer(tick, state_of(tick), RUNNING)
    log.hear(News(99, 49.5, "mark", "here"))
    log.close(1.0)

    assert good.ticks == list(range(100))
    assert list(log.troubles) == ["bucket: gone; nothing more goes there"]
    assert len(log.troubles) == 1  # told once
    assert log.account() == 1
    assert capsys.readouterr().err == "trainer: bucket: gone; nothing more goes there\n"


# What the command line asks for


@pytest.fixture
def subject() -> Subject:
    return Subject(make_boat("bb2"), ExerciseLimits(), "a drill")


def asked(subject: Subject, **options: Any) -> Log | None:
    ledger = Ledger(0.5)
    publisher = PromptSender(Roster(StateReader(subject.boat, ledger.summary)))
    return open_log(publisher, ledger, subject, RunOptions(**options))


def test_a_viewer_without_its_library_is_one_line_and_the_run_goes_on(
    subject: Subject, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("trainer.session.rerun.request.find_spec", lambda _: None)

    assert asked(subject, rerun=True) is None
    assert capsys.readouterr().err == f"trainer: {advise_install('rerun', '--rerun')}\n"


@pytest.mark.parametrize(
    ("text", "place"),
    [
        ("", ("127.0.0.1", VIEWER_PORT)),
        ("debrief-room", ("debrief-room", VIEWER_PORT)),
        (":9999", ("127.0.0.1", 9999)),
        ("[::1]:9999", ("::1", 9999)),
    ],
)
def test_a_viewer_is_at_its_customary_place_unless_told_otherwise(
    text: str, place: tuple[str, int]
) -> None:
    assert parse_address(text) == place


@pytest.mark.parametrize("text", ["room:door", "room:", "room:0", "room:70000"])
def test_a_place_that_is_none_is_refused_with_an_example(text: str) -> None:
    with pytest.raises(ConfigError, match=r"say HOST:PORT, such as 127\.0\.0\.1:9876"):
        parse_address(text)
