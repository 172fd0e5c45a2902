"""A seed draws what happens to a class of three boats: orders, jumps, replays, kills."""

from dataclasses import dataclass
from random import Random
from typing import Final

BOATS: Final = (1, 2, 3)
SPACINGS_M: Final = (0.0, 120.0, 280.0, 320.0, 1000.0)  # about PARTED_M, and far
SPEEDS: Final = (1.0, 4.0)  # of all boats at once
KILLS: Final = (0, 0, 1, 1, 2)  # of a boat
RESTS_S: Final = (0.2, 1.0, 3.0, 8.0)  # until it is begun again
LIVE_S: Final = 25.0  # in which all is said
PACES_S: Final = (0.1, 0.5, 1.5, 4.0)  # from word to word
# What an instructor says; the parts of a scene come one after another.
SCENES: Final = (
    *("course {course}", "course {course}", "depth {depth}", "speed {speed}"),
    *("freeze|run", "freeze|freeze|run", "mark {mark}", "mark {mark}"),
    *("snapshot A", "snapshot A", "restore A|run", "restore A|run", "backtrack 10 s|run"),
    *("reset|run", "replay 5 s|run", "replay 10 s|run|run", "replay 5 s|run|freeze|run"),
    *("time x2|{pace}", "time x8|{pace}"),
)


@dataclass(frozen=True)
class Said:
    """An instructor's words, and how long [s] after those before."""

    after: float
    words: str


@dataclass(frozen=True)
class Kill:
    """The end of a boat's process, and how long [s] after it the next begins."""

    at: float  # [s] from the beginning
    boat: int
    rest: float


@dataclass(frozen=True)
class ClassScript:
    """All that happens to a class."""

    seed: int
    spacing: float  # [m]
    speed: float  # of time, in all boats
    says: dict[int, tuple[Said, ...]]  # by boat
    kills: tuple[Kill, ...]  # one after another


def draw_class(seed: int) -> ClassScript:
    """Return the script of a seed."""
    dice = Random(f"{seed}/class")  # noqa: S311  no secrets
    speed = dice.choice(SPEEDS)
    says = {boat: tuple(_draw_says(dice, boat, speed)) for boat in BOATS}
    kills = [
        Kill(dice.uniform(2.0, LIVE_S), boat, dice.choice(RESTS_S))
        for boat in BOATS
        for _ in range(dice.choice(KILLS))
    ]
    kills.sort(key=lambda kill: kill.at)
    return ClassScript(seed, dice.choice(SPACINGS_M), speed, says, tuple(kills))


def _draw_says(dice: Random, boat: int, speed: float) -> list[Said]:
    said: list[Said] = [Said(0.0, f"course {dice.randrange(360):03}")]
    seconds = 0.0
    while seconds < LIVE_S:
        scene = dice.choice(SCENES).format(
            course=f"{dice.randrange(360):03}",
            depth=dice.randrange(30, 90),
            speed=dice.randrange(3, 13),
            mark=mark_of(boat, len(said)),
            pace=f"time x{speed:g}",
        )
        for words in scene.split("|"):
            said.append(Said(dice.expovariate(1.0 / dice.choice(PACES_S)), words))
            seconds += said[-1].after
    return said


def mark_of(boat: int, number: int) -> str:
    """Return words that only this boat says."""
    return f"of-boat-{boat}-{number}"
