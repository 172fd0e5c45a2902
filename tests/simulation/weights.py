"""How often each action is drawn follows from what seeds reached.

``python -m tests.simulation --weigh`` plays seeds and writes ``weights.toml``, which ``drawing``
reads. It goes by the cross-entropy method (R. Y. Rubinstein, *Methodology and Computing in Applied
Probability* 1, 1999): an action comes more often that has a larger share of the seeds which reached
a rare milestone than of all seeds.
"""

import tomllib
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Final, NamedTuple

from simulation.disk import Trouble
from simulation.script import Ending, Script
from simulation.vocabulary import CHOICES, EXERCISES, SCENES

WEIGHTS_PATH: Final = Path(__file__).with_name("weights.toml")
EVIDENCE: Final = 10.0  # seeds that reach a milestone count as much as this prior (estimate)
MOST_CHANGE: Final = 4.0  # [-] of a weight from what people gave it (estimate)
HEAD: Final = """# How often each action is drawn, and what seeds reached with the weights before.
# Written by `python -m tests.simulation --weigh`; not to be edited.
"""

Weights = dict[str, dict[str, float]]  # of each kind of action, by its words


def given_weights() -> Weights:
    """Return the weights that people gave: what stands more than once weighs more."""
    kinds: dict[str, Sequence[str]] = {
        **CHOICES,
        "scenes": SCENES,
        "exercises": EXERCISES,
        "mishaps": (*(t.value for t in Trouble), Trouble.LOCKED.value, Trouble.UNREADABLE.value),
        "endings": [e.value for e in (*(2 * [Ending.KILLED, Ending.SIGNAL]), Ending.POWER)],
    }
    return {
        kind: {word: float(n) for word, n in Counter(words).items()}
        for kind, words in kinds.items()
    }


class Sample(NamedTuple):
    """What one seed did, and what it reached."""

    done: Mapping[str, Counter[str]]  # actions of each kind
    reached: frozenset[str]


def actions_of(script: Script, lives: int) -> dict[str, Counter[str]]:
    """Return how often each action is in so many first processes of a script."""
    done: dict[str, Counter[str]] = {"exercises": Counter([script.exercise])}
    for kind in (*CHOICES, "scenes", "mishaps", "endings"):
        done[kind] = Counter()
    for life in script.lives[:lives]:
        done["endings"][life.ending.value] += 1
        done["mishaps"].update(each.trouble.value for each in life.mishaps)
        for player in life.players:
            for visit in player.visits:
                said = [act.words for act in visit.acts if not act.noise]
                done[player.role].update(said)
                row = "|".join(["", *said, ""])
                done["scenes"].update({s: row.count(f"|{s}|") for s in SCENES if f"|{s}|" in row})
    return done


def weigh(samples: Sequence[Sample], before: Weights) -> Weights:
    """Return the weights that follow from what samples reached, drawn with those before."""
    counts = Counter(name for sample in samples for name in sample.reached)
    rarity = {name: 1.0 / (1.0 + count) for name, count in counts.items()}
    whole = sum(rarity.values())
    after = {}
    for kind, first in given_weights().items():
        shares = [_shares(sample.done.get(kind, Counter()), first) for sample in samples]
        mean = {word: sum(s.get(word, 0.0) for s in shares) / len(shares) for word in first}
        lift = dict.fromkeys(first, 0.0)
        for name, rare in rarity.items():
            those = [s for s, sample in zip(shares, samples, strict=True) if name in sample.reached]
            for word in first:
                there = sum(s.get(word, 0.0) for s in those) + EVIDENCE * mean[word]
                plain = (len(those) + EVIDENCE) * mean[word]
                lift[word] += rare * (there / plain if plain else 1.0) / whole
        after[kind] = {
            word: min(
                max(before.get(kind, first).get(word, given) * lift[word], given / MOST_CHANGE),
                given * MOST_CHANGE,
            )
            for word, given in first.items()
        }
    return after


def _shares(done: Counter[str], among: Mapping[str, float]) -> dict[str, float]:
    total = sum(done[word] for word in among)
    return {word: done[word] / total for word in among if done[word]} if total else {}


def write_weights(weights: Weights, reached: Mapping[str, int], seeds: int) -> None:
    """Write weights, and the table from which they follow."""
    WEIGHTS_PATH.write_text("\n".join(_lines(weights, reached, seeds)) + "\n", encoding="utf-8")


def _lines(weights: Weights, reached: Mapping[str, int], seeds: int) -> Iterator[str]:
    yield HEAD + f"\nseeds = {seeds}"
    tables: Mapping[str, Mapping[str, float]] = {"reached": reached, **weights}
    for kind, rows in tables.items():
        yield f"\n[{kind}]"
        yield from (f'"{word}" = {round(number, 3):g}' for word, number in rows.items())


def read_weights() -> Weights:
    """Return the weights of ``weights.toml``; those that people gave for actions it has not."""
    table = _table()
    return {
        kind: {word: table.get(kind, {}).get(word, weight) for word, weight in words.items()}
        for kind, words in given_weights().items()
    }


def find_unweighed() -> list[str]:
    """Return the actions that only one of ``weights.toml`` and the vocabulary has."""
    table = _table()
    return [
        f"{kind}: {word}"
        for kind, words in given_weights().items()
        for word in sorted(words.keys() ^ table.get(kind, {}).keys())
    ]


def _table() -> dict[str, Any]:
    return tomllib.loads(WEIGHTS_PATH.read_text(encoding="utf-8")) if WEIGHTS_PATH.exists() else {}
