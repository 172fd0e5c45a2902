"""NMEA 0183: sentences built and read, the set of one tick, and sentences that order."""

import math
import re
import threading
from datetime import UTC, datetime

import pynmea2
import pytest
from geographiclib.geodesic import Geodesic
from helpers.boats import start_boat, take_ticks
from helpers.line import Line
from helpers.orders import obey_all, read_order
from helpers.places import ROOT
from helpers.sessions import frame_of
from hypothesis import given
from hypothesis import strategies as st

from trainer.boat.boat import Boat
from trainer.config.boat.vessel import load_vessel
from trainer.config.files import ConfigError
from trainer.io import nmea
from trainer.io.chart import DEFAULT_CHART, Chart, chart_at
from trainer.io.lines import LineDecoder, OverlongLine
from trainer.io.orders.grammar import parse
from trainer.session.nmea import page as nmea_page
from trainer.session.nmea.orders import (
    REPEAT_PERIOD_S,
    SENTENCE_READERS,
    TELEGRAPH_BELLS,
    Command,
    NmeaLine,
    UnusableSentence,
    meaning,
)
from trainer.session.nmea.outlets import parse_names
from trainer.session.nmea.readings import WIDEST_READINGS
from trainer.session.nmea.sentences import (
    INSTRUMENTS,
    InstrumentSet,
    SampledDisplay,
    choose_instruments,
    widest,
)
from trainer.session.stations.roles import ROLES, refusal
from trainer.units import KNOT

START = datetime(2026, 12, 31, 23, 59, 58, tzinfo=UTC)


def under_way(speed: float = 10.0, course: float = 0.0) -> Boat:
    """Return BB2 at 60 m, everything automatic, at ``speed`` [kn] and ``course`` [deg]."""
    return start_boat(speed * KNOT, 60.0, math.radians(course), equations="modified")


@pytest.fixture
def boat() -> Boat:
    return under_way()


def told(boat: Boat, chart: Chart = DEFAULT_CHART) -> dict[str, tuple[str, ...]]:
    """Return the fields of the set of a boat, by address and, of our own, page."""
    fields = {}
    for line in InstrumentSet(INSTRUMENTS, chart, START).lines(frame_of(boat)):
        heard = nmea.parse_sentence(line)
        assert isinstance(heard, nmea.NmeaSentence)
        name = heard.talker + heard.formatter
        page = heard.fields[0] if name == "PXSC" else ""
        page = "DEPTH" if heard.fields[-1] == "DEPTH" else page
        fields[name + page if page or name not in fields else f"{name}2"] = heard.fields
    return fields


# Sentences


def test_a_sentence_is_framed_as_the_worlds_best_known_example() -> None:
    # the GGA that every description of NMEA 0183 shows, with its checksum 47
    known = "$GPGGA,123519,4807.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,*47"
    heard = nmea.parse_sentence(known)
    assert isinstance(heard, nmea.NmeaSentence)
    assert (heard.talker, heard.formatter) == ("GP", "GGA")
    assert nmea.sentence("GPGGA", *heard.fields) == known


def test_a_sentence_of_80_characters_and_its_line_end_passes_and_one_more_is_refused() -> None:
    assert len(nmea.sentence("INTXT", "x" * 70)) == 80
    with pytest.raises(ValueError, match="81 characters; 80 at most"):
        nmea.sentence("INTXT", "x" * 71)


@pytest.mark.parametrize(
    ("line", "reason"),
    [
        ("$HEHDT,90.0,T", "not framed"),
        ("$HEHDT,90.0,T*00", "wrong checksum 00; this sentence's is 16"),
        ("$HEHD,90.0,T*42", "no talker"),
        ("$HEHDT,90.0\x7f,T*69", "not framed"),
    ],
)
def test_a_damaged_sentence_says_what_is_wrong(line: str, reason: str) -> None:
    heard = nmea.parse_sentence(line)
    assert isinstance(heard, nmea.DamagedSentence)
    assert reason in heard.reason


@given(st.text(max_size=90))
def test_no_line_raises(text: str) -> None:
    for line in (text, f"${text}", f"${text}*00"):
        assert not isinstance(nmea.parse_sentence(line), nmea.NmeaSentence) or "*" in line


@pytest.mark.parametrize(
    ("degrees", "written"),
    [
        (25.0, ("2500.00000", "N")),
        (-0.5, ("0030.00000", "S")),
        (24.9999999999, ("2500.00000", "N")),  # never 60 minutes
        (80.123456789, ("8007.40741", "N")),
    ],
)
def test_a_latitude_is_degrees_and_minutes(degrees: float, written: tuple[str, str]) -> None:
    assert nmea.latitude(degrees) == written


# The set


def test_every_sentence_fits_with_the_widest_values_and_has_the_fields_it_is_said_to_have() -> None:
    for instrument in INSTRUMENTS:
        sent = instrument.sentence(WIDEST_READINGS)
        assert len(sent) <= 80
        assert len(instrument.fields) == sent.count(",")


def test_no_set_of_a_wild_run_is_longer_than_the_widest() -> None:
    boat = under_way(15.0)
    obey_all(boat, "rudder right full", "stern planes dive 25", "bell ahead flank")
    shown = InstrumentSet(INSTRUMENTS, DEFAULT_CHART, START)
    for _ in range(300):
        if boat.tick():
            break
        lines = shown.lines(frame_of(boat))
        assert sum(len(line) + 2 for line in lines) <= widest(INSTRUMENTS)[1]


def test_the_set_tells_of_the_state_in_the_units_of_its_sentences() -> None:
    boat = under_way(course=200.0)
    obey_all(boat, "rudder right 10", "stern planes rise 4", "bell ahead full")
    take_ticks(boat, 60)
    s, fields = boat.state, told(boat)
    assert float(fields["INHDT"][0]) == pytest.approx(math.degrees(s.psi) % 360.0, abs=0.0051)
    assert float(fields["INDPT"][0]) == pytest.approx(s.z, abs=0.0051)
    assert float(fields["INDBT"][2]) == pytest.approx(s.z, abs=0.0051)
    assert float(fields["INDBT"][0]) == pytest.approx(s.z / 0.3048, abs=0.051)
    assert float(fields["INGGA"][8]) == pytest.approx(-s.z, abs=0.0051)
    assert float(fields["INVHW"][4]) == pytest.approx(s.u / KNOT, abs=0.0051)
    assert float(fields["INVHW"][6]) == pytest.approx(s.u * 3.6, abs=0.0051)
    assert float(fields["PASHR"][3]) == pytest.approx(math.degrees(s.phi), abs=0.0051)
    assert float(fields["INXDR"][1]) == pytest.approx(math.degrees(s.theta), abs=0.0051)
    assert float(fields["INRSA"][0]) == pytest.approx(10.0, abs=0.0051)
    assert float(fields["INXDR2"][1]) == pytest.approx(4.0, abs=0.0051)
    assert fields["INROR"] == ("10.00", "A", "", "V", "B")
    assert fields["INETL"][1:3] == ("O", "04")
    assert fields["PXSCC"][1:3] == ("60", "10.00")


@pytest.mark.parametrize("ticks", [4, 12, 60])
def test_rates_and_velocities_are_of_the_tick_that_is_told(ticks: int) -> None:
    boat = under_way(course=200.0)
    obey_all(boat, "rudder right 20")
    take_ticks(boat, ticks)
    fields = told(boat)
    take_ticks(boat, 1)  # the rates that the next tick begins with are those of the motion told
    s = boat.state
    rate = math.degrees(s.psidot)
    assert float(fields["INROT"][0]) == pytest.approx(60.0 * rate, abs=0.051)
    assert float(fields["PXSCM"][7]) == pytest.approx(rate, abs=0.00051)
    assert float(fields["INRMC"][6]) == pytest.approx(math.hypot(s.xdot, s.ydot) / KNOT, abs=0.0051)
    track = math.degrees(math.atan2(s.ydot, s.xdot)) % 360.0
    assert float(fields["INVTG"][0]) == pytest.approx(track, abs=0.0051)


def test_a_casualty_of_a_gauge_is_seen_and_the_position_stays_true() -> None:
    boat = under_way(course=90.0)
    sound = told(boat)
    obey_all(boat, "casualty depth-gauge-biased 5", "casualty gyro-biased 4")
    take_ticks(boat, 40)
    wrong, s = told(boat), boat.state
    off = float(wrong["INDPT"][0]) - s.z
    assert off > 1.0
    assert float(wrong["INGGA"][8]) == pytest.approx(-s.z - off, abs=0.01)
    assert float(wrong["INHDT"][0]) - math.degrees(s.psi) > 1.0
    assert wrong["PASHR"][1] == wrong["INVHW"][0] == wrong["INHDT"][0]
    position = DEFAULT_CHART.position(s.x, s.y)
    assert wrong["INRMC"][2:4] == nmea.latitude(position[0])
    assert wrong["INRMC"][4:6] == nmea.longitude(position[1])
    assert sound["INHDT"][0] == "90.00"


def test_a_boat_without_planes_has_empty_fields_for_them(boat: Boat) -> None:
    boat.vessel["Z_db"] = 0.0
    fields = told(boat)
    assert fields["INXDR2"][4:] == ("A", "", "D", "BOW")
    assert fields["PXSCC"][6:] == ("", "")


def test_a_boat_at_rest_makes_no_way_and_keeps_her_heading_as_track() -> None:
    boat = under_way(course=45.0)
    boat.state.held_position = 1.0
    assert told(boat)["INRMC"][6:8] == ("0.00", "45.00")


def test_above_the_surface_depth_is_nought_and_altitude_is_not(boat: Boat) -> None:
    boat.state.z = -1.5
    fields = told(boat)
    assert (fields["INDPT"][0], fields["INDBT"][2], fields["INGGA"][8]) == ("0.00", "0.00", "1.50")


def test_the_boat_s_own_depth_is_no_sounding_unless_it_is_asked_for(boat: Boat) -> None:
    def sent(names: str | None) -> dict[str, str]:
        shown = InstrumentSet(choose_instruments(parse_names(names)), DEFAULT_CHART, START)
        return {line[1:6]: line for line in shown.lines(frame_of(boat))}

    usual = sent(None)
    assert not [address for address in usual if address.endswith(("DBT", "DPT"))]
    assert sent("DBT,DPT") == {}
    assert float(told(boat)["INXDRDEPTH"][1]) == pytest.approx(boat.state.z, abs=0.0051)
    assert sent("INDPT,INDBT")["INDPT"].startswith(f"$INDPT,{boat.state.z:.2f},0.0,*")
    with pytest.raises(ConfigError, match="nearest is INDPT"):
        parse_names("IMDPT")


def test_a_file_has_a_set_at_the_rate_of_the_boats_time_and_one_when_time_goes_back(
    boat: Boat,
) -> None:
    sampled = SampledDisplay(InstrumentSet(choose_instruments(["HDT"]), DEFAULT_CHART, START), 1.0)
    start = boat.snapshot()
    counts = []
    for _ in range(5):
        counts.append(len(sampled.lines(frame_of(boat))))
        boat.tick()
    boat.restore(start)
    counts.append(len(sampled.lines(frame_of(boat))))
    assert counts == [1, 0, 1, 0, 1, 1]


# Where on the Earth


@pytest.mark.parametrize("course", [0.0, 63.0, 200.0])
def test_after_an_hour_the_position_lies_at_the_distance_and_bearing_that_were_sailed(
    course: float,
) -> None:
    boat, chart = under_way(18.0, course), Chart(51.0, 179.9)  # she crosses the date line
    take_ticks(boat, 7200)
    run = math.hypot(boat.state.x, boat.state.y)
    assert run > 30_000.0
    bearing = math.degrees(math.atan2(boat.state.y, boat.state.x))
    shown = InstrumentSet(choose_instruments(["RMC"]), chart, START)
    fix = pynmea2.parse(shown.lines(frame_of(boat))[0])
    sailed = Geodesic.WGS84.Inverse(51.0, 179.9, fix.latitude, fix.longitude)
    assert sailed["s12"] == pytest.approx(run, abs=0.05)
    assert math.remainder(sailed["azi1"] - bearing, 360.0) == pytest.approx(0.0, abs=1e-4)


def test_an_origin_is_two_numbers_within_bounds() -> None:
    assert chart_at("-33.5, 18.25") == Chart(-33.5, 18.25)
    for text, reason in (
        ("25", "say LAT,LON"),
        ("25N,45W", "say LAT,LON"),
        ("nan,3", "say LAT,LON"),
        ("81,0", "latitude 81 is not within -80 and 80"),
        ("0,181", "longitude 181"),
    ):
        with pytest.raises(ValueError, match=reason):
            chart_at(text)


# Sentences that order


def heard(address: str, fields: str) -> nmea.NmeaSentence:
    found = nmea.parse_sentence(nmea.sentence(address, *fields.split(",")))
    assert isinstance(found, nmea.NmeaSentence)
    return found


@pytest.mark.parametrize(
    ("address", "fields", "order"),
    [
        ("AGHTC", "V,12.5,L,R,N,,,,,,,,T,C", ("rudder left 12.5", -12.5)),
        ("AGHTC", "V,5.0,R,M,N,,,,,090,,,T", ("rudder right 5", 5.0)),
        ("AGHTC", "A,7,L,H,N,,,,,090,,,T,C", ("rudder left 7", -7.0)),  # override
        ("AGHTC", "V,,,H,R,20,,1.5,,271.5,,,T,C", ("course 271.5", 271.5)),
        ("AGHTC", "V,,,S,N,,,,,5.0,,,T", ("course 005", 5.0)),
        ("APHSC", "90.0,T,,", ("course 090", 90.0)),
        ("APHSC", "360,T,,,C", ("course 000", 0.0)),
        ("AGROR", "-35.0,A,,V,B", ("rudder left 35", -35.0)),
        ("AGROR", "0.0,A,,", ("rudder right 0", 0.0)),
        ("ECETL", "120000.00,O,03,,B,0", ("bell ahead standard", 0.0)),
        ("ECETL", ",O,13", ("bell astern two-thirds", 0.0)),
        ("ECPRC", "50.0,A,85.5,R,,V,B,0", ("rpm 85.5", 85.5 / 60.0)),
        ("ECPRC", ",V,-30,R", ("rpm -30", -0.5)),
    ],
)
def test_a_sentence_orders_what_the_helm_may_order(
    address: str, fields: str, order: tuple[str, float]
) -> None:
    command = meaning(heard(address, fields))
    assert isinstance(command, Command)
    parsed = read_order(command.words)
    assert parsed.text == order[0]
    value = math.degrees(parsed.value) if parsed.name in ("rudder", "course") else parsed.value
    assert value == pytest.approx(order[1])
    assert refusal(ROLES["helm"], parsed) is None
    assert refusal(ROLES["planes"], parsed) is not None


@pytest.mark.parametrize(
    ("address", "fields", "reason"),
    [
        ("AGHTC", "V,12.5,L,R,N,,,,,,,,T,R", "a report"),
        ("AGHTC", "V,12.5,L,R,N", "less than 13 fields"),
        ("AGHTC", "V,12.5,,R,N,,,,,,,,T,C", "without its angle and L or R"),
        ("AGHTC", "V,1e1,L,R,N,,,,,,,,T,C", "without its angle and L or R"),
        ("AGHTC", "V,,,T,N,,,,,,0.1,090,T,C", "other than R, M"),
        ("AGHTC", "V,,,H,N,,,,,090,,,M,C", "magnetic"),
        ("APHSC", ",,90.0,M", "without a heading"),
        ("AGROR", "5.0,V,,V,B", "valid"),
        ("ECETL", "120000,A,03,,B,0", "no order"),
        ("ECETL", "120000,O,06,,B,0", "no position"),
        ("ECPRC", "50,A,70,P,,V,B,0", "revolutions"),
    ],
)
def test_a_sentence_that_orders_nothing_says_why(address: str, fields: str, reason: str) -> None:
    found = meaning(heard(address, fields))
    assert isinstance(found, UnusableSentence)
    assert reason in found.reason


def test_other_sentences_mean_nothing_here() -> None:
    assert meaning(heard("GPRMC", "1,2,3")) is None
    assert meaning(nmea.NmeaSentence("P", "HTC", ("V",) * 14)) is None
    assert set(SENTENCE_READERS) == {"HTC", "HSC", "ROR", "ETL", "PRC"}


@pytest.mark.parametrize("bell", sorted(set(TELEGRAPH_BELLS.values())))
def test_a_bell_rung_is_told_by_the_position_that_orders_it(boat: Boat, bell: str) -> None:
    obey_all(boat, f"bell {bell}")
    assert TELEGRAPH_BELLS[told(boat)["INETL"][2]] == bell


@given(
    st.sampled_from(sorted(SENTENCE_READERS)),
    st.lists(st.text("0123456789.-+ALRMTCHOVS", max_size=5)),
)
def test_no_fields_raise_and_every_command_is_an_order_or_refused(
    formatter: str, fields: list[str]
) -> None:
    found = meaning(nmea.NmeaSentence("AG", formatter, tuple(fields)))
    assert found is not None
    if isinstance(found, Command):
        assert parse(found.words) is not None


# A line of sentences


class Told:
    """A clock that is set, and a log."""

    def __init__(self) -> None:
        self.now = 100.0
        self.log: list[str] = []

    def write(self, _kind: str, text: str) -> None:
        self.log.append(text)


def line_of(*lines: str | OverlongLine) -> tuple[NmeaLine, Line, Told]:
    wire, told_of = Line("nmea wire", list(lines), dropped=3), Told()
    line = NmeaLine(wire, threading.Event(), told_of.write, lambda: told_of.now)
    return line, wire, told_of


LEFT = nmea.sentence("AGROR", "-5.0", "A", "", "V", "B")
HALF = nmea.sentence("ECETL", "", "O", "03", "", "B", "0")
GPS = nmea.sentence("GPGLL", "4916.45", "N", "12311.12", "W", "225444", "A")


def test_a_command_sent_all_the_time_is_one_order_and_is_given_anew_after_a_while() -> None:
    line, wire, told_of = line_of(LEFT, LEFT, HALF, LEFT)
    assert line.take(10) == ["rudder left 5.0", "bell ahead standard"]
    wire.waiting = [LEFT, HALF]
    told_of.now += REPEAT_PERIOD_S - 0.1
    assert line.take(10) == []
    wire.waiting = [nmea.sentence("APHSC", "90", "T", "", ""), LEFT]  # the same control: both
    assert line.take(10) == ["course 90", "rudder left 5.0"]
    wire.waiting = [HALF]
    told_of.now += 0.2
    assert line.take(10) == ["bell ahead standard"]
    assert line.ignored == 0


def test_what_is_no_order_is_counted_and_told_once_for_each_kind() -> None:
    track = nmea.sentence("AGHTC,V,,,T,N,,,,,,0.1,090,T,C")
    line, _, told_of = line_of(GPS, GPS, "chatter", track, track, "", GPS)
    assert line.take(10) == []
    assert line.ignored == 7
    assert [text.split(": ")[1] for text in told_of.log] == [
        "GPGLL",
        "what is no sentence",
        "HTC in a mode other than R, M (rudder) and H, S (heading)",
    ]


def test_the_log_of_ignored_sentences_is_bounded() -> None:
    kinds = [nmea.sentence(f"GPA{i:02d}", "1") for i in range(50)]
    line, _, told_of = line_of(*kinds)
    line.take(50)
    assert (line.ignored, len(told_of.log)) == (50, 16)


@pytest.mark.parametrize(
    "head",
    [
        "\\s:r3669961,c:1120959341*51\\",
        "\\g:1-2-1234,s:r3669961,c:1120959341*79\\",
        "UdPbC\\x00\\s:HE0001,n:12*27\\",  # as a line shows the NUL of IEC 61162-450
        "2026-11-25T12:00:00Z ",
        "$AGROR,-5.",  # half of one that was cut off
        "!",
    ],
)
def test_what_stands_before_a_sentence_is_passed_over(head: str) -> None:
    line, _, told_of = line_of(f"{head}{LEFT}")
    assert line.take(10) == ["rudder left 5.0"]
    assert (line.ignored, told_of.log) == (0, [])
    bad = f"{head}{LEFT.replace('5', '6', 1)}"
    line, _, _ = line_of(bad)
    assert line.take(10) == [bad]


def test_ais_is_known_as_a_sentence_and_orders_nothing() -> None:
    line, _, told_of = line_of("!AIVDM,1,1,,B,177KQJ5000G?tO`K>RA1wUbN0TKH,0*5C")
    assert (line.take(10), line.ignored) == ([], 1)
    assert [text.split(": ")[1] for text in told_of.log] == ["AIVDM"]


def test_the_head_of_a_sentence_fits_the_lines_that_are_heard() -> None:
    block = f"\\{'s:HE0001,n:12,' + 'x' * 62}*00\\"
    decoder = LineDecoder(nmea.MAX_HEADED_LETTERS)
    (heard,) = decoder.feed(f"UdPbC\0{block}{LEFT}\r\n".encode())
    line, _, _ = line_of(heard)
    assert line.take(10) == ["rudder left 5.0"]


def test_a_damaged_line_is_handed_on_to_be_counted_as_bad() -> None:
    bad = LEFT.replace("5", "6", 1)
    line, _, _ = line_of(bad, OverlongLine(82))
    assert line.take(10) == [bad, OverlongLine(82)]
    assert line.ignored == 0


def test_an_echo_of_what_is_sent_here_is_no_order(boat: Boat) -> None:
    obey_all(boat, "rudder left 5", "bell ahead full")
    echo = InstrumentSet(INSTRUMENTS, DEFAULT_CHART, START).lines(frame_of(boat))
    line, _, _ = line_of(*echo)
    assert line.take(50) == []
    assert line.ignored == len(echo)


def test_more_than_is_asked_for_is_taken_later_and_somebody_is_woken_for_it() -> None:
    wire, wake = Line("nmea wire", [GPS, GPS, LEFT]), threading.Event()
    line = NmeaLine(wire, wake, Told().write)
    assert line.take(2) == []
    assert wake.is_set()
    assert line.take(2) == ["rudder left 5.0"]


# The document


def test_the_samples_of_the_document_are_what_is_sent() -> None:
    page = (ROOT / "docs" / "nmea-sentences.md").read_text(encoding="utf-8")
    for line in nmea_page.sample(load_vessel("bb2")):
        assert line in page, "renew: trainer dev instruments --sample"


def test_the_page_for_a_terminal_numbers_every_field() -> None:
    page = nmea_page.page()
    assert len(re.findall(r"^ +\d+  ", page, re.MULTILINE)) == sum(
        len(each.fields) for each in INSTRUMENTS
    )
    assert [each["sentence"] for each in nmea_page.as_json()][:2] == ["$INRMC", "$PASHR"]
