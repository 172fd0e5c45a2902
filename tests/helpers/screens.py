"""Screens under test: a session that says what it is told to, and a console without a terminal."""

import asyncio
import itertools
import time
from collections.abc import Awaitable, Callable, Coroutine
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from typing import Any, TypeVar

from textual.pilot import Pilot

from trainer.console.app import Console
from trainer.console.client import Greeting, Item, RoleTaken
from trainer.console.layouts import LAYOUTS
from trainer.console.model import SessionModel
from trainer.console.pane import Pane, plain
from trainer.io.orders import sentences
from trainer.io.orders.grammar import Refused
from trainer.io.orders.sentences import parse_sentence
from trainer.session.stations.channels import CHANNELS

PATIENCE = 60.0  # [s]
CREW = ("helm", "planes", "pilot", "ballast", "diving", "observer")
VALUES = {
    "depth": "60.0", "heading": "359.5", "speed": "10.0", "pitch": "-2.0", "heel": "1.0",
    "depth_rate": "0.5", "turn_rate": "1.0", "speed_rate": "0.0", "pitch_rate": "0.0",
    "heel_rate": "0.0", "ordered_depth": "80.0", "ordered_course": "90.0", "rudder": "5.0",
    "ordered_rudder": "5.0", "rudder_mode": "auto", "stern": "-3.0", "ordered_stern": "-3.0",
    "stern_mode": "auto", "bow": "0.0", "ordered_bow": "0.0", "bow_mode": "hand",
    "rpm": "71", "ordered_rpm": "71", "bell": "ahead-standard", "speed_mode": "hand",
    "time": "running", "branch": "1", "replay": "no", "auxiliary": "30.8", "auxiliary_full": "50",
    "forward": "184", "forward_full": "100", "main": "25.0", "main_full": "100",
    "emergency": "25.0", "emergency_full": "100", "compressor": "off", "blow_forward": "open",
    "moving_auxiliary": "0.0", "moving_depth_control": "0.0", "moving_trim": "0.0",
    "height": "1.9", "period": "7.0", "from": "0", "heavy": "2.0", "ticks": "120",
}  # fmt: skip


def values(channel: str, **changed: str) -> list[str]:
    """Return a line of values for a channel, as a session would send them."""
    own = {"time": VALUES | {"speed": "1"}, "orders": {}}  # nothing is ordered unless a test does
    told = own.get(channel, VALUES) | changed
    return [told.get(each.name, "") for each in CHANNELS[channel].fields]


def names(channel: str) -> str:
    return sentences.names(channel, [(each.name, each.unit) for each in CHANNELS[channel].fields])


class Speaker:
    """What a session says on a line, once a console takes it."""

    items: list[Item]

    def say(self, *lines: str) -> None:
        for text in lines:
            sentence = parse_sentence(text)
            assert sentence, text
            self.items.append(sentence)

    def take(self) -> list[Item]:
        taken, self.items = self.items, []
        return taken


class ScriptedLine(Speaker):
    """A line that says what a test has it say, and keeps what is ordered."""

    def __init__(self, *facts: tuple[str, str, str]) -> None:
        self.items = [RoleTaken()]
        for seconds, what, subject in facts:
            self.say(sentences.fact(1, float(seconds), what, subject))
        self.orders: list[str] = []

    def order(self, words: str) -> str:
        self.orders.append(words)
        return str(len(self.orders))


@dataclass
class Tape(Speaker):
    """A session that says what it is told to, and takes every order but those of ``refuses``."""

    channels: tuple[str, ...]
    given: list[str] = field(default_factory=list)
    items: list[Item] = field(default_factory=list)
    answers: dict[str, list[str]] = field(default_factory=dict)
    facts: dict[str, list[tuple[str, str]]] = field(default_factory=dict)  # before an answer
    refuses: frozenset[str] = frozenset()
    connected: bool = True

    def __post_init__(self) -> None:
        self._tags = itertools.count(10)
        self.items = [Greeting("Periscope depth"), RoleTaken()]
        self.say(*(names(channel) for channel in self.channels))
        self.tick(120)

    def tick(self, tick: int, **changed: str) -> None:
        for channel in self.channels:
            if channel == "orders":  # none, unless a test says so
                continue
            self.say(sentences.state(channel, tick, tick / 2.0, values(channel, **changed)))

    def order(self, words: str) -> str:
        if not self.connected:
            return ""
        self.given.append(words)
        tag = str(next(self._tags))
        self.say(*(sentences.say(tag, text) for text in self.answers.get(words, [])))
        self.say(*(sentences.fact(0, 0.0, *fact) for fact in self.facts.get(words, [])))
        accepted = words not in self.refuses
        text = f"{words}: done" if accepted else "beyond the limit of 30"
        self.say(sentences.answer(tag, accepted=accepted, text=text))
        return tag

    @property
    def orders(self) -> list[str]:
        """Return what was ordered, without what a console asks by itself."""
        own = ("snapshots", "casualties", "history")
        return [words for words in self.given if words.split()[0] not in own]


def tape(role: str = "instructor") -> Tape:
    found = Tape(LAYOUTS[role].channels)
    found.facts["casualties"] = [
        ("casualty", "stern-stuck,,The stern planes stay where they are"),
        ("casualty", "stern-hard-over,-1 ramp 0,The stern planes run to this angle and jam"),
        ("casualty", "flooding-aft,1 ramp 5,The sea enters the aft compartment"),
    ]
    return found


def sight_of(talk: Tape, role: str = "instructor", clock: float = 100.0) -> SessionModel:
    return SessionModel(talk, role, LAYOUTS[role].charts, clock=lambda: clock)


Done = TypeVar("Done")
Act = Callable[[Pilot[Refused], Console], Awaitable[None]]


def run_aside(work: Coroutine[Any, Any, Done]) -> Done:
    """Run in a thread of its own: a browser of this process has a loop in the main one."""
    with ThreadPoolExecutor(1) as aside:
        return aside.submit(asyncio.run, work).result()


def at_the_console(
    act: Act, talk: Tape | None = None, role: str = "instructor", size: tuple[int, int] = (80, 24)
) -> tuple[Console, Tape]:
    """Do something at a console; return it as it was left."""
    talk = talk or tape(role)
    app = Console(sight_of(talk, role))

    async def run() -> None:
        async with app.run_test(size=size) as pilot:
            while not app.model.joined or (app.model.instructs and not app.model.vessel.casualties):
                await pilot.pause(0.02)
            await act(pilot, app)

    run_aside(run())
    return app, talk


def shown(app: Console) -> str:
    """Return the text of every drawing that is on the screen."""
    return "\n".join(plain(p.lines) for p in app.screen.query(Pane) if p.display and p.size.height)


async def settled(pilot: Pilot[Refused], wrong: Callable[[], str]) -> None:
    """Wait until nothing is wrong any more with what is drawn."""
    end = time.monotonic() + PATIENCE
    while told := wrong():
        assert time.monotonic() < end, told
        await pilot.pause(0.02)


async def seen(pilot: Pilot[Refused], app: Console, text: str) -> None:
    """Wait until a text is on the screen."""
    lacking = f"{text!r} is not shown"
    await settled(pilot, lambda: "" if text in shown(app) else f"{lacking}:\n{shown(app)}")


def pressed(keys: tuple[str, ...], role: str = "instructor", talk: Tape | None = None) -> list[str]:
    """Return what is ordered by pressing keys."""

    async def press(pilot: Pilot[Refused], _app: Console) -> None:
        for key in keys:
            await pilot.press(key)

    return at_the_console(press, talk, role)[1].orders


def typed(text: str) -> tuple[str, ...]:
    special = {" ": "space", "-": "minus", ".": "full_stop"}
    return tuple(special.get(character, character) for character in text)
