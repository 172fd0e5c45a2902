"""Outlets of NMEA 0183: serial lines, UDP, TCP and files, and what real readers make of them."""

import contextlib
import csv
import itertools
import json
import math
import os
import re
import shutil
import socket
import subprocess
import threading
import tty
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from datetime import datetime, timedelta
from pathlib import Path
from typing import Any

import pynmea2
import pytest
from helpers.boats import start_bb2
from helpers.installation import installed, run_program
from helpers.nursery import run_trainer, start_trainer
from helpers.sessions import free_session, prompt_sender
from helpers.waiting import await_that, eventually

from trainer.config.files import ConfigError
from trainer.io import nmea
from trainer.io.chart import DEFAULT_CHART
from trainer.io.line import Outbox
from trainer.io.recording.absence import NoRecording
from trainer.io.recording.recording import Recording
from trainer.session.doors.ports import Ports
from trainer.session.nmea.outlets import SteadySubscription, open_outlets
from trainer.session.nmea.sentences import INSTRUMENTS
from trainer.session.past.options import RunOptions
from trainer.session.stations.subscriptions import PromptSender, Publisher, Roster
from trainer.session.stations.view import Pace, Picture, StateReader
from trainer.session.time.ledger import Ledger
from trainer.units import KNOT

ALONE = [each for each in INSTRUMENTS if not each.asked and not each.ground]  # with no ground

needs_pty = pytest.mark.skipif(not hasattr(os, "openpty"), reason="no pseudo-terminals here")
MANOEUVRES = (
    "5 rudder right 15\n60 course 300\n200 depth 100\n350 bell ahead full\n400 rudder left 8\n"
)


def gpsdecode() -> str:
    """Return the path of gpsd's decoder."""
    return installed("gpsdecode", "gpsd-clients")


def signal_k(folder: Path) -> Path:
    """Return the modules that have Signal K's parser, installed first where that is allowed."""
    modules = Path(os.environ.get("NODE_PATH") or folder / "node_modules")
    parser = "@signalk/nmea0183-signalk"
    if os.environ.get("CI_APT") == "1" and shutil.which("npm") and not (modules / parser).exists():
        with contextlib.suppress(subprocess.TimeoutExpired):  # no network, say
            subprocess.run(
                ["npm", "install", "--prefix", str(folder), parser],
                check=False,
                capture_output=True,
                timeout=120,
            )
        modules = folder / "node_modules"
    if not (modules / parser).exists():
        pytest.skip(f"no Signal K parser: npm install {parser}, name it by NODE_PATH")
    return modules


def options(*urls: str, **others: Any) -> RunOptions:
    return RunOptions(**{"nmea": urls, "nmea_baud": 115200, "nmea_rate": 10.0, **others})


class Deck:
    """A session with outlets, ticked by the test."""

    def __init__(self, stack: contextlib.ExitStack, given: RunOptions) -> None:
        self.boat = start_bb2("modified")
        wake = threading.Event()
        self.publisher = Publisher(Roster(StateReader(self.boat, Ledger(0.5).summary)))
        stack.callback(self.publisher.close, 5.0)
        self.recording = Recording.create(
            None, {"started": "2026-11-20T08:00:00+00:00"}, self.boat.records.state.tobytes()
        )
        stack.callback(self.recording.close)
        self.session = free_session(self.boat, self.recording, self.publisher, wake=wake)
        ports = Ports(wake, self.publisher, self.session.event_log.log, stack, print)
        self.stations = open_outlets(ports, self.recording, given)
        self.session.event_log.stations += self.stations
        for station in self.stations:
            stack.callback(station.close, 0.5)

    def tick(self, count: int = 1) -> None:
        for _ in range(count):
            self.boat.tick()
            self.publisher.offer(
                int(self.boat.state.tick), self.boat.records.state.tobytes(), Pace()
            )

    def hear_orders(self) -> list[tuple[str, str, bool | None]]:
        """Return who has ordered what so far, and whether it was accepted."""
        self.session.attendance.listen()
        return [(order.who, order.text, order.accepted) for order in self.recording.orders(1, 0)]

    @property
    def news(self) -> list[str]:
        return [news.text for news in self.session.event_log.news]


Begin = Callable[..., Deck]


@pytest.fixture
def on_deck() -> Iterator[Begin]:
    with contextlib.ExitStack() as stack:
        yield lambda given: Deck(stack, given)


# A stream of four minutes, at a hundred times the speed, over a terminal line and UDP at once


@dataclass
class Stream:
    """What came of a run, by the way it came, and the states it was of."""

    lines: dict[str, list[str]]
    rows: list[dict[str, float]]
    account: str
    deaf: str  # the line that nobody reads


class Drain(threading.Thread):
    """Read bytes until told to stop."""

    def __init__(self, read: Callable[[], bytes]) -> None:
        super().__init__(daemon=True)
        self.kept: list[bytes] = []
        self._read = read
        self.start()

    def run(self) -> None:
        with contextlib.suppress(OSError):
            while data := self._read():
                self.kept.append(data)


@pytest.fixture(scope="module")
def stream(tmp_path_factory: pytest.TempPathFactory) -> Stream:
    if not hasattr(os, "openpty"):
        pytest.skip("no pseudo-terminals here")
    folder = tmp_path_factory.mktemp("nmea")
    (folder / "orders.txt").write_text(MANOEUVRES, encoding="ascii")
    near, far = os.openpty()
    deaf, deaf_far = os.openpty()
    deaf_name = os.ttyname(deaf_far)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as end:
        end.bind(("127.0.0.1", 0))
        end.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 20)
        drains = {"pty": Drain(lambda: os.read(near, 65536)), "udp": Drain(lambda: end.recv(2048))}
        arguments = [
            *("--headless", "--speed", "100", "--duration", "4m", "--orders", "orders.txt"),
            *("--csv", "out.csv", "--nmea", os.ttyname(far), "--nmea", deaf_name),
            *("--nmea", f"udp://127.0.0.1:{end.getsockname()[1]}"),
            *("--nmea-rate", "25", "--nmea-baud", "921600"),
        ]
        done = run_trainer("run", *arguments, cwd=folder, timeout=120)
        assert done.returncode == 0, done.stderr
        end.sendto(b"", end.getsockname())  # an empty datagram, after all others, ends the reading
        drains["udp"].join(60.0)
    os.close(far)
    drains["pty"].join(60.0)
    for descriptor in (near, deaf, deaf_far):
        os.close(descriptor)
    with (folder / "out.csv").open(encoding="ascii") as file:
        rows = [{name: float(text) for name, text in row.items()} for row in csv.DictReader(file)]
    lines = {
        way: b"".join(drain.kept).decode("ascii").split("\r\n")[:-1]
        for way, drain in drains.items()
    }
    return Stream(lines, rows, done.stdout + done.stderr, deaf_name)


def sets(lines: Iterable[str]) -> Iterator[list[str]]:
    """Yield the sentences of each set."""
    one: list[str] = []
    for line in lines:
        if line.startswith("$INRMC") and one:
            yield one
            one = []
        one.append(line)
    yield one


def by_tick(lines: Iterable[str]) -> dict[int, dict[str, Any]]:
    """Return each set as pynmea2 reads it, by tick and by sentence."""
    found = {}
    for one in sets(lines):
        read = [pynmea2.parse(line, check=True) for line in one]
        named = {each.identifier().strip(","): each for each in reversed(read)}
        own = next(each.data for each in read if each.identifier() == "PXSC")
        found[int(own[2])] = named
    return found


class ROR(pynmea2.TalkerSentence):  # type: ignore[misc]
    """Rudder order, which pynmea2 does not know; to be there is enough for it to be read."""

    fields = (("Starboard rudder order", "order", float), ("Status", "status"))


class ETL(pynmea2.TalkerSentence):  # type: ignore[misc]
    """Engine telegraph, which pynmea2 does not know either."""

    fields = (("Time", "timestamp"), ("Kind", "kind"), ("Position", "position"))


def off(angle: float, degrees: float) -> float:
    """Return how far apart two directions [deg] are."""
    return abs(math.remainder(angle - degrees, 360.0))


def place_of(row: dict[str, float]) -> tuple[float, float]:
    return DEFAULT_CHART.position(row["x"], row["y"])


@pytest.mark.process
@pytest.mark.slow
@pytest.mark.parametrize("way", ["pty", "udp"])
def test_pynmea2_reads_every_sentence_of_a_stream_and_it_is_the_state(
    stream: Stream, way: str
) -> None:
    found = by_tick(stream.lines[way])
    assert len(found) > 24
    assert max(found) - min(found) > 400
    for tick, said in found.items():
        row = stream.rows[tick]
        latitude, longitude = place_of(row)
        assert said["INRMC"].latitude == pytest.approx(latitude, abs=1.1e-7)
        assert said["INRMC"].longitude == pytest.approx(longitude, abs=1.1e-7)
        assert off(float(said["INHDT"].heading), math.degrees(row["psi"])) < 0.0051
        assert float(said["INGGA"].altitude) == pytest.approx(-row["z"], abs=0.0051)
        assert float(said["INVHW"].water_speed_knots) == pytest.approx(row["u"] / KNOT, abs=0.0051)
        assert said["PASH"].pitch == pytest.approx(math.degrees(row["theta"]), abs=0.0051)
        assert said["PASH"].roll == pytest.approx(math.degrees(row["phi"]), abs=0.0051)


@pytest.mark.process
@pytest.mark.long
@pytest.mark.parametrize("way", ["pty", "udp"])
def test_no_set_is_cut_short_by_a_reader_that_keeps_up(stream: Stream, way: str) -> None:
    addresses = [each.address for each in ALONE]
    for one in sets(stream.lines[way]):
        assert [line[1:].split(",")[0] for line in one] == addresses
    assert all(
        isinstance(nmea.parse_sentence(line), nmea.NmeaSentence) for line in stream.lines[way]
    )


@pytest.mark.process
@pytest.mark.long
def test_a_line_that_nobody_reads_loses_its_own_sentences_only(stream: Stream) -> None:
    lost = re.search(rf"trainer: .*nmea {re.escape(stream.deaf)}: (\d+) lines", stream.account)
    assert lost
    assert int(lost[1]) > 400
    assert "simulated   240.0 s in 480 ticks" in stream.account
    assert len(stream.rows) == 481


@dataclass
class Kept:
    """A ten-minute file, kept at full speed, and the states it was of."""

    path: Path
    rows: list[dict[str, float]]


@pytest.fixture(scope="module")
def kept(tmp_path_factory: pytest.TempPathFactory) -> Kept:
    folder = tmp_path_factory.mktemp("kept")
    (folder / "orders.txt").write_text(MANOEUVRES, encoding="ascii")
    arguments = ["--headless", "--speed", "max", "--duration", "10m", "--orders", "orders.txt"]
    arguments += ["--csv", "out.csv", "--nmea-record", "drill.nmea"]
    done = run_trainer("run", *arguments, cwd=folder, timeout=120)
    assert done.returncode == 0, done.stderr
    with (folder / "out.csv").open(encoding="ascii") as file:
        rows = [{name: float(text) for name, text in row.items()} for row in csv.DictReader(file)]
    return Kept(folder / "drill.nmea", rows)


@pytest.mark.process
def test_a_file_has_every_tick_of_a_run_at_full_speed(kept: Kept) -> None:
    lines = kept.path.read_bytes().decode("ascii").split("\r\n")
    assert lines.pop() == ""
    assert sorted(by_tick(lines)) == list(range(1201))


@pytest.mark.process
def test_gpsd_rejects_nothing_and_reports_every_tick_as_it_was(kept: Kept) -> None:
    done = run_program(
        [gpsdecode(), "-D", "1", "-j"], input=kept.path.read_bytes().decode("ascii"), timeout=60
    )
    said = done.stdout + done.stderr
    assert "WARN" not in said
    assert "ERR" not in said
    reports = [json.loads(line) for line in said.splitlines() if line.startswith("{")]
    attitudes = [report for report in reports if report["class"] == "ATT"]
    fixes = [report for report in reports if report["class"] == "TPV" and "lat" in report]
    assert not [report for report in reports if "depth" in report]  # no echo, no depth of water
    assert len(attitudes) == len(kept.rows) == len(fixes) + 1  # the first set shows where sets end
    for report, attitude, row in zip(fixes, attitudes[1:], kept.rows[1:], strict=True):
        latitude, longitude = place_of(row)
        assert (report["mode"], report["status"]) == (3, 5)  # dead reckoning
        assert report["lat"] == pytest.approx(latitude, abs=1.1e-7)
        assert report["lon"] == pytest.approx(longitude, abs=1.1e-7)
        assert report["altMSL"] == pytest.approx(-row["z"], abs=0.0051)
        assert off(attitude["heading"], math.degrees(row["psi"])) < 0.0051
        assert attitude["pitch"] == pytest.approx(math.degrees(row["theta"]), abs=0.0051)
        assert attitude["roll"] == pytest.approx(math.degrees(row["phi"]), abs=0.0051)


def free_port() -> int:
    with socket.socket() as end:
        end.bind(("127.0.0.1", 0))
        return int(end.getsockname()[1])


def watched(port: int) -> Iterator[dict[str, Any]]:
    """Yield what the gpsd at a port reports, once it listens there."""
    ends: list[socket.socket] = []

    def reached() -> bool:
        with contextlib.suppress(OSError):
            ends.append(dialled(port))
        return bool(ends)

    assert eventually(reached)
    with ends[0] as end, end.makefile("rw", encoding="ascii") as text:
        text.write('?WATCH={"enable":true,"json":true};\n')
        text.flush()
        yield from map(json.loads, text)


@pytest.mark.process
@needs_pty
def test_a_living_gpsd_reports_the_boat_from_a_terminal_line_and_from_udp(on_deck: Begin) -> None:
    gpsd = installed("gpsd", "gpsd")
    near, far = os.openpty()
    gps_near, gps_far = os.openpty()
    tty.setraw(gps_far)
    Path(os.ttyname(gps_far)).chmod(0o666)  # gpsd gives up its rights before it opens it

    def pass_on() -> bytes:
        data = os.read(near, 4096)
        os.write(gps_near, data)
        return data

    relay = Drain(pass_on)
    udp, port = f"udp://127.0.0.1:{free_port()}", free_port()
    deck = on_deck(options(os.ttyname(far), udp))
    state = deck.boat.state
    state.psi = state.ordered_psi = state.psi_reference = 1.0  # and so it stays, however long
    arguments = ["-N", "-n", "-b", "-S", str(port), udp, os.ttyname(gps_far)]
    with subprocess.Popen([gpsd, *arguments], stderr=subprocess.DEVNULL) as daemon:
        ticking = threading.Event()
        threading.Thread(target=tick_until, args=(deck, ticking), daemon=True).start()
        try:
            line = os.ttyname(gps_far)
            wanted = {("TPV", line), ("ATT", line), ("ATT", udp)}
            for report in itertools.islice(watched(port), 4000):
                kind, way = report["class"], report.get("device")
                if kind == "TPV" and "lat" in report:
                    assert report.get("altMSL", -60.0) == pytest.approx(-60.0, abs=1.0)
                    assert "depth" not in report
                    assert report["lat"] == pytest.approx(25.0, abs=0.01)
                    wanted.discard((kind, way))
                elif kind == "ATT":
                    assert off(report["heading"], math.degrees(1.0)) < 1.0
                    wanted.discard((kind, way))
                if not wanted:
                    break
        finally:
            ticking.set()
            daemon.terminate()
    assert not wanted
    for descriptor in (far, near, gps_near, gps_far):
        os.close(descriptor)
    assert relay.kept


@pytest.mark.process
@pytest.mark.clock
def test_gpsd_shows_how_the_boat_of_a_run_goes_by_tcp_and_by_udp(tmp_path: Path) -> None:
    gpsd = installed("gpsd", "gpsd")
    tcp, udp, port = (
        f"tcp://127.0.0.1:{free_port()}",
        f"udp://127.0.0.1:{free_port()}",
        free_port(),
    )
    words = ("run", "--headless", "--speed", "5", "--duration", "1000", "--no-record")
    run = start_trainer(*words, "--nmea", tcp, "--nmea", udp, cwd=tmp_path)
    fixes: dict[str, list[tuple[float, float]]] = {tcp: [], udp: []}
    pitches = dict.fromkeys(fixes, 0)
    try:
        await_that(lambda: _listens(tcp))
        with subprocess.Popen([gpsd, "-N", "-n", "-S", str(port), udp, tcp]) as daemon:
            for report in itertools.islice(watched(port), 120):
                way = report.get("device", "")
                if report["class"] == "TPV" and "lat" in report:
                    if (found := (report["lat"], report["lon"])) not in fixes[way]:
                        fixes[way].append(found)
                elif report["class"] == "ATT":
                    pitches[way] += "pitch" in report
                if min(*map(len, fixes.values()), *pitches.values()) >= 10:
                    break
            daemon.terminate()
    finally:
        run.terminate()
        run.wait()
    for north in ([lat for lat, _ in found] for found in fixes.values()):
        assert north == sorted(north)  # it goes north, and each fix is where it was later
        assert len(north) >= 10
    assert min(pitches.values()) >= 10


def _listens(url: str) -> bool:
    with contextlib.suppress(OSError), dialled(int(url.rpartition(":")[2])):
        return True
    return False


def tick_until(deck: Deck, over: threading.Event) -> None:
    while not over.wait(0.1):
        deck.tick()


PARSER = """
const Parser = require('@signalk/nmea0183-signalk');
const parser = new Parser();
const input = require('readline').createInterface({input: process.stdin});
input.on('line', (line) => {
  let values = null;
  try {
    const delta = parser.parse(line);
    values = delta && delta.updates.flatMap((update) => update.values);
  } catch (error) { values = String(error); }
  console.log(JSON.stringify(values));
});
"""


@pytest.mark.process
def test_signal_k_takes_every_sentence(kept: Kept, tmp_path: Path) -> None:
    modules = signal_k(tmp_path)
    (tmp_path / "parse.js").write_text(PARSER, encoding="ascii")
    lines = kept.path.read_text(encoding="ascii").splitlines()
    done = run_program(
        ["node", str(tmp_path / "parse.js")],
        env=os.environ | {"NODE_PATH": str(modules)},
        input="\n".join(lines),
        timeout=60,
    )
    answers = [json.loads(line) for line in done.stdout.splitlines()]
    assert len(answers) == len(lines)
    assert not [answer for answer in answers if isinstance(answer, str)]
    step = len(ALONE)
    for tick, row in enumerate(kept.rows):
        values = {
            value["path"]: value["value"]
            for answer in answers[tick * step : (tick + 1) * step]
            for value in answer or ()
        }
        assert "environment.depth.belowTransducer" not in values  # it is no depth of water
        heading = math.degrees(values["navigation.headingTrue"])
        assert off(heading, math.degrees(row["psi"])) < 0.0051
        assert values["navigation.speedThroughWater"] == pytest.approx(row["u"], abs=0.0027)
        place = values["navigation.position"]
        assert (place["latitude"], place["longitude"]) == pytest.approx(place_of(row), abs=1.1e-7)


# Readers that come, and lines that go


def dialled(port: int) -> socket.socket:
    return socket.create_connection(("127.0.0.1", port), timeout=60.0)


def port_of(err: str) -> int:
    return int(err.rpartition(":")[2])


def test_any_number_of_readers_is_sent_the_same_and_may_come_and_go(
    on_deck: Begin, capfd: pytest.CaptureFixture[str]
) -> None:
    deck = on_deck(options("tcp://127.0.0.1:0", nmea_sentences="PXSC"))
    port = port_of(capfd.readouterr().err)
    with dialled(port) as one, dialled(port) as other:
        assert eventually(lambda: (deck.hear_orders(), len(deck.news))[1] == 2)
        deck.tick()
        first = one.makefile(encoding="ascii").readline()
        assert first.startswith("$PXSC,M,")
        assert other.makefile(encoding="ascii").readline() == first
    assert eventually(lambda: (deck.tick(), deck.hear_orders(), len(deck.news))[2] == 4)  # type: ignore[func-returns-value]
    assert "no longer reads" in deck.news[-1]


def test_a_reader_that_has_ended_its_own_side_still_reads(
    on_deck: Begin, capfd: pytest.CaptureFixture[str]
) -> None:
    deck = on_deck(options("tcp://127.0.0.1:0", nmea_sentences="HDT"))
    with dialled(port_of(capfd.readouterr().err)) as end:
        end.shutdown(socket.SHUT_WR)
        assert eventually(lambda: (deck.hear_orders(), deck.news)[1])
        deck.tick()
        text = end.makefile(encoding="ascii")
        assert text.readline().startswith("$INHDT")
        deck.tick()
        assert text.readline().startswith("$INHDT")


def test_an_autopilot_on_tcp_steers_as_the_helm_and_is_recorded(
    on_deck: Begin, capfd: pytest.CaptureFixture[str]
) -> None:
    deck = on_deck(options("tcp://127.0.0.1:0"))
    with dialled(port_of(capfd.readouterr().err)) as end:
        for line in (
            nmea.sentence("APHSC", "90.0", "T", "", ""),
            nmea.sentence("GPGLL", "1", "2"),
            nmea.sentence("ECETL", "", "O", "05", "", "B", "0"),
            "$APHSC,10.0,T,,*00",
            nmea.sentence("AGROR", "-60", "A", "", "V", "B"),  # beyond the rudder's limit
        ):
            end.sendall(line.encode("ascii") + b"\r\n")
        assert eventually(lambda: len(deck.hear_orders()) == 3)
    who = "helm at nmea tcp://127.0.0.1:0"
    assert deck.hear_orders() == [
        (who, "course 090", True),
        (who, "bell ahead flank", True),
        (who, "rudder left 60", False),
    ]
    assert deck.boat.state.ordered_psi == pytest.approx(math.pi / 2.0)
    station = deck.stations[0]
    assert (station.counts.orders, station.counts.bad) == (3, 1)
    assert any("GPGLL: ignored" in text for text in deck.news)
    assert any("wrong checksum 00" in text for text in deck.news)


@needs_pty
def test_a_panel_on_a_serial_line_steers_and_hears_and_is_not_missed_when_unplugged(
    on_deck: Begin,
) -> None:
    near, far = os.openpty()
    try:
        deck = on_deck(options(os.ttyname(far), nmea_sentences="ROR"))
        os.write(near, nmea.sentence("IIROR", "12.5", "A", "", "V", "B").encode("ascii") + b"\r\n")
        assert eventually(lambda: len(deck.hear_orders()) == 1)
        assert deck.hear_orders()[0][1:] == ("rudder right 12.5", True)
        deck.tick()
        assert os.read(near, 4096) == b"$INROR,12.50,A,,V,B*19\r\n"
    finally:
        os.close(near)
        os.close(far)
    station = deck.stations[0]
    assert eventually(lambda: (deck.tick(), station.line.dropped)[1] > 3)  # type: ignore[func-returns-value]
    assert "sentences" not in station.account()
    assert f"{station.line.dropped} lines lost" in station.account()


def test_a_hung_line_never_holds_up_who_offers_a_tick_and_loses_what_is_too_much() -> None:
    boat, let_go = start_bb2("modified"), threading.Event()
    outbox = Outbox(lambda _data: let_go.wait(60.0), capacity=4)
    promptly = PromptSender(
        Roster(StateReader(boat, Ledger(0.5).summary)), iter(range(1000)).__next__
    )

    class Twice:
        def lines(self, frame: object) -> list[str]:
            return [f"{frame!r:.1}", "second"]

    promptly.add(SteadySubscription(outbox, "nmea", 1.0, Twice()))
    for _ in range(20):
        boat.tick()
        promptly.offer(int(boat.state.tick), boat.records.state.tobytes(), Pace())
    assert outbox.dropped >= 40 - 4 - 4
    let_go.set()
    outbox.close(5.0)
    assert outbox.dropped <= 40


def test_beyond_this_machine_sentences_are_sent_and_none_orders(
    on_deck: Begin, capfd: pytest.CaptureFixture[str]
) -> None:
    deck = on_deck(options("tcp://0.0.0.0:0"))
    told = capfd.readouterr().err
    assert "no orders are taken from beyond this machine" in told
    with dialled(int(told.partition(";")[0].rpartition(":")[2])) as end:
        end.sendall(nmea.sentence("APHSC", "90.0", "T", "", "").encode("ascii") + b"\r\n")
        station = deck.stations[0]
        assert eventually(lambda: (deck.hear_orders(), station.counts.refused)[1] == 1)
    assert deck.hear_orders() == []
    assert deck.boat.state.ordered_psi == 0.0


def test_udp_sends_a_sentence_in_each_datagram(on_deck: Begin) -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as end:
        end.bind(("127.0.0.1", 0))
        end.settimeout(60.0)
        deck = on_deck(options(f"udp://127.0.0.1:{end.getsockname()[1]}", nmea_sentences="HDT,ROT"))
        deck.tick()
        assert [end.recv(2048)[:6] for _ in range(2)] == [b"$INHDT", b"$INROT"]
    assert deck.stations[0].line.ended  # it hears nothing: no reason to wait for it


def test_a_network_that_is_away_is_counted_and_told(
    on_deck: Begin, monkeypatch: pytest.MonkeyPatch
) -> None:
    def away(*_: object) -> int:
        raise OSError(101, "Network is unreachable")

    deck = on_deck(options("udp://127.0.0.1", nmea_sentences="HDT,ROT"))
    monkeypatch.setattr(socket.socket, "sendto", away)
    deck.tick()
    station = deck.stations[0]
    assert eventually(lambda: station.line.dropped == 2)
    assert station.account().endswith("2 lines lost; Network is unreachable")


def picture(tick: int, *, frozen: bool = False) -> Picture:
    return Picture(tick, bytes(8) + bytes([tick]), Pace(frozen))


def test_a_set_is_sent_at_its_rate_and_the_last_again_after_a_second_of_silence() -> None:
    subscription = SteadySubscription(None, "nmea", 4.0, None)  # type: ignore[arg-type]
    assert subscription.wait(picture(1), 10.0) == 0.0
    subscription.seen, subscription.due = picture(1), 10.25
    assert subscription.wait(picture(2), 10.0) == pytest.approx(0.25)
    assert subscription.wait(picture(2, frozen=True), 10.0) == pytest.approx(0.25)
    assert subscription.wait(picture(2), 10.3) == 0.0
    assert subscription.wait(picture(1), 10.3) == pytest.approx(0.7)
    assert subscription.wait(picture(1), 11.0) == 0.0


def test_in_a_freeze_the_last_set_is_due_again_though_nothing_is_offered() -> None:
    boat = start_bb2("modified")
    sent: list[str] = []

    class Reader:
        def send(self, line: str) -> None:
            sent.append(line)

    class Set:
        def lines(self, _frame: object) -> list[str]:
            return ["a set"]

    roster = Roster(StateReader(boat, Ledger(0.5).summary))
    roster.add(SteadySubscription(Reader(), "nmea", 2.0, Set()))
    still = Picture(int(boat.state.tick), boat.records.state.tobytes(), Pace(frozen=True))
    now = 10.0
    for _ in range(3):
        now += roster.serve(still, now)
    assert sent == 3 * ["a set"]
    assert now == pytest.approx(13.0)


def test_time_and_date_go_on_from_when_the_recording_was_begun(
    on_deck: Begin, tmp_path: Path
) -> None:
    path = tmp_path / "drill.nmea"
    deck = on_deck(options(nmea_record=path, nmea_sentences="RMC", nmea_rate=2.0))
    deck.tick()
    assert eventually(lambda: path.stat().st_size > 0)
    said = pynmea2.parse(path.read_text(encoding="ascii").splitlines()[0])
    began = datetime.fromisoformat("2026-11-20T08:00:00+00:00")
    assert datetime.combine(said.datestamp, said.timestamp) == began + timedelta(seconds=0.5)


# What is refused


def quiet_ports(stack: contextlib.ExitStack) -> Ports:
    sending = prompt_sender(start_bb2("modified"))
    return Ports(threading.Event(), sending, lambda _kind, _text: None, stack, print)


def refused(given: RunOptions) -> str:
    with contextlib.ExitStack() as stack, pytest.raises(ConfigError) as wrong:
        open_outlets(quiet_ports(stack), NoRecording(), given)
    return str(wrong.value)


def test_a_set_that_does_not_fit_the_line_is_refused_with_the_figures() -> None:
    said = refused(options("/dev/ttyUSB0", nmea_baud=9600, nmea_rate=2.0))
    assert "bytes a second; the line carries 960 at 9600 baud" in said
    assert "22 sentences of 969 bytes at 2 Hz are 1938 bytes a second" in said
    assert "give --nmea-rate 0.99 or less" in said


def test_the_rate_that_is_advised_fits() -> None:
    said = refused(options("loop://", nmea_baud=4800, nmea_rate=5.0))
    rate = float(said.partition("--nmea-rate ")[2].split()[0])
    with contextlib.ExitStack() as stack:
        given = options("loop://", nmea_baud=4800, nmea_rate=rate)
        stations = open_outlets(quiet_ports(stack), NoRecording(), given)
        for station in stations:
            station.close(1.0)
    assert rate > 0.4


@pytest.mark.parametrize(
    ("given", "reason"),
    [
        (
            options("upd://127.0.0.1"),
            "--nmea upd://127.0.0.1: no such kind of outlet; nearest is udp",
        ),
        (options("udp://"), "--nmea udp://: say HOST or HOST:PORT"),
        (options("udp://127.0.0.1:99999"), "--nmea udp://127.0.0.1:99999: a port is 1 to 65535"),
        (options("udp://nowhere.invalid:1"), "no such host"),
        (options("tcp://127.0.0.1:99999"), "a port is 1 to 65535"),
        (options("/dev/ttyNONE"), "--nmea /dev/ttyNONE: "),
        (options("udp://127.0.0.1", nmea_sentences="RMC,HTD"), "no sentence 'HTD'; nearest is HDT"),
        (options("udp://127.0.0.1", nmea_sentences="XYZW"), "there are RMC,PASHR,"),
        (options("udp://127.0.0.1", origin="25"), "--origin 25: say LAT,LON"),
        (options("udp://127.0.0.1", origin="85,0"), "--origin 85,0: latitude 85 is not within"),
        (options(nmea_record=Path("/nowhere/x")), "--nmea-record /nowhere/x: No such file"),
        (options(nmea_record=Path(__file__)), "is there already; give another name"),
    ],
)
def test_what_cannot_be_opened_says_what_to_do(given: RunOptions, reason: str) -> None:
    assert reason in refused(given)


@pytest.mark.parametrize(
    ("given", "orders"),
    [({"token": ("word",)}, []), ({"token": ("word",), "nmea_orders": True}, ["course"])],
)
def test_where_a_token_is_asked_for_sentences_order_only_if_they_are_to(
    on_deck: Begin, capfd: pytest.CaptureFixture[str], given: Any, orders: list[str]
) -> None:
    deck = on_deck(options("tcp://127.0.0.1:0", **given))
    told = capfd.readouterr().err
    assert ("--nmea-orders" in told) is not bool(orders)
    with dialled(int(told.partition(";")[0].rpartition(":")[2])) as end:
        end.sendall(nmea.sentence("APHSC", "90.0", "T", "", "").encode("ascii") + b"\r\n")
        counts = deck.stations[0].counts
        assert eventually(lambda: (deck.hear_orders(), counts.refused + counts.orders)[1])
    assert [text.partition(" ")[0] for _, text, _ in deck.hear_orders()] == orders
