"""A script that breaks a law is made small, and still breaks it.

Lives, stations, visits, lines and mishaps are taken away, the largest pieces first. What follows
a piece comes when it came before. Then what is left is made simpler: no exercise, no slow disk,
no threads that come in between.
"""

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Final, TypeVar

from simulation.script import Act, Life, Mishap, Part, Player, Script, Visit

MAX_TRIES: Final = 600  # scripts that are played for one
LeavableT = TypeVar("LeavableT", bound=Part)


def shrink(script: Script, breaks: Callable[[Script], bool], tries: int = MAX_TRIES) -> Script:
    """Return the smallest script found in so many tries that ``breaks`` as this one does."""
    played: set[Script] = set()
    while True:
        for candidate in smaller(script):
            if candidate in played:
                continue
            if len(played) == tries:
                return script
            played.add(candidate)
            if breaks(candidate):
                script = candidate
                break
        else:
            return script


def smaller(script: Script) -> Iterator[Script]:
    """Yield scripts that lack a piece of this one, the largest pieces first."""
    lives = script.lives
    for i in range(len(lives)):
        if len(lives) > 1:
            yield replace(script, lives=lives[:i] + lives[i + 1 :])
    for i, life in enumerate(lives):
        for smaller_life in _smaller_lives(life):
            yield replace(script, lives=(*lives[:i], smaller_life, *lives[i + 1 :]))
    if script.fleet:
        yield replace(script, fleet=0)
    if script.duration:
        yield replace(script, duration=0.0)
    if script.exercise and not script.duration:
        yield replace(script, exercise="")
    if script.tokens:
        yield replace(script, tokens=())
    if script.speed != 1.0:
        yield replace(script, speed=1.0)


def _smaller_lives(life: Life) -> Iterator[Life]:
    players = life.players
    for i in range(len(players)):
        yield replace(life, players=players[:i] + players[i + 1 :])
    for mishaps in _without_pieces(life.mishaps):
        yield replace(life, mishaps=mishaps)
    for i, player in enumerate(players):
        for visits in _smaller_visits(player.visits):
            yield replace(
                life,
                players=(
                    *players[:i],
                    Player(player.role, visits, token=player.token),
                    *players[i + 1 :],
                ),
            )
    plain: dict[str, object] = {"interleaving": 0.0, "slow_disk": False, "rest": 0.0, "turns": 1}
    plain |= {"at_answer": False, "instruments": False, "aged": False}
    plain |= {"amidst": False, "narrow": False, "redrawn": ()}
    for name, value in plain.items():
        if getattr(life, name) != value:
            yield replace(life, **{name: value})  # type: ignore[arg-type]


def _smaller_visits(visits: tuple[Visit, ...]) -> Iterator[tuple[Visit, ...]]:
    yield from _without_pieces(visits)
    for i, visit in enumerate(visits):
        for acts in _without_pieces(visit.acts):
            yield (*visits[:i], replace(visit, acts=acts), *visits[i + 1 :])
        for j, act in enumerate(visit.acts):
            if act.pause:
                plain = (*visit.acts[:j], replace(act, pause=0.0), *visit.acts[j + 1 :])
                yield (*visits[:i], replace(visit, acts=plain), *visits[i + 1 :])


def _without_pieces(whole: tuple[LeavableT, ...]) -> Iterator[tuple[LeavableT, ...]]:
    """Yield a sequence without all of it, without each half, each quarter, each one."""
    length = len(whole)
    while length:
        for begin in range(0, len(whole), length):
            end = begin + length
            gone = sum(_time_of(each) for each in whole[begin:end])
            yield (*whole[:begin], *_later(whole[end:], gone))
        length //= 2


def _later(parts: tuple[LeavableT, ...], seconds: float) -> tuple[LeavableT, ...]:
    """Return parts that begin later by some seconds."""
    return (replace(parts[0], after=parts[0].after + seconds), *parts[1:]) if parts else ()


def _time_of(part: Part) -> float:
    """Return how long [s] a part takes of its script."""
    if isinstance(part, Visit):
        return part.after + sum(map(_time_of, part.acts))
    if isinstance(part, Act):
        return part.after + part.pause
    return part.after + (part.seconds if isinstance(part, Mishap) else 0.0)
