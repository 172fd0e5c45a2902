"""AIS: known sentences, and what an independent reader takes from ours."""

from typing import Any

import pytest

from trainer.io import ais
from trainer.io.ais import PositionReport, ShipParticulars

SEEN = PositionReport(211000001, 25.0123, -45.0456, 14.2, 271.4, 270.0, -13.0, 13, 0)
KNOWN = "!AIVDM,1,1,,A,139>Jh@sj>Lik30>CvU:V`LJ0000,0*7F"
SHIP = ShipParticulars(211000001, "north star", 80, 150, 50, 16, 16, 11.0, "DABC")


def decode(*lines: str) -> dict[str, Any]:
    """Return the fields as pyais reads them."""
    pyais = pytest.importorskip("pyais")
    found: dict[str, Any] = pyais.decode(*lines).asdict()
    return found


def test_a_known_position_is_the_known_sentence() -> None:
    assert ais.sentences(ais.position_a(SEEN), "A", 0) == [KNOWN]


@pytest.mark.parametrize(
    ("fields", "bits"),
    [
        (ais.position_a(SEEN), 168),
        (ais.position_b(SEEN), 168),
        (ais.static_a(SHIP), 424),
        (ais.static_b(SHIP)[0], 168),
        (ais.static_b(SHIP)[1], 168),
    ],
)
def test_messages_have_the_lengths_of_the_standard(fields: list[ais.Field], bits: int) -> None:
    assert sum(size for _, size in fields) == bits


def test_a_long_message_is_two_sentences_of_one_sequence() -> None:
    first, second = ais.sentences(ais.static_a(SHIP), "B", 7)
    assert first.startswith("!AIVDM,2,1,7,B,5")
    assert second.startswith("!AIVDM,2,2,7,B,")
    assert (first[-5:-3], second[-5:-3]) == (",0", ",2")
    assert max(len(first), len(second)) <= 80


@pytest.mark.parametrize(
    ("turning", "told"), [(0.0, 0), (-7.5, -13), (10.0, 15), (709.0, 126), (-5000.0, -126)]
)
def test_a_rate_of_turn_is_told_by_its_root(turning: float, told: int) -> None:
    assert ais.rate_of_turn(turning) == told


def test_a_position_of_class_a_is_read_by_others() -> None:
    found = decode(KNOWN)
    assert found["msg_type"] == 1
    assert found["mmsi"] == 211000001
    assert (found["speed"], found["course"], found["heading"]) == (14.2, 271.4, 270)
    assert (found["lat"], found["lon"]) == pytest.approx((25.0123, -45.0456), abs=2e-6)
    assert (found["turn"], found["second"]) == (-13.0, 13)


def test_a_position_of_class_b_is_read_by_others() -> None:
    found = decode(*ais.sentences(ais.position_b(SEEN._replace(speed=0.0)), "B", 0))
    assert (found["msg_type"], found["speed"], found["course"]) == (18, 0.0, 271.4)
    assert (found["lat"], found["lon"]) == pytest.approx((25.0123, -45.0456), abs=2e-6)
    assert (found["cs"], found["display"], found["band"]) == (True, False, True)


def test_name_and_sizes_of_class_a_are_read_by_others() -> None:
    found = decode(*ais.sentences(ais.static_a(SHIP), "A", 3))
    assert (found["shipname"], found["callsign"], found["ship_type"]) == ("NORTH STAR", "DABC", 80)
    assert (found["to_bow"], found["to_stern"]) == (150, 50)
    assert (found["to_port"], found["to_starboard"], found["draught"]) == (16, 16, 11.0)
    assert (found["month"], found["day"], found["hour"], found["minute"]) == (0, 0, 24, 60)


def test_name_and_sizes_of_class_b_are_read_by_others() -> None:
    part_a, part_b = (ais.sentences(each, "A", 0) for each in ais.static_b(SHIP))
    assert decode(*part_a)["shipname"] == "NORTH STAR"
    found = decode(*part_b)
    assert (found["partno"], found["callsign"], found["ship_type"]) == (1, "DABC", 80)
    assert (found["to_bow"], found["to_starboard"]) == (150, 16)


def test_what_ais_cannot_write_becomes_blank() -> None:
    assert ais.payload(ais.text("a{é", 4)) == ("1PP0", 0)
