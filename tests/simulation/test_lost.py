"""The order at which a session was lost is told."""

from typing import Final

import pytest

from simulation.laws import Law
from simulation.lost import find_loss
from simulation.mutants import with_fault
from simulation.script import Act, Ending, Life, Player, Script, Visit
from simulation.seeds import breaks_law
from trainer.boat.boat import Boat
from trainer.boat.helm import obey_order
from trainer.io.orders.grammar import Order, Reply
from trainer.session import dispatch

ODD_DEPTH: Final = 81.0  # [m]
pytestmark = pytest.mark.filterwarnings("ignore::ResourceWarning")  # who is killed closes nothing
WORDS = (
    *("freeze", "depth 70", "step 3", "course 010", "step 2", "who", "status", "step 2"),
    *("snapshot Z", "restore Z", "run", "depth 81", "who", "step 2", "status", "plans"),
)


def leave_trace(patch: pytest.MonkeyPatch) -> None:
    """Change the boat beside one order, which no other chance gives."""

    def obey_and_touch(boat: Boat, order: Order) -> Reply:
        reply = obey_order(boat, order)
        if order.name == "depth" and order.value == ODD_DEPTH:
            boat.state.z += 0.01
        return reply

    patch.setattr(dispatch, "obey_order", obey_and_touch)


@pytest.mark.long
def test_the_order_at_which_a_session_is_lost_is_told_and_shrinking_begins_there() -> None:
    acts = tuple(Act(0.3, words) for words in WORDS)
    life = Life(1, 8.0, Ending.SIGNAL, 1, (Player("instructor", (Visit(0.1, acts),)),))
    script, fault = Script("", 0.0, 1.0, (life,)), with_fault(leave_trace)

    loss = find_loss(script, Law.FLOWN_AGAIN, fault, trials=6)

    assert loss.lost
    assert "depth 81" in loss.lost.words
    assert loss.lost.share == 1.0
    assert min(moment.share for moment in loss.curve) == 0.0
    assert loss.cut.acts == WORDS.index("depth 81") + 1
    assert breaks_law(loss.cut, Law.FLOWN_AGAIN, fault)
    assert not breaks_law(loss.cut, Law.FLOWN_AGAIN)
