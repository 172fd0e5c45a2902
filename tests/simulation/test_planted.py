"""Each fault of one line that was planted breaks a law in a short script, as does each sibling."""

from typing import Final

import pytest

from simulation.mutants import with_fault
from simulation.planted import PLANTED, SCRIPTS, Planted, fault_of
from simulation.play import play

pytestmark = pytest.mark.filterwarnings("ignore::ResourceWarning")  # who is killed closes nothing
IDS: Final = [f"{each.where.rpartition('.')[2]} {each.after}" for each in PLANTED]


@pytest.mark.parametrize("planted", PLANTED, ids=IDS)
def test_a_planted_fault_of_one_line_breaks_a_law(planted: Planted) -> None:
    assert play(SCRIPTS[planted.script], with_fault(fault_of(planted))).breaches


@pytest.mark.parametrize("name", SCRIPTS)
def test_without_a_fault_the_script_breaks_none(name: str) -> None:
    docket = play(SCRIPTS[name])

    assert not docket.breaches
    assert docket.ticks
