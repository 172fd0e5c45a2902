"""When a session was lost: the order after which other chance helps no more.

A script that breaks a law is played up to one of its orders, and from there on with other chance,
some times. The share of these that break the law too is small at its beginning and large at its
end. The order at which it rises is told, and a script that ends there is shrunk first.
"""

from dataclasses import replace
from typing import Final, NamedTuple

from simulation.drawing import redraw
from simulation.laws import Law
from simulation.play import Change, play
from simulation.script import Point, Script
from simulation.seeds import breaks_law

TRIALS: Final = 20  # other chances, for each moment
TRIAL_S: Final = 3.0  # that a process goes on at most (estimate)


class Moment(NamedTuple):
    """An order, and how often the law is broken after it."""

    number: int  # of the order, from 0
    words: str
    tick: int
    point: Point
    share: float  # [-]

    def __str__(self) -> str:
        place = f"process {self.point.life}, {self.point.seconds:.3f} s, tick {self.tick}"
        return f"{self.share:.2f} after order {self.number} ({place}): {self.words}"


class Loss(NamedTuple):
    """The order at which a script was lost, None for none, and what shows it."""

    curve: tuple[Moment, ...]  # in the order of the script
    lost: Moment | None
    cut: Script  # that ends there, the whole one where that breaks nothing


def find_loss(script: Script, law: Law, *changes: Change, trials: int = TRIALS) -> Loss:
    """Find the order after which a law is broken whatever comes, by halves."""
    docket = play(script, *changes)
    orders = docket.log.orders
    known: dict[int, Moment] = {}

    def share_after(number: int) -> float:
        if number not in known:
            tick, words, point = orders[number]
            broken = sum(
                breaks_law(redraw(script, point, trial, TRIAL_S), law, *changes)
                for trial in range(trials)
            )
            known[number] = Moment(number, words, tick, point, broken / trials)
        return known[number].share

    if not orders:
        return Loss((), None, script)
    low, high = 0, len(orders) - 1
    middle = (share_after(low) + share_after(high)) / 2.0
    if share_after(high) <= share_after(low):
        return Loss(_curve(known), None, script)
    while high - low > 1:
        between = (low + high) // 2
        if share_after(between) > middle:
            high = between
        else:
            low = between
    cut = cut_after(script, known[high].point)
    return Loss(_curve(known), known[high], cut if breaks_law(cut, law, *changes) else script)


def cut_after(script: Script, point: Point) -> Script:
    """Return a script without what one of its processes has not begun at a point."""
    lives, before = script.lives, point.life - 1
    life = lives[before]
    players = []
    for player, (done, said) in zip(life.players, point.places, strict=True):
        visits = player.visits[:done]
        if said >= 0:
            visit = player.visits[done]
            visits = (*visits, replace(visit, acts=visit.acts[:said]))
        players.append(replace(player, visits=visits))
    short = replace(life, players=tuple(players), mishaps=life.mishaps[: point.mishaps])
    return replace(script, lives=(*lives[:before], short, *lives[point.life :]))


def _curve(known: dict[int, Moment]) -> tuple[Moment, ...]:
    return tuple(known[number] for number in sorted(known))
