"""Operators of a soak: they come, take a role, give random legal orders, and go."""

import contextlib
import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from random import Random
from typing import Final

from soak.audit import Answered
from soak.session_process import Caller, GoneError, SessionProcess
from trainer.boat.world.world import WORLD_PARTS
from trainer.config.boat.casualties import load_casualties
from trainer.io.orders.grammar import MAX_LINE_LETTERS, Order, parse
from trainer.io.orders.quantities import Number
from trainer.io.orders.sentences import order_sentence
from trainer.io.orders.table import (
    FORMS,
    Form,
    Name,
    Slot,
    UnitWord,
    Word,
    heading_word,
    variants,
)
from trainer.io.orders.words import BOAT_ORDERS
from trainer.session.stations.roles import INSTRUCTOR_ROLE, ROLES, Role, refusal

AROUND: Final = {*WORLD_PARTS} - {"scope"}  # orders to what is around the boat
LONGEST_WORDS: Final = MAX_LINE_LETTERS - len(order_sentence("", "999999"))  # [characters]


class Orders:
    """A stream of orders to the boat that a role may give. The same seed says the same."""

    def __init__(self, role: Role, dice: Random) -> None:
        self._role, self._dice = role, dice
        self._casualties = sorted(load_casualties())
        self._forms = [form for form in FORMS if _fits(form, role)]

    def __bool__(self) -> bool:
        """Return whether the role has any."""
        return bool(self._forms)

    def next(self) -> str:
        """Return the words of the next order."""
        while True:
            slots = self._dice.choice(list(variants(self._dice.choice(self._forms))))
            said = self._said(slots)
            order = parse(said)
            given = isinstance(order, Order) and refusal(self._role, order) is None
            if len(said) <= LONGEST_WORDS and given:
                return said

    def _said(self, slots: Sequence[Slot]) -> str:
        return " ".join(self._word(each) for each in slots)

    def _word(self, slot: Slot) -> str:
        if isinstance(slot, Word):
            return self._dice.choice(slot.spellings)[0]
        if isinstance(slot, Number):
            number = self._dice.uniform(slot.low, slot.high)
            return f"{number:.{min(slot.decimals, 2)}f}"
        if isinstance(slot, UnitWord):
            return self._dice.choice(slot.number.units[0].names)
        return self._dice.choice(self._casualties) if isinstance(slot, Name) else "all"


def _fits(form: Form, role: Role) -> bool:
    """Return whether it is an order to the boat, and the role's to give.

    Orders to the world around it are not: each is kept as long as the run, which takes memory.
    """
    name = form.name or heading_word(form)
    return not form.refusal and name in BOAT_ORDERS - AROUND and name in role.commands


VISIT: Final = 5, 60  # orders of one visit
WISHES: Final = 0, 4  # channels asked for
QUARREL: Final = 40  # orders of the instructor, after which he puts the boat to rights
BACK: Final = 1500  # his orders between two times that he goes back
RIGHTS: Final = ("clear all", "release all", "autopilot on", "blow stop", "depth 60", "speed 8")
DEEPEST: Final = 600.0  # [m] below which the boat is taken back: it would stay there for the day
MARKS: Final = 0.1  # [-] of a mark after an order
LOST: Final = "FROZEN: "


@dataclass
class Watchbill:
    """The common part of all operators."""

    session: SessionProcess
    pause: Callable[[Random], float]  # [s] after an order
    over: threading.Event = field(default_factory=threading.Event)
    answered: list[Answered] = field(default_factory=list)
    visits: int = 0
    tick: int = 0  # the latest that the instructor was told
    failures: list[str] = field(default_factory=list)  # of the boat: its numbers were lost
    rescues: int = 0  # times that it was taken back, or held
    lock: threading.Lock = field(default_factory=threading.Lock)

    def give(self, by: Caller, role: str, words: str) -> bool:
        """Give an order to the boat and note that it was answered. Return whether it was obeyed."""
        obeyed, _ = by.ask(words)
        order = parse(words)
        if isinstance(order, Order):
            with self.lock:
                self.answered.append(Answered(f"{role} at {by.name}", order.text))
        return obeyed

    def mark(self, by: Caller, role: str, remark: str) -> None:
        """Mark a moment and note that it was answered."""
        if by.ask(f"mark {remark}")[0]:
            with self.lock:
                self.answered.append(Answered(f"{role} at {by.name}", remark, mark=True))


def attend(bill: Watchbill, seed: int) -> None:
    """Come and go until the session is over."""
    dice = Random(seed)  # noqa: S311  choices, not secrets
    while not bill.over.is_set():
        with contextlib.suppress(GoneError):
            visit(bill, dice)
        bill.over.wait(bill.pause(dice))


def visit(bill: Watchbill, dice: Random) -> None:
    """Come once; GoneError when the session has ended."""
    role = dice.choice([name for name in ROLES if name != "instructor"])
    by = bill.session.caller(role)
    bill.visits += 1
    try:
        for wish in wishes(ROLES[role], dice):
            by.ask(wish)
        orders = Orders(ROLES[role], dice)
        for _ in range(dice.randint(*VISIT)):
            if bill.over.is_set():
                break
            if orders:
                bill.give(by, role, orders.next())
            elif dice.random() < MARKS:
                bill.mark(by, role, f"mark-{dice.randrange(10**9)}")
            bill.over.wait(bill.pause(dice))
        if dice.random() < 0.3:
            by.ask("detach")
    finally:
        dice.choice((by.hang_up, by.cut))()


def wishes(role: Role, dice: Random) -> list[str]:
    """Return what a role asks for: some of its channels, each at a rate."""
    some = min(dice.randint(*WISHES), len(role.channels))
    channels = dice.sample(role.channels, some)
    return [f"subscribe {channel} at {dice.choice((1, 5, 50))} hz" for channel in channels]


def instruct(bill: Watchbill, seed: int, *, goes_back: bool) -> None:
    """Instruct until the session is over: casualties, seas, everything; and put it right again.

    One who does not go back, since time is kept, holds a boat that would be lost where it is.
    """
    dice = Random(seed)  # noqa: S311  choices, not secrets
    orders = Orders(INSTRUCTOR_ROLE, dice)
    given = 0
    with contextlib.ExitStack() as left, contextlib.suppress(GoneError):
        by = bill.session.caller("instructor")
        left.callback(by.hang_up)
        by.ask("subscribe motion at 50 hz")
        while not bill.over.is_set():
            given += 1
            bill.give(by, "instructor", orders.next())
            if dice.random() < MARKS:
                bill.mark(by, "instructor", f"mark-{dice.randrange(10**9)}")
            if given % QUARREL == 0:
                for words in RIGHTS:
                    bill.give(by, "instructor", words)
            if goes_back and given % BACK == 0:
                go_back(by, dice)
            bill.tick = by.tick
            if goes_back:
                recover(bill, by)
            else:
                hold(bill, by)
            bill.over.wait(bill.pause(dice))


def go_back(by: Caller, dice: Random) -> None:
    """Keep this moment, go back a little, and let time go on."""
    by.ask(f"snapshot moment-{dice.randrange(10)}")
    by.ask(f"backtrack {dice.uniform(0.5, 60.0):.1f} s")
    by.ask("run")


def depth(by: Caller) -> float:
    """Return how deep [m] the boat is, by what the line was shown last."""
    return float(by.shown.get("motion", ("", "", "0"))[2])


def hold(bill: Watchbill, by: Caller) -> None:
    """Hold the boat at its depth while it is too deep, and put it right."""
    by.news.clear()
    if depth(by) > DEEPEST:
        bill.rescues += 1
        for words in (*RIGHTS, "freeze depth"):
            bill.give(by, "instructor", words)
        by.shown.clear()


def recover(bill: Watchbill, by: Caller) -> None:
    """Go back to before the boat was lost, or its numbers, and put it right."""
    lost = [news.fields[3] for news in by.news if news.fields[3].startswith(LOST)]
    by.news.clear()
    if lost or depth(by) > DEEPEST:
        bill.failures += lost
        bill.rescues += 1
        by.ask("backtrack 10 min")
        for words in RIGHTS:
            bill.give(by, "instructor", words)
        by.shown.clear()
        by.ask("run")
