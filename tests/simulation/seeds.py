"""A seed is played: its script once, and some scripts twice."""

from collections.abc import Iterator
from typing import Final, NamedTuple

from simulation.drawing import draw_script
from simulation.exploring import Explorer
from simulation.laws import Breach, Law
from simulation.play import Change, play
from simulation.script import Point, Script
from simulation.weights import Sample, actions_of

TWICE_EVERY: Final = 10  # seeds: of these one is played again, for L4


class Played(NamedTuple):
    """What came of a seed."""

    seed: int
    breaches: tuple[Breach, ...]
    counts: dict[str, int]
    trace: str  # the digest of all bytes
    sample: Sample  # what it did, and which milestones it reached
    script: Script
    points: dict[str, Point]  # where it reached each first


def play_seed(seed: int, longest: float) -> Played:
    """Play the script of a seed, no process of which lives longer [s]."""
    return play_drawn(seed, draw_script(seed, longest))


def explore(first: int, scripts: int, longest: float) -> Iterator[Played]:
    """Play scripts that go on from where others came first; yield what came of each.

    No process of a script that begins from nothing lives longer [s].
    """
    explorer = Explorer(first, longest)
    for number in range(first, first + scripts):
        played = play_drawn(number, explorer.draw())
        explorer.learn(played.script, played.points)
        yield played


def play_drawn(seed: int, script: Script) -> Played:
    """Play the script that a seed has drawn."""
    docket = play(script)
    breaches = list(docket.breaches)
    trace = docket.trace.hexdigest()
    if seed % TWICE_EVERY == 0 and play(script).trace.hexdigest() != trace:
        breaches.append(Breach(Law.SAME_BYTES, "played again, its bytes are others"))
    counts = {
        "seeds": 1,
        "processes": docket.life,
        "kills": docket.kills,
        "power cuts": docket.power_cuts,
        "orders": docket.orders,
        "answers": docket.answers,
        "ticks": docket.ticks,
    }
    sample = Sample(actions_of(script, docket.life), frozenset(docket.log.reached))
    points = {name: point for name, point in docket.log.reached.items() if point}
    return Played(seed, tuple(breaches), counts, trace, sample, script, points)


def breaks_law(script: Script, law: Law, *changes: Change) -> bool:
    """Return whether a script breaks a law, with the product changed so."""
    if law is Law.SAME_BYTES:
        return play(script, *changes).trace.digest() != play(script, *changes).trace.digest()
    return any(breach.law is law for breach in play(script, *changes).breaches)
