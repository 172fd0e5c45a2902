"""The orders that the keys of a screen give."""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Final

from trainer.console.keys import (
    KeyAction,
    MoveAction,
    OrderAction,
    PaceAction,
    PlainAction,
    PumpAction,
)
from trainer.console.model import SessionModel

FORGET_TIME_S: Final = 1.5  # [s] after a key, when a new one begins from what the boat shows again
SURFACE_CHANNELS: Final = {"rudder": "steering", "stern": "diving", "bow": "diving"}
SURFACE_WORDS: Final = {
    "rudder": ("rudder left", "rudder right"),
    "stern": ("stern planes dive", "stern planes rise"),
    "bow": ("bow planes dive", "bow planes rise"),
}
SURFACE_NAMES: Final = {"rudder": "rudder", "stern": "stern planes", "bow": "bow planes"}
PUMP_ORDERS: Final = {  # to the sea or aft, and the other way
    "auxiliary": ("pump auxiliary", "flood auxiliary"),
    "depth_control": ("pump depth-control", "flood depth-control"),
    "trim": ("pump trim aft", "pump trim forward"),
}
TYPED_TIME_S: Final = 1.0  # [s] between letters that a hand types as one order
TIME_SPEEDS: Final = (0.1, 0.2, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0, 100.0)  # of the keys
CONTROL_ACTIONS: Final = (OrderAction, MoveAction, PumpAction)  # of keys that work the boat
# what tells whether something is on, and the orders that switch it on and off
SWITCH_ORDERS: Final[Mapping[KeyAction, tuple[tuple[str, str], str, str]]] = {
    PlainAction.SHOW: (("time", "shown"), "demonstrate", "demonstrate off"),
    PlainAction.GHOST: (("ghost", "depth"), "ghost on", "ghost off"),
    PlainAction.PREDICT: (("predictor", "depth"), "predictor 60 s", "predictor off"),
}


class TypedKeys:
    """The letters and digits that have just moved controls, perhaps meant as words."""

    def __init__(self, clock: Callable[[], float]) -> None:
        self._clock = clock
        self._letters, self._last = "", -math.inf

    def take(self, letter: str | None, act: KeyAction) -> None:
        """Take a key that has acted."""
        if letter and letter.isalnum() and isinstance(act, CONTROL_ACTIONS):
            self._letters, self._last = f"{self._fresh()}{letter}", self._clock()

    def explain_lost(self) -> str:
        """Return the hint to begin with a colon, "" where no letter is missed."""
        lost, self._letters = self._fresh(), ""
        return f'begin an order with : because "{lost}" was taken as keys' if lost else ""

    def _fresh(self) -> str:
        return self._letters if self._clock() - self._last < TYPED_TIME_S else ""


class KeyOrders:
    """The orders by keys of one screen.

    A key adds to the last order and not to what the boat shows, because several presses come before
    the boat has answered the first.
    """

    def __init__(self, model: SessionModel) -> None:
        self._model = model
        # the last orders by keys to surfaces [deg] and pumps [t], and their times
        self._asked: dict[str, tuple[float, float]] = {}
        self._refused = 0

    def make(self, act: KeyAction) -> str:
        """Return the order of a key, "" for a key that gives none."""
        picture, words = self._model.picture, ""
        match act:
            case OrderAction(given):
                words = given
            case PlainAction.TOGGLE:
                words = "run" if picture.frozen else "freeze"
            case PaceAction(steps):
                words = f"time {nearest_step(TIME_SPEEDS, picture.pace, steps):g}"
            case MoveAction(surface, by):
                words = self._move(surface, by)
            case PumpAction(tank, tonnes):
                words = self._pump(tank, tonnes)
            case PlainAction.REPEAT if self._model.crew.to_repeat(self._model.role):
                words = "aye"
            case PlainAction() if act in SWITCH_ORDERS:
                (channel, name), *orders = SWITCH_ORDERS[act]
                words = orders[picture.word(channel, name) not in ("", "no")]
            case PlainAction.AGAIN if picture.word("time", "replay") == "yes":
                words = "take over"
        return words

    def why_idle(self, act: MoveAction | PumpAction) -> str:
        """Return why a control's key does nothing: no such thing, or no figure of it."""
        channel = "tanks" if isinstance(act, PumpAction) else SURFACE_CHANNELS[act.surface]
        name = act.tank if isinstance(act, PumpAction) else SURFACE_NAMES[act.surface]
        name = f"{name.replace('_', ' ')} tank" if isinstance(act, PumpAction) else name
        if channel in self._model.picture.last and self._model.joined:
            return f"this boat has no {name}"
        return f"not ready: the {name}; its panel has shown nothing yet"

    def _move(self, surface: str, by: int) -> str:
        """Return the order that moves a surface ``by`` degrees, "" where the boat has none."""
        model = self._model
        shown = model.picture.number(SURFACE_CHANNELS[surface], f"ordered_{surface}")
        if shown is None:
            return ""
        # An order was refused, most likely for its limit: begin again from what the boat shows.
        if model.sent.refused != self._refused:
            self._refused = model.sent.refused
            self._asked.clear()
        most = model.vessel.ranges.get(surface, math.inf)
        wanted = min(max(round(self._last(surface, shown)) + by, -most), most)
        self._asked[surface] = wanted, model.clock()
        return f"{SURFACE_WORDS[surface][wanted > 0]} {abs(wanted):g}"

    def _pump(self, tank: str, by: float) -> str:
        """Return the order that moves ``by`` tonnes more than are still to go."""
        remaining = self._model.picture.number("tanks", f"moving_{tank}")
        if remaining is None:
            return ""
        wanted = round(self._last(tank, remaining) + by, 1)
        self._asked[tank] = wanted, self._model.clock()
        return f"{PUMP_ORDERS[tank][wanted > 0]} {abs(wanted):g}"

    def _last(self, what: str, shown: float) -> float:
        """Return the last value that keys ordered, or after a while what the boat shows."""
        value, when = self._asked.get(what, (shown, -math.inf))
        return value if self._model.clock() - when < FORGET_TIME_S else shown


def nearest_step(steps: Sequence[float], value: float, by: int) -> float:
    """Return the step that is ``by`` steps on from the one nearest to a value."""
    nearest = min(range(len(steps)), key=lambda i: abs(steps[i] - value))
    return steps[min(max(nearest + by, 0), len(steps) - 1)]
