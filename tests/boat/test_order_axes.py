"""What an order works by hand is said by its row, which is held to what the order writes."""

import pytest
from helpers.boats import make_boat

from trainer.boat.boat import STATE_OFFSETS, Boat
from trainer.boat.effects import WORD_EFFECTS, Effect, effects_of_word
from trainer.io.orders.words import ORDER_WORDS, TRAINEE
from trainer.session.crew.manning import BY_HAND

BOATS = ("bb2", "remus100", "sdv-mk9")
AXIS_BY_FIELD = {  # of the state: 1 by hand, 0 by the autopilot
    "rudder_by_hand": "rudder",
    "stern_by_hand": "planes",
    "bow_by_hand": "planes",
    "speed_by_hand": "speed",
    "trim_by_hand": "ballast",
}
# whose work is water that is moved, or a lever and a way to feed it, and no word to the autopilot
OTHERWISE = {"negative", "flood", "pump", "drain", "hover", "compressor"}
OTHERWISE |= {"lever", "rudder-mode", "planes-mode"}
ANYBODY = {"visitor", TRAINEE}  # who has all of it, or a lever of his own


def handed(effect: Effect, to: float) -> set[str]:
    """Return the axes that an order gives to the hand (1) or to the autopilot (0)."""
    axes = {STATE_OFFSETS[field]: axis for field, axis in AXIS_BY_FIELD.items()}
    constants = (write for write in effect.writes if write.rule == "const")
    return {axes[each.place] for each in constants if each.place in axes and each.argument == to}


@pytest.fixture(scope="module", params=BOATS)
def boat(request: pytest.FixtureRequest) -> Boat:
    return make_boat(request.param)


@pytest.mark.parametrize("name", sorted(WORD_EFFECTS))
def test_an_order_works_by_hand_and_gives_up_what_its_row_says(boat: Boat, name: str) -> None:
    word, worked, given = ORDER_WORDS[name], set[str](), set[str]()
    for effect in effects_of_word(boat, name):
        last = effect.words.rpartition(" ")[2]
        assert handed(effect, 1.0) <= {*word.moves(last)}, effect.words
        worked |= handed(effect, 1.0)
        given |= handed(effect, 0.0)
        if word.automates(last):
            assert handed(effect, 0.0) <= {*word.automates(last)}, effect.words
    assert given <= {*word.gives_up}
    if worked:
        assert worked >= {*word.works}


@pytest.mark.parametrize("axis", BY_HAND)
def test_only_who_has_an_axis_has_an_order_that_works_it(axis: str) -> None:
    _, example = BY_HAND[axis]
    own = {*ORDER_WORDS[example.partition(" ")[0]].control.roles}
    for word in ORDER_WORDS.values():
        if axis in word.works and word.needs != "plant":
            assert {*word.control.roles} - ANYBODY <= own, word.name
