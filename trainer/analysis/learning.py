"""Baselines of an exercise: nobody aboard, the reference crew, a strategy that learns.

Learning is an evolution strategy (Salimans, Ho, Chen, Sidor and Sutskever, "Evolution strategies as
a scalable alternative to reinforcement learning", 2017) in numpy alone: each boat of a fleet flies
a policy with noise of its own, and the mean goes where the marks rise. ``trainer dev learn`` prints
the table.
"""

import hashlib
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import count as counted
from itertools import islice
from typing import Final

import numpy as np

import trainer
from trainer.core.kernel import Numbers
from trainer.debrief.marks.judgement import judge_run
from trainer.debrief.marks.rehearsal import fly_rehearsal
from trainer.debrief.ticks.judge import nobody_aboard

GENERATION_SIZE: Final = 256  # policies of a generation, in pairs of opposite noise
HIDDEN_UNITS: Final = 12
START_SIZE, NOISE_SIZE, PACE = 0.1, 0.15, 0.03  # [-] of weights; of a step by Adam
FIRST_DECAY, SECOND_DECAY, LEAST_ROOT = 0.9, 0.99, 1e-8  # of Adam's means
TRIAL_SEAS: Final = 8  # in which each baseline is flown, and as many others choose the policy


@dataclass(frozen=True)
class BaselineMarks:
    """The marks of somebody in each sea [%]."""

    who: str
    marks: tuple[float, ...]


@dataclass(frozen=True)
class Baselines:
    """The baselines of an exercise, and the bits of what was learned."""

    exercise: str
    rows: tuple[BaselineMarks, ...]
    generations: int
    ticks: int  # flown to learn
    digest: str  # of the policy


class Policies:
    """Policies of one hidden layer, a row of weights for each boat."""

    def __init__(self, sights: int, controls: int) -> None:
        self.shapes = (
            (HIDDEN_UNITS, sights),
            (HIDDEN_UNITS,),
            (controls, HIDDEN_UNITS),
            (controls,),
        )
        self.ends = np.cumsum([math.prod(shape) for shape in self.shapes]).tolist()

    def act(self, weights: Numbers, seen: Numbers) -> Numbers:
        """Return the actions [boats, controls] from -1 to 1 of what is seen."""
        parts = np.split(weights, self.ends[:-1], axis=1)
        first, bias, second, last = (
            part.reshape(len(weights), *shape)
            for part, shape in zip(parts, self.shapes, strict=True)
        )
        hidden = np.tanh(np.einsum("bij,bj->bi", first, seen) + bias)
        actions: Numbers = np.tanh(np.einsum("bij,bj->bi", second, hidden) + last)
        return actions


def fly_policy(fleet: "trainer.ExerciseFleet", weights: Numbers, draws: Sequence[int]) -> Numbers:
    """Return the marks of one policy in some seas, one for each boat."""
    policies = Policies(len(fleet.sights), len(fleet.controls))
    return fly_policies(fleet, policies, np.tile(weights, (fleet.count, 1)), draws)


def fly_policies(
    fleet: "trainer.ExerciseFleet", policies: Policies, weights: Numbers, draws: Sequence[int]
) -> Numbers:
    """Return the marks of each boat that flies its policy to the end."""
    seen = fleet.reset(draws=draws)
    while not fleet.over.all():
        seen = fleet.step(policies.act(weights, seen.astype(float)))
    return fleet.marks.copy()


def generations_of(exercise: str, seed: int) -> Iterator[Numbers]:
    """Yield the weights of the mean policy after each generation."""
    fleet = trainer.ExerciseFleet(exercise, GENERATION_SIZE)
    policies, random = Policies(len(fleet.sights), len(fleet.controls)), np.random.default_rng(seed)
    mean = START_SIZE * random.standard_normal(policies.ends[-1])
    first = second = np.zeros_like(mean)
    for count in counted(1):
        half = random.standard_normal((GENERATION_SIZE // 2, mean.size))
        noise = np.concatenate((half, -half))
        seas = random.integers(1 << 31, size=GENERATION_SIZE // 2).tolist()
        draws = seas * 2  # a pair has one sea
        ranks = shared_ranks(fly_policies(fleet, policies, mean + NOISE_SIZE * noise, draws))
        rise = np.einsum("b,bw->w", ranks, noise) / (GENERATION_SIZE * NOISE_SIZE)
        first = FIRST_DECAY * first + (1.0 - FIRST_DECAY) * rise
        second = SECOND_DECAY * second + (1.0 - SECOND_DECAY) * rise * rise
        root = np.sqrt(second / (1.0 - SECOND_DECAY**count)) + LEAST_ROOT
        mean = mean + PACE * first / (1.0 - FIRST_DECAY**count) / root
        yield mean


def shared_ranks(marks: Numbers) -> Numbers:
    """Return ranks from -0.5 to 0.5; equal marks share the mean of theirs."""
    _, places, counts = np.unique(marks, return_inverse=True, return_counts=True)
    last = np.cumsum(counts)
    middle = last - 0.5 * (counts + 1)
    ranks: Numbers = middle[places] / max(len(marks) - 1, 1) - 0.5
    return ranks


def learn_policy(exercise: str, seed: int, generations: int) -> Numbers:
    """Return the weights of the best mean policy of so many generations."""
    fleet = trainer.ExerciseFleet(exercise, TRIAL_SEAS)
    own = list(range(TRIAL_SEAS, 2 * TRIAL_SEAS))
    means = islice(generations_of(exercise, seed), generations)
    best, most = np.empty(0), -1.0
    for weights in means:
        marks = fly_policy(fleet, weights, own).mean()
        if marks > most:
            best, most = weights, float(marks)
    return best


def baselines(exercise: str, seed: int, generations: int) -> Baselines:
    """Return the baselines of an exercise, the strategy after so many generations."""
    fleet = trainer.ExerciseFleet(exercise, TRIAL_SEAS)
    draws, weights = list(range(TRIAL_SEAS)), learn_policy(exercise, seed, generations)
    rows = [
        BaselineMarks("nobody aboard", rehearsed(fleet, draws, crewed=False)),
        BaselineMarks("reference crew", rehearsed(fleet, draws, crewed=True)),
        BaselineMarks(f"learned by seed {seed}", (*fly_policy(fleet, weights, draws).tolist(),)),
    ]
    ticks = fleet.drill.last * (GENERATION_SIZE + TRIAL_SEAS) * generations
    digest = hashlib.sha256(weights.tobytes()).hexdigest()[:16]
    return Baselines(exercise, tuple(rows), generations, ticks, digest)


def rehearsed(
    fleet: "trainer.ExerciseFleet", draws: Sequence[int], *, crewed: bool
) -> tuple[float, ...]:
    """Return the marks with nobody aboard, or with the reference crew, in some seas."""
    marks = []
    for plan in map(fleet.plan_of, draws):
        run = fly_rehearsal(plan, plan.crew if crewed else None)
        marks.append(judge_run(run.trajectory, plan, nobody_aboard(plan)).total or 0.0)
    return tuple(marks)


def lines(found: Baselines) -> list[str]:
    """Return the baselines as lines of a page."""
    head = f"{found.exercise}: marks in {TRIAL_SEAS} seas, or the calm"
    columns = f"  {'':20}{'mean':>8}{'least':>8}{'most':>8}"
    rows = [
        f"  {each.who:20}{np.mean(each.marks):8.1f}{min(each.marks):8.1f}{max(each.marks):8.1f}"
        for each in found.rows
    ]
    flown = f"  {found.generations} generations, {found.ticks / 1e6:.1f} million ticks"
    return [head, columns, *rows, f"{flown}; what was learned: {found.digest}"]
