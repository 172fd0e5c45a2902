"""A seed is played: its script once, and some scripts twice."""

from collections.abc import Iterator
from typing import Final, NamedTuple

from simulation.drawing import draw_script
from simulation.exploring import Counts, Explorer, counts_of
from simulation.laws import Breach, Law
from simulation.play import Change, play
from simulation.script import Script
from simulation.weights import Sample, actions_of

TWICE_EVERY: Final = 10  # seeds: of these one is played again, for L4


class Played(NamedTuple):
    """What came of a seed."""

    seed: int
    breaches: tuple[Breach, ...]
    counts: Counts
    trace: str  # the digest of all bytes
    sample: Sample  # what it did, and which milestones it reached
    script: Script


def play_seed(seed: int, longest: float) -> Played:
    """Play the script of a seed, no process of which lives longer [s]."""
    script = draw_script(seed, longest)
    docket = play(script)
    trace = docket.trace.hexdigest()
    breaches = (*docket.breaches, *check_again(seed, script, trace))
    sample = Sample(actions_of(script, docket.life), frozenset(docket.log.reached))
    return Played(seed, breaches, {"seeds": 1, **counts_of(docket)}, trace, sample, script)


def explore(first: int, scripts: int, longest: float) -> Iterator[Played]:
    """Play scripts that go on from where others came first; yield what came of each.

    No process of a script that begins from nothing lives longer [s].
    """
    leaves = Explorer(first, longest).explore()
    for number, leaf in zip(range(first, first + scripts), leaves, strict=False):
        breaches = (*leaf.breaches, *check_again(number, leaf.script, leaf.trace))
        sample = Sample(actions_of(leaf.script, leaf.processes), leaf.reached)
        counts = {"seeds": 1, **leaf.counts}
        yield Played(number, breaches, counts, leaf.trace, sample, leaf.script)


def check_again(number: int, script: Script, trace: str) -> Iterator[Breach]:
    """L4: play one script in some again from its beginning, and compare its bytes."""
    if number % TWICE_EVERY == 0 and play(script).trace.hexdigest() != trace:
        yield Breach(Law.SAME_BYTES, "played again, its bytes are others")


def breaks_law(script: Script, law: Law, *changes: Change) -> bool:
    """Return whether a script breaks a law, with the product changed so."""
    if law is Law.SAME_BYTES:
        return play(script, *changes).trace.digest() != play(script, *changes).trace.digest()
    return any(breach.law is law for breach in play(script, *changes).breaches)
