"""A fleet is heard in sessions that are played, and the law of AIS finds what it is for."""

from collections.abc import Sequence
from typing import Final

import pytest

from simulation.instruments import CABLE
from simulation.laws import Docket, Law
from simulation.machine import Machine
from simulation.play import play
from simulation.script import Act, Ending, Life, Player, Script, Visit
from simulation.traffic import Air, Audible, Moment, Receiver
from trainer.io import ais
from trainer.io.ais import PositionReport, ShipParticulars

pytestmark = pytest.mark.filterwarnings("ignore::ResourceWarning")  # who is killed closes nothing
OUTLET: Final = f"nmea {CABLE}"
NEAR: Final = 211_000_001
PLACE: Final = ais.sentences(
    ais.position_a(PositionReport(NEAR, 25.0, -45.0, 14.2, 271.4, 270.0, 0.0, 13)), "A", 0
)
NAME: Final = ais.sentences(
    ais.static_a(ShipParticulars(NEAR, "north star", 80, 150, 50, 16, 16)), "B", 7
)


def heard(
    sets: Sequence[tuple[float, Sequence[str]]], *, gone: bool = False, lost: int = 0
) -> list[str]:
    """Return what is broken by sets at times [s] and what follows each, of one ship near."""
    docket, air = Docket(Machine()), Air()
    ships = {} if gone else {NEAR: Audible(small=False, period=10.0)}
    receiver = Receiver(OUTLET, air, docket)
    for time, more in sets:
        tick = round(2 * time)
        lines = ["$INRMC,", f"$PXSC,M,{tick},", *more]
        air.moments[OUTLET].append(Moment(tick, time, ships, frozenset(), 0, lines))
        for line in lines[: len(lines) - lost]:
            receiver.hear(line)
    receiver.hear("$INRMC,")
    assert {breach.law for breach in docket.breaches} <= {Law.AIS}
    return [breach.text for breach in docket.breaches]


def test_what_is_promised_breaks_nothing() -> None:
    assert not heard([(0, ()), (9, ()), (10, PLACE), (15, NAME), (20, PLACE), (20, ()), (5, ())])


@pytest.mark.parametrize(
    ("sets", "says"),
    [
        ([(0, ()), (10, ())], "place of 211000001 is not heard for 10 s"),
        ([(t, PLACE) for t in range(0, 380, 10)], "name of 211000001 is not heard for 360 s"),
        ([(0, NAME[:1]), (1, ()), (2, ())], "parts of a message are missing"),
        ([(0, NAME[1:])], "no part of a message"),
        ([(0, NAME[:1] + PLACE)], "no part of a message"),
        ([(0, [PLACE[0].replace(",A,", ",C,")])], "no part of a message"),
        ([(0, [PLACE[0][:-2] + "00"])], "no part of a message"),
        ([(0, ()), (0, PLACE), (1, ())], "while time stands still"),
    ],
)
def test_each_fault_of_what_is_heard_is_told(
    sets: Sequence[tuple[float, Sequence[str]]], says: str
) -> None:
    assert any(says in text for text in heard(sets))


def test_a_sentence_that_is_lost_has_to_be_counted() -> None:
    assert "sentences are lost, and not counted" in heard([(0, PLACE), (5, ())], lost=1)[0]


def test_a_ship_that_is_gone_is_heard_no_more() -> None:
    (text,) = heard([(0, ()), (10, PLACE)], gone=True)

    assert "211000001 is heard, which is gone or beyond reach" in text


def test_a_fleet_is_heard_by_cable_and_by_datagrams(monkeypatch: pytest.MonkeyPatch) -> None:
    told: list[str] = []
    hear = Receiver._hear_message  # noqa: SLF001  what it is given is counted

    def hear_noted(self: Receiver, letters: str, fill: int) -> None:
        told.append(self.outlet)
        hear(self, letters, fill)

    monkeypatch.setattr(Receiver, "_hear_message", hear_noted)
    master = Player("instructor", (Visit(0.1, (Act(2.0, "contact s1 remove"),)),))
    life = Life(1, 6.0, Ending.SIGNAL, 1, (master,), instruments=True)
    docket = play(Script("", 0.0, 20.0, (life,), fleet=1))

    assert not docket.breaches
    assert docket.ticks > 200
    assert len(told) > 200
    assert told.count(OUTLET) == pytest.approx(len(told) / 2, rel=0.1)
