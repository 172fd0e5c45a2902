"""A script is played again up to a point, exactly, and goes on with other chance."""

import os
import random
from collections import Counter
from pathlib import Path

import numpy as np
import pytest

from simulation import exploring
from simulation.chains import CHAINS, comes_through, compare, plant
from simulation.drawing import Dice, draw_script, redraw
from simulation.exploring import MOST_WAYS, Explorer
from simulation.forks import Shelf
from simulation.milestones import MILESTONES
from simulation.play import play
from simulation.script import (
    Act,
    Ending,
    Life,
    Player,
    Script,
    Visit,
    read_script,
    write_script,
)
from simulation.seeds import explore

pytestmark = pytest.mark.filterwarnings("ignore::ResourceWarning")  # who is killed closes nothing


@pytest.fixture
def small_trees(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let little go on from one beginning."""
    monkeypatch.setattr(exploring, "MOST_OF_TREE", 4)


@pytest.mark.long
@pytest.mark.parametrize("seed", [2, 3, 5])
def test_what_was_reached_before_a_point_is_reached_again_at_the_same_turn(
    seed: int, tmp_path: Path
) -> None:
    script = draw_script(seed, 5.0)
    reached = play(script).log.reached
    points = sorted(p for p in reached.values() if p and p.turns)
    point = random.Random(seed).choice(points)  # noqa: S311  no secret
    before = {n: (p.life, p.turns) for n, p in reached.items() if p and p[:2] <= point[:2]}

    others = [redraw(script, point, other, 3.0) for other in (1, 2)]

    write_script(others[0], tmp_path / "script.json")
    assert read_script(tmp_path / "script.json") == others[0]
    for other in others:
        again = play(other).log.reached
        assert {n: (p.life, p.turns) for n in before if (p := again[n])} == before
    assert others[0] != others[1]


def test_what_goes_on_likes_a_few_actions_which_its_seed_draws() -> None:
    def most_said(seed: int, *, likes: bool) -> tuple[str, float]:
        dice = Dice(f"{seed}/liking")
        if likes:
            dice.like_some()
        said = Counter(dice.draw("instructor") for _ in range(1000))
        ((word, count),) = said.most_common(1)
        return word, count / 1000.0

    assert all(most_said(seed, likes=False)[1] < 0.1 for seed in range(9))
    liked = [most_said(seed, likes=True) for seed in range(9)]
    assert np.mean([share for _, share in liked]) > 0.1
    assert len({word for word, _ in liked}) > 5
    assert most_said(1, likes=True) == liked[1]


def test_what_is_new_is_three_milestones_of_one_process_in_an_order_not_seen_before() -> None:
    first, second, third = MILESTONES[:3]
    explorer = Explorer(1, 5.0)
    for name in (first, second, "word run", third):
        explorer.see(1, name)
    assert explorer.new == 1
    explorer.see(1, second)  # after both before it, and after the third and either
    assert explorer.new == 4
    for name in (first, second, third):
        explorer.see(2, name)  # another process, in the same order
    assert explorer.new == 4
    assert explorer.ways() == MOST_WAYS
    assert explorer.ways() == 1  # nothing is new
    assert explorer.ways() == 0


@pytest.mark.process
@pytest.mark.long
@pytest.mark.usefixtures("small_trees")
@pytest.mark.parametrize("seed", [8, 9])
def test_a_script_that_goes_on_in_a_child_gives_the_bytes_of_one_that_is_played_alone(
    seed: int,
) -> None:
    leaves = Explorer(seed, 3.0).grow()

    assert any(life.redrawn for leaf in leaves for life in leaf.script.lives)
    for leaf in random.Random(seed).sample(leaves, min(len(leaves), 3)):  # noqa: S311  no secret
        assert not leaf.breaches
        assert play(leaf.script).trace.hexdigest() == leaf.trace


def test_files_are_put_back_under_what_is_open_of_them(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "here").mkdir()
    monkeypatch.chdir(tmp_path / "here")
    folder, kept, gone = Path("1"), Path("1/kept"), Path("1/gone")
    folder.mkdir()
    kept.write_text("before")
    gone.write_text("here")
    with gone.open() as held:
        shelf = Shelf()
        kept.write_text("after, and longer")
        gone.unlink()
        Path("2").mkdir()
        Path("2/new").write_text("new")
        shelf.put_back()

        assert os.fstat(held.fileno()).st_ino == gone.stat().st_ino
    assert kept.read_text() == "before"
    assert sorted(map(str, Path().rglob("*"))) == ["1", "1/gone", "1/kept"]
    assert not list(tmp_path.glob("trainer-f-*"))


@pytest.mark.process
@pytest.mark.long
@pytest.mark.usefixtures("small_trees")
def test_scripts_go_on_from_where_others_came_and_hold_every_law() -> None:
    played = list(explore(2, 6, 3.0))

    assert not [(each.seed, *map(str, each.breaches)) for each in played if each.breaches]
    assert any(life.redrawn for each in played for life in each.script.lives)


@pytest.mark.long
def test_a_chain_of_three_events_breaks_a_law_where_it_is_planted_alone() -> None:
    words = ("freeze", "snapshot A", "step 2", "restore A", "in 9 s depth 80", "run", "step 2")
    chain = (
        "L3: a jump in a freeze",
        "L17: a plan is made in a freeze",
        "L17: a plan is cancelled",
    )
    assert comes_through(["word run", *chain[:2], "word run", chain[2]], chain)
    acts = tuple(Act(0.3, each) for each in (*words, "cancel all", "step 3", "who"))
    life = Life(1, 5.0, Ending.SIGNAL, 1, (Player("instructor", (Visit(0.1, acts),)),))
    script = Script("", 0.0, 1.0, (life,))

    assert play(script, plant(chain)).breaches
    assert not play(script, plant(chain[::-1])).breaches


@pytest.mark.process
@pytest.mark.long
@pytest.mark.usefixtures("small_trees")
def test_two_ways_are_compared_by_the_same_chains() -> None:
    *lines, last = compare(0.5, 1)

    assert len(lines) == len(CHAINS)
    assert all(line.startswith("plain ") and line.count(", then ") == 2 for line in lines)
    assert last.startswith(f"of {len(CHAINS)}, ")
