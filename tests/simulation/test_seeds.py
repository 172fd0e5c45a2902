"""Whole sessions hold every law, by as many seeds as half a minute of processor holds."""

import random
import subprocess
import sys
from collections import Counter
from pathlib import Path
from typing import Final

import pytest
from helpers import places

from simulation.disk import Trouble
from simulation.drawing import draw_script
from simulation.milestones import MILESTONES, SAID_MILESTONES, never_reached, reach_table
from simulation.planted import SCRIPTS
from simulation.play import play
from simulation.script import (
    Act,
    Ending,
    Life,
    Mishap,
    Player,
    Script,
    Visit,
    read_script,
    write_script,
)
from simulation.seeds import play_seed
from simulation.vocabulary import CHOICES, DEALT, FOREIGN, SCENES
from trainer.io.orders.grammar import Order, parse
from trainer.io.orders.words import ORDER_WORDS

SEEDS: Final = 60  # `python -m tests.simulation` plays more
# They need an exercise with aids or an evaluation, a boat that is crushed, a leak that lasts, or an
# instructor after the end of an exercise with marks.
SELDOM_SAID: Final = {
    *("word ghost", "word what-if", "gate lost_gate", "called oil tank half"),
    *("word release-marks", "heard marks"),
}
LONGEST_S: Final = 5.0  # that a process lives
KEPT: Final = sorted((places.TESTS / "simulation" / "kept").glob("*.json"))
pytestmark = pytest.mark.filterwarnings("ignore::ResourceWarning")  # who is killed closes nothing


@pytest.mark.long
def test_sessions_of_many_seeds_hold_every_law_and_say_all_that_can_be_said() -> None:
    played = [play_seed(seed, LONGEST_S) for seed in range(1, 1 + SEEDS)]

    assert not [(each.seed, *map(str, each.breaches)) for each in played if each.breaches]
    assert sum(each.counts["kills"] for each in played)
    assert sum(each.counts["power cuts"] for each in played)
    reached = frozenset[str]().union(*(each.sample.reached for each in played))
    assert set(SAID_MILESTONES) - reached <= SELDOM_SAID


@pytest.mark.parametrize("path", KEPT, ids=lambda path: path.stem)
def test_what_once_broke_a_law_breaks_none(path: Path) -> None:
    docket = play(read_script(path))

    assert not docket.breaches
    assert docket.ticks or docket.orders


def test_a_script_is_read_back_from_its_file(tmp_path: Path) -> None:
    for script in (draw_script(random.Random(1969).randrange(1000)), SCRIPTS["words"]):  # noqa: S311
        write_script(script, tmp_path / "script.json")

        assert read_script(tmp_path / "script.json") == script


PLAY: Final = """
import sys
from simulation.seeds import play_seed
from simulation.vocabulary import CHOICES, DEALT, FOREIGN, SCENES
print(*(play_seed(seed, 5.0).trace for seed in (3, 7, 10)))
"""


@pytest.mark.process
def test_a_seed_gives_the_same_bytes_in_another_process_with_another_hash_seed() -> None:
    traces = {
        subprocess.run(
            [sys.executable, "-c", PLAY],
            env=places.tests_environment(PYTHONHASHSEED=hash_seed),
            stdout=subprocess.PIPE,
            check=True,
        ).stdout
        for hash_seed in ("1", "2")
    }

    assert len(traces) == 1
    assert len(set(traces.pop().split())) == 3


def lone(*words: str, seconds: float = 10.0) -> Script:
    """Return the script of an instructor alone, who says these words, one each second."""
    acts = tuple(Act(1.0, each) for each in words)
    player = Player("instructor", (Visit(0.1, acts),))
    return Script("", 0.0, 1.0, (Life(1, seconds, Ending.SIGNAL, 1, (player,)),))


def test_time_jumps_to_what_comes_next() -> None:
    """A second that nobody uses costs nothing, and one that is flown its ticks."""
    docket = play(lone("freeze", seconds=1000.0))

    assert not docket.breaches
    assert docket.answers == 2
    assert docket.ticks < 10


def test_a_session_that_goes_on_flies_its_ticks() -> None:
    docket = play(lone("depth 70", "course 010", seconds=30.0))

    assert not docket.breaches
    assert abs(docket.ticks - 60) <= 1
    assert docket.answers == 3


def test_plans_may_be_cancelled_by_an_order_that_a_full_disk_left_without_answer() -> None:
    """The page of the orders has room for one more, and that of the events has none."""
    plans = [Act(0.02, "at 40 s depth 80 m")] * 47
    acts = (*plans, Act(1.0, "cancel all"))
    player = Player("instructor", (Visit(0.1, acts),))
    full = Mishap(1.8, Trouble.FULL, 60.0)
    killed = Life(5, 6.0, Ending.KILLED, 1, (player,), mishaps=(full,), frozen=True)
    docket = play(Script("", 0.0, 1.0, (killed, Life(2, 2.0, Ending.SIGNAL, 1, ()))))

    assert "L1: a kill between journal and answer" in docket.log.reached
    assert not docket.breaches


def test_a_seed_tells_what_it_has_reached() -> None:
    scene = (
        "freeze",
        "snapshot A",
        "in 10 s depth 90",
        "restore A",
        "run",
        "replay 5 s",
        "mark it",
    )
    docket = play(lone(*scene, seconds=12.0))
    assert not docket.breaches
    assert docket.log.reached.keys() >= {
        *(f"word {name}" for name in ("freeze", "snapshot", "plan", "restore", "run", "mark")),
        "L17: a jump takes plans away",
        "L3: a jump in a freeze",
    }
    assert not docket.log.reached.keys() & {"word casualty", "L3: a take-over in a freeze"}


def test_the_table_has_every_milestone_and_names_those_that_are_lacking() -> None:
    reached = Counter(dict.fromkeys(MILESTONES, 3) | {"word run": 1})
    table = reach_table(reached, 7)
    assert "      3 of 7  L17: a plan comes" in table
    assert table[0].startswith("      0 of 7  word ")
    lacking = never_reached(reached)
    assert "word freeze" in lacking
    assert not {"word run", *MILESTONES} & set(lacking)
    assert len(MILESTONES) > 40


def test_whatever_is_said_in_a_script_is_an_order() -> None:
    said = [words for choices in CHOICES.values() for words in choices]
    said += [words for scene in (*SCENES, *DEALT) for words in scene.split("|")]
    said += FOREIGN
    assert [words for words in said if not isinstance(parse(words), Order)] == []
    names = {order.name for words in said if isinstance(order := parse(words), Order)}
    elsewhere = {"contact"}  # by ships' master
    assert set(ORDER_WORDS) - names == elsewhere
