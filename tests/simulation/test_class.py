"""Classes of three sessions hold every law, and a fault of the class's sea breaks one."""

# ruff: noqa: SLF001  a fault lies in private parts

from collections.abc import Callable
from typing import Any, Final

import pytest

from simulation.class_laws import alike_rates
from simulation.class_play import play_class
from simulation.mutants import with_fault
from trainer.classroom import one_sea
from trainer.classroom.one_sea import OneSea, SeaBoat
from trainer.io.orders.sentences import Sentence

SEEDS: Final = (4, 61, 82)  # of which two once showed a boat that was gone
LONG_SEEDS: Final = (
    213,  # a new line that begins in a replay is lost in it: the boat was shown where it had been
    294,  # restored, and at once replayed: the law did not see where it had come to
    358,  # near each other after times unlike: the law had them still parted
    866,  # in a replay since its line began: the law took it to be heard
    1474,  # its line is lost in a freeze at the start: boats that it was told there stayed
    1860,  # dies twice before the class has a line again: the law forgot where it went on from
)
MORE: Final = 20  # within which each fault is found
pytestmark = pytest.mark.filterwarnings("ignore::ResourceWarning")  # who is killed closes nothing


@pytest.mark.parametrize(
    "seed", [*SEEDS, *(pytest.param(seed, marks=pytest.mark.long) for seed in LONG_SEEDS)]
)
def test_a_class_with_kills_freezes_jumps_and_replays_holds_every_law(seed: int) -> None:
    played = play_class(seed)

    assert not played.breaches
    assert played.counts["told boat"]


@pytest.mark.long
def test_a_class_gives_the_same_bytes_when_it_is_played_again() -> None:
    assert play_class(1).trace == play_class(1).trace != play_class(4).trace


def keep_then(patch: pytest.MonkeyPatch) -> None:
    """Leave the boats of then where they are, after a jump."""
    patch.setattr(SeaBoat, "forget", lambda boat: setattr(boat, "jumped", False))


def take_past(patch: pytest.MonkeyPatch) -> None:
    """Take the place of a replay for the boat's own."""
    patch.setattr(SeaBoat, "shows_past", property(lambda _: False))


def swap_numbers(patch: pytest.MonkeyPatch) -> None:
    """Tell the place of one boat as another's."""
    meet = SeaBoat.meet
    patch.setattr(SeaBoat, "meet", lambda boat, number, other: meet(boat, number % 3 + 1, other))


def part_nobody(patch: pytest.MonkeyPatch) -> None:
    """Show boats to each other wherever they are."""
    patch.setattr(one_sea, "PARTED_M", 0.0)


def mix_times(patch: pytest.MonkeyPatch) -> None:
    """Tell boats of each other whose times run otherwise."""

    def meet(sea: OneSea, boat: SeaBoat, number: int) -> None:
        other = sea.boats[number]
        if boat.hears and boat.there and other.there:
            boat.meet(number, other)

    patch.setattr(OneSea, "_meet", meet)


def part_unheard(patch: pytest.MonkeyPatch) -> None:
    """Say to a session that replays that another boat is gone: it refuses that."""

    def part(boat: SeaBoat, number: int) -> None:
        boat.parted.discard(number)
        if boat.told.pop(number, None):
            boat.say(f"contact boat-{number} remove")

    patch.setattr(SeaBoat, "part", part)


def keep_place(patch: pytest.MonkeyPatch) -> None:
    """Take a boat, whose new line begins in a replay, to be where it was before."""
    hear = SeaBoat._hear

    def hear_on(boat: SeaBoat, said: Sentence) -> None:
        before = boat._place
        hear(boat, said)
        boat._place = boat._place or before

    patch.setattr(SeaBoat, "_hear", hear_on)


def hide_past(patch: pytest.MonkeyPatch) -> None:
    """Show no boat that replays."""
    there: Any = vars(SeaBoat)["there"]
    shown = property(lambda boat: there.fget(boat) and not boat.shows_past)
    patch.setattr(SeaBoat, "there", shown)


def show_again(patch: pytest.MonkeyPatch) -> None:
    """Show boats to each other, whose times have run otherwise, wherever they have come to."""
    meet = OneSea._meet

    def meet_again(sea: OneSea, boat: SeaBoat, number: int) -> None:
        before = boat.parted & {number}
        meet(sea, boat, number)
        boat.parted |= before

    patch.setattr(OneSea, "_meet", meet_again)


def lose_others(patch: pytest.MonkeyPatch) -> None:
    """Never show boats to each other again, whose times have run otherwise."""
    meet = OneSea._meet
    lost: set[tuple[int, int]] = set()

    def meet_others(sea: OneSea, boat: SeaBoat, number: int) -> None:
        if not alike_rates(boat.rate, sea.boats[number].rate):
            lost.add((id(boat), number))
        if (id(boat), number) in lost:
            boat.part(number)
        else:
            meet(sea, boat, number)

    patch.setattr(OneSea, "_meet", meet_others)


FAULTS: Final = (
    *(keep_then, take_past, swap_numbers, part_nobody, mix_times, part_unheard),
    *(keep_place, hide_past, show_again, lose_others),
)


@pytest.mark.slow
@pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: fault.__name__)
def test_a_fault_put_into_the_sea_of_a_class_is_found(
    fault: Callable[[pytest.MonkeyPatch], None],
) -> None:
    seeds = (*SEEDS, *LONG_SEEDS, *range(1, 1 + MORE))

    assert any(play_class(seed, with_fault(fault)).breaches for seed in seeds)
