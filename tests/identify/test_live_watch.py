"""A watch of a session hears what its recording would hold, begins anew, and tells once."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from helpers.boat_trials import estimated_boat
from helpers.sessions import prompt_sender

from trainer.boat.assemble import Method
from trainer.boat.boat import Boat
from trainer.config.boat.vessel import VesselFile, load_vessel
from trainer.config.files import ConfigError
from trainer.console.client import MAX_ORDER_LETTERS
from trainer.console.readings import ChannelReadings
from trainer.identify.boat.altered import ALTERED_PARTS
from trainer.identify.boat.live import SHOWN_FIELDS, LiveRecord, LiveVerdict, change_remarks
from trainer.identify.boat.trial import every_tick, lay_out, read_by_instruments
from trainer.identify.boat.vessel import FittedVessel
from trainer.identify.boat.watch import BoatChange, BoatWatch, Moment, WatchedPart
from trainer.identify.record.findings import unwrap_heading
from trainer.identify.record.measurements import Record
from trainer.io.orders.grammar import Order, parse
from trainer.io.orders.sentences import parse_sentence
from trainer.session.stations.channels import CHANNELS
from trainer.session.stations.display import SentenceDisplay
from trainer.session.stations.subscriptions import Subscription
from trainer.session.stations.view import Pace
from trainer.units import DEGREE, KNOT

EXACT_FIELDS = {  # by channel of a record, the name in the state
    "rudder": "delta_r",
    "stern": "delta_s",
    "bow": "delta_b",
    "command_speed": "u_c",
    "speed": "u",
    "heading": "psi",
    "pitch": "theta",
    "roll": "phi",
    "depth": "z",
}
# [SI] what the gauges' decimals take from speed, heading, pitch, roll and depth, and from controls
HALF_DIGITS = np.array([0.05 * KNOT, *[0.05 * DEGREE] * 3, 0.05])
HALF_CONTROLS = np.array([*[0.05 * DEGREE] * 3, 0.02])


class Station:
    """A station's line that a watch hears."""

    def __init__(self, record: LiveRecord) -> None:
        self.record, self.picture, self.told = record, ChannelReadings(), list[str]()

    def send(self, line: str) -> None:
        sentence = parse_sentence(line)
        assert sentence is not None
        if channel := self.picture.take(sentence, 0.0):
            one = self.picture.reading(channel)
            why = self.record.hear(channel, one.tick, one.seconds, one.values)
            self.told += [why] if why else []


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> VesselFile:
    return load_vessel(str(estimated_boat(tmp_path_factory.mktemp("live"))))


def at_sea(file: VesselFile) -> Boat:
    boat = Boat(file, Method("full", "exact", "exact", "adams2", file.run.step_s))
    boat.start(file.run.start_speed_kn * KNOT, 60.0, 6.2)
    boat.state.by_hand[:] = 1.0
    return boat


def show(boat: Boat, record: LiveRecord) -> tuple[Station, Any]:
    """Return a station that sees the boat, and what shows it the present tick."""
    station, sender = Station(record), prompt_sender(boat)
    for channel in SHOWN_FIELDS:
        sender.add(Subscription(station, channel, 0.0, SentenceDisplay(CHANNELS[channel])))
    return station, lambda: sender.offer(boat.ticks, boat.records.state.tobytes(), Pace())


def test_a_watch_hears_the_record_that_a_recording_holds(file: VesselFile) -> None:
    vessel, boat = FittedVessel(file), at_sea(file)
    live = LiveRecord(vessel)
    station, offer = show(boat, live)
    rows = list[list[float]]()
    for tick in range(150 * every_tick(vessel, boat.method.step)):
        swing = 0.2 if tick // 40 % 2 else -0.2
        boat.state.ordered_r, boat.state.ordered_s = swing, 0.4 * swing
        boat.state.ordered_b = -0.3 * swing
        offer()
        rows.append([boat.time, *boat.numbers(tuple(EXACT_FIELDS.values()))])
        assert boat.tick() == 0
    table = np.array(rows)[:: every_tick(vessel, boat.method.step)]
    columns: Any = dict(zip(EXACT_FIELDS, table.T[1:], strict=True))
    exact = Record(
        source="exact",
        t=table[:, 0],
        rows=np.arange(len(table)),
        names={},
        **columns,
    )
    expected = read_by_instruments(lay_out(unwrap_heading(exact), vessel))
    heard = live.trial()
    assert not station.told
    assert heard.interval == expected.interval
    assert heard.readings.shape == expected.readings.shape
    off = np.abs(heard.readings - expected.readings)[:, :5]
    off[:, 1] = np.abs((off[:, 1] + np.pi) % (2.0 * np.pi) - np.pi)
    assert (off.max(axis=0) < 1.01 * HALF_DIGITS).all()
    assert (np.abs(heard.inputs - expected.inputs).max(axis=0) < 1.01 * HALF_CONTROLS).all()
    assert np.ptp(heard.inputs[:, :3], axis=0).min() > 0.05


def told_by(record: LiveRecord, tick: int, seconds: float, **changed: float) -> str:
    """Return what a record says of one tick of readings in the session's units."""
    values = {"depth": 60.0, "heading": 10.0, "speed": 8.0, "pitch": 0.0, "heel": 0.0}
    values |= {"rudder": 5.0, "stern": 0.0, "bow": 0.0, "rpm": 100.0} | changed
    why = ""
    for channel, shown in SHOWN_FIELDS.items():
        texts = {name: f"{values[name]:.1f}" for name in shown}
        why = record.hear(channel, tick, seconds, texts) or why
    return why


def test_a_jump_a_gap_and_the_surface_begin_the_record_anew(file: VesselFile) -> None:
    record = LiveRecord(FittedVessel(file))
    assert [told_by(record, k, 0.2 * k) for k in range(100)] == [""] * 100
    assert told_by(record, 99, 19.8) == "", "a tick that is shown again, time standing still"
    kept = len(record.rows)
    assert told_by(record, 40, 8.0) == "time has gone back"
    assert (len(record.rows), record.number) == (1, 1)
    assert told_by(record, 4000, 800.0) == "nothing was heard for 792 s"
    assert told_by(record, 4001, 800.2, depth=3.0).startswith("less than ")
    assert not record.rows
    assert told_by(record, 4002, 800.4, depth=3.0) == "", "told once"
    assert told_by(record, 4003, 800.6) == ""
    assert told_by(record, 4004, 800.8, speed=-1.0).startswith("slower than 0.3 m/s")
    assert kept > 10


def test_too_short_a_record_and_one_of_still_surfaces_cannot_be_judged(file: VesselFile) -> None:
    record = LiveRecord(FittedVessel(file))
    with pytest.raises(ConfigError, match="0 of 100 readings have come"):
        record.trial()
    for k in range(600):
        told_by(record, k, 0.2 * k)
    with pytest.raises(ConfigError, match="no surface moves by 2 deg"):
        record.trial()


def test_what_is_older_than_the_memory_is_forgotten_and_errors_stay_where_they_were(
    file: VesselFile, monkeypatch: pytest.MonkeyPatch
) -> None:
    vessel = FittedVessel(file)
    whole, short = LiveRecord(vessel), LiveRecord(vessel)
    for k in range(3000):
        for one in (whole, short):
            told_by(one, k, 0.2 * k, rudder=10.0 * np.sin(0.02 * k))
    all_of_it = whole.trial()
    monkeypatch.setattr("trainer.identify.boat.live.MEMORY_WINDOWS", 5)
    last = short.trial()
    assert len(last.readings) < len(all_of_it.readings)
    assert np.array_equal(last.readings[:, 4], all_of_it.readings[-len(last.readings) :, 4])
    assert short.seconds[0] > 0.0


def part(name: str) -> WatchedPart:
    unit = next(one.unit for one in ALTERED_PARTS if one.name == name)
    return WatchedPart(name, unit, -0.2234, 0.03, 8.0, 0.1, "")


def report_of(*names: str, windows: int) -> BoatWatch:
    """Return a verdict ``windows`` after a change was told."""
    moment = Moment("session", 600.0, 600.0)
    change = BoatChange(moment, moment, moment, tuple(map(part, names)))
    t = tuple(600.0 + 60.0 * k for k in range(windows + 1))
    return BoatWatch("boat", "fitted.toml", 4.75, (), change if names else None, (), t, (), ())


def test_a_change_is_told_once_and_again_where_another_part_explains_it() -> None:
    verdict = LiveVerdict()
    assert verdict.news(report_of(windows=0), 0.0) == []
    first = verdict.news(report_of("weight", "trim", windows=0), 120.0)
    assert first == ["weight -22 % since 0:12:00", "or trim: not told apart"]
    assert verdict.news(report_of("weight", windows=2), 120.0) == []
    assert verdict.news(report_of("trim", windows=3), 120.0) == ["trim -0.22 m since 0:12:00"]
    assert verdict.news(report_of("trim", windows=5), 120.0) == []
    assert verdict.news(report_of("weight", windows=6), 120.0) == [], "its part is settled"


def test_every_sentence_fits_into_the_line_of_a_mark() -> None:
    names = [one.name for one in ALTERED_PARTS]
    moment = Moment("session", 360000.0, 0.0)
    for name in names:
        parts = tuple(map(part, (name, *names)))
        for text in change_remarks(BoatChange(moment, moment, moment, parts), 0.0):
            order = parse(f"mark watch: {text}")
            assert isinstance(order, Order)
            assert order.subject == f"watch: {text}"
            assert len(f"mark watch: {text}") <= MAX_ORDER_LETTERS


def test_a_boat_without_bow_planes_is_heard_with_none(file: VesselFile) -> None:
    bare = replace(file, coefficients={**file.coefficients, "Z_db": 0.0, "M_db": 0.0})
    record = LiveRecord(FittedVessel(bare))
    texts = {"stern": "1.0", "bow": ""}
    for channel, shown in SHOWN_FIELDS.items():
        record.hear(channel, 1, 0.2, {name: texts.get(name, "50.0") for name in shown})
    (row,) = record.rows.values()
    assert np.isnan(row["bow"])
    assert abs(row["stern"]) == pytest.approx(DEGREE)
