"""The model of a session sees small mistakes that the product's own tables do not tell of."""

from collections.abc import Mapping
from typing import Final

import pytest

from simulation.drawing import draw_script
from simulation.mistakes import MISTAKES
from simulation.mutants import with_fault
from simulation.play import play
from simulation.script import Act, Ending, Life, Player, Script, Visit

SEEDS: Final = 100  # within which each is found
LONGEST_S: Final = 5.0  # that a process lives
PACE_S: Final = 0.3  # from word to word
pytestmark = pytest.mark.filterwarnings("ignore::ResourceWarning")  # who is killed closes nothing
ROWS: Final[Mapping[str, str]] = {
    "snapshot-waiting": "freeze|step 4|snapshot A",
    "picture-of-before": "freeze|step 4|snapshot A|step 4|restore A|step 2|restore A",
    "instruments-a-tick-late": "run|time 20|rudder left 30|who|who|who|who|who|who|who|who",
    "alerts-of-later": "freeze|step 4|snapshot A|casualty bus-port-lost|step 4|restore A",
    "plans-of-later": "freeze|snapshot A|step 4|in 100 s depth 80|restore A",
    "jump-lets-time-run": "run|who|who|backtrack 1 s",
    "plan-a-tick-late": "freeze|in 2 s depth 80|step 8",
    "schedule-a-tick-late": "freeze|step 140|who|who",
    "command-at-once": "freeze|take command|who",
    "events-on-the-first-branch": "freeze|step 4|snapshot A|restore A|mark here",
    "plans-told-to-all": "freeze|in 100 s depth 80",
    "back-a-tick-short": "freeze|step 10|backtrack 2 s",
    "plan-from-the-start": "freeze|step 4|in 10 s depth 80",
    "cancel-the-first": "freeze|in 10 s depth 80|in 20 s course 010|cancel all",
}
# Who listens beside the instructor who says the row.
OTHERS: Final = {"command-at-once": "instructor", "plans-told-to-all": "helm"}


def script_of(name: str) -> Script:
    """Return the short script that shows a mistake."""
    acts = tuple(Act(PACE_S, words) for words in ROWS[name].split("|"))
    players = [Player("instructor", (Visit(0.2, acts),))]
    if name in OTHERS:
        watched = (Act(0.1, "who"), Act(3.0, "who"))
        players.insert(0, Player(OTHERS[name], (Visit(0.05, watched),)))
    life = Life(
        seed=1,  # after whose answer to a snapshot it is killed
        seconds=PACE_S * (len(acts) - 0.5) if name == "snapshot-waiting" else 6.0,
        ending=Ending.KILLED if name == "snapshot-waiting" else Ending.SIGNAL,
        turns=1,
        players=tuple(players),
        at_answer=True,
        instruments=name == "instruments-a-tick-late",
    )
    second = Life(2, 1.0, Ending.SIGNAL, 1, (), frozen=True)
    lives = (life, second) if life.ending is Ending.KILLED else (life,)
    exercise = "depth-changes" if name == "schedule-a-tick-late" else ""
    return Script(exercise, 0.0, 1.0, lives)


def test_each_mistake_has_a_row() -> None:
    assert ROWS.keys() == MISTAKES.keys()


@pytest.mark.parametrize("name", ROWS)
def test_a_mistake_is_seen_in_a_short_script(name: str) -> None:
    script = script_of(name)

    assert play(script, with_fault(MISTAKES[name])).breaches
    assert not play(script).breaches


@pytest.mark.slow
@pytest.mark.parametrize("name", MISTAKES)
def test_a_mistake_is_found_within_a_hundred_seeds(name: str) -> None:
    scripts = (draw_script(seed, LONGEST_S) for seed in range(1, 1 + SEEDS))

    assert any(play(script, with_fault(MISTAKES[name])).breaches for script in scripts)
