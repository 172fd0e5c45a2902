"""Whatever one boat of a class says, the others go on in one sea as if it had said nothing."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from types import SimpleNamespace
from typing import Any, Final

import pytest
from hypothesis import given
from hypothesis import strategies as st

from trainer.classroom.one_sea import LOST_AFTER_S, OneSea
from trainer.io.orders import sentences
from trainer.io.orders.grammar import Order

STEP_S: Final = 0.5
SPACING_M: Final = 1000.0
TIME: Final = ("running", "1.0", "", "1", "no", "no")
MOTION: Final = (
    *("60.00", "90.00", "6.00", "0.00", "0.00", "0.0", "0.0", "0.000", "0.000", "0.0000"),
    *("0.000", "0.000", "0.00", "3.09", "0.0", "400.0"),
)
ODD: Final = ("", "fast", "max", "nan", "-inf", "1e999", "9" * 400, "inf", "-1", "1e300", "6O", "-")
SOME: Final = st.sampled_from((*ODD, "0.0", "no", "yes", "frozen")) | st.text(
    st.characters(codec="ascii", exclude_categories=["Cc"], exclude_characters=",$*"), max_size=9
)


@dataclass
class SaidLine:
    """A line on which a boat has said something, and what the class has said there."""

    heard: list[str] = field(default_factory=list)
    said: list[str] = field(default_factory=list)
    ended: bool = False
    trouble: str = ""

    def take(self, _most: int) -> Sequence[str]:
        said, self.said = self.said, []
        return said

    def send(self, text: str) -> None:
        self.heard.append(text)

    def close(self, _patience: float) -> None:
        self.ended = True


class ThreeBoats:
    """Three boats of a class that go east side by side; the first may say what it likes."""

    def __init__(self, patch: pytest.MonkeyPatch) -> None:
        self.now, self.told = 0.0, list[str]()
        self.lines: dict[int, SaidLine] = {}
        patch.setattr("trainer.io.client.dial", self.dial)
        rows: dict[int, Any] = {i: SimpleNamespace(address=i, title=f"boat {i}") for i in (1, 2, 3)}
        self.sea = OneSea(rows, SPACING_M, "chief", self.told.append, lambda: self.now)
        self.sail(6)

    def dial(self, number: int, *_: object) -> SaidLine:
        self.lines[number] = SaidLine()
        return self.lines[number]

    def sail(self, looks: int, *odd: str) -> None:
        """Let time pass; at the first look, the first boat says this beside its place."""
        for look in range(looks):
            self.now += STEP_S
            self.sea.look()
            for boat in self.sea.boats.values():
                if boat._dialler.ident:  # noqa: SLF001  it has been dialled
                    boat._dialler.join()  # noqa: SLF001
            for line in self.lines.values():
                line.said += self.say("time", TIME), self.say("motion", self.motion())
            if not look:
                self.lines[1].said[1:1] = odd
        self.sea.look()

    def motion(self) -> tuple[str, ...]:
        return (*MOTION[:6], f"{3.09 * self.now:.1f}", *MOTION[7:])

    def say(self, channel: str, values: Sequence[str]) -> str:
        return sentences.state(channel, round(self.now / STEP_S), self.now, values)

    def heard(self, number: int) -> list[str]:
        """Return what a boat was told of the others, without the first."""
        words = [text.partition(",")[2].rpartition("*")[0] for text in self.lines[number].heard]
        return [
            each for each in words if not each.startswith(("contact boat 1 ", "contact boat-1"))
        ]

    def has(self, number: int, other: int) -> bool:
        """Return whether a boat has another near."""
        return other in self.sea.boats[number].told


@st.composite
def odd_values(draw: st.DrawFn, values: Sequence[str]) -> tuple[str, ...]:
    """Draw what a channel might have said, with fields changed, lost and added."""
    fields = list(values)
    for place in draw(st.lists(st.integers(0, len(values) - 1), max_size=4)):
        fields[place] = draw(SOME)
    return (
        *fields[: draw(st.integers(0, len(fields)) | st.just(len(fields)))],
        *draw(st.lists(SOME, max_size=2)),
    )


SAID: Final = st.lists(
    st.builds(
        sentences.state,
        st.sampled_from(("time", "motion", "gauges")),
        st.integers(0, 10**18 - 1),
        st.floats(0.0, 1e17),
        odd_values(TIME) | odd_values(MOTION),
    )
    | st.builds(
        sentences.frame,
        st.sampled_from(("TRS", "TRA", "TRF", "TRE", "TRN")),
        st.sampled_from(("", "1", "7")),
        st.lists(SOME, max_size=20).map(",".join),
    ),
    max_size=5,
)


@given(said=SAID)
def test_no_sentence_of_one_boat_ends_or_changes_the_sea_of_the_others(said: list[str]) -> None:
    with pytest.MonkeyPatch.context() as patch:
        quiet, three = ThreeBoats(patch), ThreeBoats(patch)
        quiet.sail(12)
        three.sail(12, *said)

    for number in (2, 3):
        assert three.heard(number) == quiet.heard(number)
        assert three.has(number, 5 - number)
        for text in three.lines[number].heard[1:]:
            message = sentences.parse_line(text)
            assert message
            assert isinstance(message.order, Order), text


@pytest.mark.parametrize(
    ("channel", "values"),
    [
        ("motion", MOTION[:9]),
        ("motion", ()),
        *(("motion", ("60.00", "90.00", *MOTION[2:5], word, *MOTION[6:])) for word in ODD[:7]),
        ("motion", ("99999.00", *MOTION[1:])),  # a depth that no boat has
        ("motion", (*MOTION[:13], "999.00")),  # a way that no boat makes
        ("time", TIME[:3]),
        *(("time", ("running", word, *TIME[2:])) for word in ("", "fast", "nan", "inf")),
    ],
)
def test_a_boat_that_says_what_is_no_place_is_told_lost_and_comes_back(
    channel: str, values: tuple[str, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    three = ThreeBoats(monkeypatch)
    assert three.has(2, 1)
    odd = three.say(channel, values)
    three.sail(1, odd)

    (told,) = three.told
    assert told.startswith(f'boat 1 is lost in the sea of the others: it says "{odd[:20]}')
    assert not three.sea.boats[1].hears
    assert three.has(2, 1)  # straight on for a while
    three.sail(8)
    assert three.sea.boats[1].hears
    assert len(three.told) == 1


def test_a_boat_that_says_nothing_else_is_taken_away_and_told_once_a_while(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    three = ThreeBoats(monkeypatch)
    odd = three.say("motion", ("fast", *MOTION[1:]))
    for _ in range(round(1.5 * LOST_AFTER_S / STEP_S)):
        three.sail(1, odd)

    assert not three.sea.boats[1].there
    assert not three.has(2, 1)
    assert three.has(2, 3)
    assert len(three.told) == math.ceil(1.5)
