"""What the boat's AIS receiver hears of ships near: how often, how far, and with the mast out."""

import math
import re
from collections import Counter
from collections.abc import Callable
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from helpers.orders import read_order
from helpers.sessions import start_plan

from trainer.boat.helm import obey_order
from trainer.boat.world.contacts import contacts_in
from trainer.config.boat.vessel import load_vessel
from trainer.io.chart import DEFAULT_CHART
from trainer.io.orders.grammar import Order, parse
from trainer.session.nmea.sentences import InstrumentSet, choose_instruments
from trainer.session.nmea.transponders import (
    RADIO_RANGE_FACTOR,
    Transponders,
    antenna,
    report_interval,
)
from trainer.session.past.options import RunOptions
from trainer.session.past.plan import plan_run
from trainer.session.stations.view import Frame, Pace, Picture, StateReader
from trainer.session.time.ledger import Ledger

START = datetime(2026, 1, 1, 12, tzinfo=UTC)
HEAD = 'schema = "exercise/1"\nname = "Ships"\nbriefing = "Ships."\nduration_s = 900\n'
TRAFFIC = """
[[contact]]
name = "big"
type = "tanker"
mmsi = 211000001
points = [[5000, 0]]
course_deg = 90
speed_kn = 12
[[contact]]
name = "sloop"
type = "yacht"
mmsi = 211000002
points = [[2000, 3000]]
speed_kn = 5
[[contact]]
name = "rider"
type = "cargo"
mmsi = 211000003
points = [[-3000, 0]]
[[contact]]
name = "silent"
type = "tug"
points = [[0, 2000]]
speed_kn = 5
"""


class Sailed:
    """A boat among ships, seen at a tick of its own. ``scope``: it has BB2's periscope."""

    def __init__(
        self, folder: Path, depth: float, tables: str = TRAFFIC, *, scope: bool = False
    ) -> None:
        path, vessel = folder / "ships.toml", folder / "boat.toml"
        path.write_text(f"{HEAD}[initial]\nspeed_kn = 4\ndepth_m = {depth}\n{tables}")
        text = load_vessel("bb2").text
        vessel.write_text(text if scope else re.sub(r"(?s)\[scope\].*?\n\n", "", text))
        plan = plan_run(RunOptions(exercise=str(path), vessel=str(vessel)))
        self.boat = start_plan(plan)
        self.reader = StateReader(self.boat, Ledger(plan.method.step).summary)

    def frame(self, tick: int = 0) -> Frame:
        """Return the frame of a tick, the boat where it is."""
        self.boat.state.tick = tick
        return self.reader.frame(Picture(tick, self.boat.records.state.tobytes(), Pace()))

    def heard(self, seconds: float, every: float = 1.0) -> list[str]:
        """Return all that is heard from the start on, in frames so far apart."""
        receiver, told = Transponders(DEFAULT_CHART, START), []
        step = self.boat.method.step
        for i in range(round(seconds / every) + 1):
            told += receiver.lines(self.frame(round(i * every / step)))
        return told


Sail = Callable[..., Sailed]


@pytest.fixture
def sail(tmp_path: Path) -> Sail:
    return partial(Sailed, tmp_path)


def read(lines: list[str]) -> list[dict[str, Any]]:
    """Return the messages as pyais reads them."""
    pyais = pytest.importorskip("pyais")
    found, parts = [], []
    for line in lines:
        parts.append(line)
        if line.split(",")[1] == line.split(",")[2]:
            found.append(pyais.decode(*parts).asdict())
            parts = []
    return found


def test_both_parts_of_a_small_ship_s_name_come_on_one_channel_and_not_always_the_same(
    sail: Sail,
) -> None:
    lines = sail(17.5).heard(3600.0, every=10.0)
    single = [line for line in lines if line.split(",")[1] == "1"]
    channels = [line.split(",")[4] for line in single if read([line])[0]["msg_type"] == 24]
    assert len(channels) == 20
    assert channels[::2] == channels[1::2]
    assert set(channels) == {"A", "B"}


def test_each_ship_reports_as_often_as_the_standard_has_it(sail: Sail) -> None:
    told = Counter((each["mmsi"], each["msg_type"]) for each in read(sail(17.5).heard(720.0)))
    assert told == {
        (211000001, 1): 72,  # 12 kn: each 10 s
        (211000001, 5): 2,
        (211000002, 18): 24,  # class B: each 30 s
        (211000002, 24): 4,  # both parts
        (211000003, 1): 4,  # at anchor: each 180 s
        (211000003, 5): 2,
    }


def test_what_is_told_is_where_the_ship_is(sail: Sail) -> None:
    found = [each for each in read(sail(17.5).heard(60.0)) if each["mmsi"] == 211000001]
    last = found[-1]
    speed = 12.0 * 1852.0 / 3600.0
    places = [DEFAULT_CHART.position(5000.0, speed * seconds) for seconds in range(61)]
    assert any(
        math.isclose(last["lon"], longitude, abs_tol=2e-6)
        and math.isclose(last["lat"], latitude, abs_tol=2e-6)
        and last["second"] == seconds % 60
        for seconds, (latitude, longitude) in enumerate(places)
    )
    assert (last["speed"], last["course"], last["heading"]) == (12.0, 90.0, 90)


def test_a_turning_ship_reports_three_times_as_often(sail: Sail) -> None:
    sailed = sail(17.5)
    contacts = contacts_in(sailed.boat)
    order = parse("contact big course 270")
    assert contacts is not None
    assert isinstance(order, Order)
    straight = report_interval(contacts.seen(0)[0])
    obey_order(sailed.boat, order)
    assert report_interval(contacts.seen(20)[0]) == pytest.approx(straight / 3.0)


@pytest.mark.parametrize(("depth", "heard"), [(17.5, True), (20.0, False), (60.0, False)])
def test_nothing_is_heard_without_a_mast_out_of_the_water(
    sail: Sail, depth: float, *, heard: bool
) -> None:
    sailed = sail(depth)
    assert (antenna(sailed.frame()) > 0.0) == heard
    assert bool(sailed.heard(120.0)) == heard


@pytest.mark.parametrize(
    ("depth", "words", "heard"),
    [(17.5, "raise", True), (17.5, "", False), (19.7, "raise", False), (19.2, "raise", True)],
)
def test_with_a_periscope_what_is_heard_is_heard_by_its_head(
    sail: Sail, depth: float, words: str, *, heard: bool
) -> None:
    """BB2's head is 1.9 m over calm water at 17.5 m with the whole mast out, on an even keel."""
    sailed = sail(depth, scope=True)
    if words:
        order = read_order(f"scope {words}")
        obey_order(sailed.boat, order)
    assert antenna(sailed.frame(200)) == (
        pytest.approx(19.45 - depth, abs=0.1) if words else -math.inf
    )
    assert bool(sailed.heard(120.0)) == heard


def test_a_ship_is_heard_as_far_as_both_antennas_let_it_be(sail: Sail) -> None:
    height = antenna(sail(17.5).frame())
    reach = RADIO_RANGE_FACTOR * (math.sqrt(height) + math.sqrt(40.0))
    for beyond, heard in ((-50.0, True), (50.0, False)):
        one = f"""[[contact]]
name = "far"
type = "tanker"
mmsi = 211000001
points = [[{reach + beyond}, 0]]
"""
        assert bool(sail(17.5, one).heard(400.0)) == heard


def test_nothing_is_sent_again_after_a_jump_back(sail: Sail) -> None:
    sailed = sail(17.5)
    receiver = Transponders(DEFAULT_CHART, START)
    for tick in range(0, 200, 2):
        receiver.lines(sailed.frame(tick))
    assert receiver.lines(sailed.frame(0)) == []
    assert receiver.lines(sailed.frame(0)) == []
    assert any(receiver.lines(sailed.frame(tick)) for tick in range(2, 60, 2))


def test_ais_follows_the_set_of_instruments(sail: Sail) -> None:
    sailed = sail(17.5)
    shown = InstrumentSet(
        choose_instruments(["HDT"]), DEFAULT_CHART, START, Transponders(DEFAULT_CHART, START)
    )
    told = [shown.lines(sailed.frame(tick)) for tick in range(0, 100, 2)]
    assert all(each[0].startswith("$INHDT") for each in told)
    assert any(len(each) > 1 and each[1].startswith("!AIVDM") for each in told)


def test_another_boat_of_the_class_is_heard_while_it_is_up(sail: Sail) -> None:
    sailed = sail(17.5, "")
    for depth, messages in ((4, 12), (30, 0)):
        order = read_order(f"contact boat 2 at 2000 0 depth {depth} course 090 speed 6")
        assert obey_order(sailed.boat, order) == ""
        told = read(sailed.heard(120.0))
        assert len([each for each in told if each["msg_type"] == 1]) == messages
        assert {each["mmsi"] for each in told} <= {200_000_002}
        sailed.boat.state.tick = 0
