"""The screen of one role in a terminal, as a Textual application.

It shows the drawings of the role's layout (``layouts``), takes keys (``keys``) and typed orders
(``entry``), and opens dialogs. All that it knows of the session is in ``model``; what has
changed is drawn ten times a second.
"""

import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import ClassVar, Final

from textual import events
from textual.app import App, ComposeResult
from textual.binding import BindingType
from textual.containers import Horizontal, Vertical
from textual.css.query import NoMatches
from textual.screen import Screen

from trainer.console.crew import CrewOrder
from trainer.console.dialogs import (
    Dialog,
    DialogOutcome,
    DialogSubject,
    blow_question,
    casualty_choice,
    leave_question,
    sea_choice,
)
from trainer.console.drawing.chart import strip
from trainer.console.drawing.evaluation import evaluation
from trainer.console.drawing.event_log import log, time_at, time_line
from trainer.console.drawing.panels import flowed, foot, key_at, top
from trainer.console.entry import Entry, OrderNames, hint
from trainer.console.guide import EndView, PlanView, TextView, answer, briefing, guide
from trainer.console.keys import (
    KEYS,
    DialogAction,
    KeyAction,
    MoveAction,
    OrderAction,
    PaceAction,
    PlainAction,
    PumpAction,
    ScrollAction,
    SpanAction,
    TypingAction,
    by_name,
    footer,
)
from trainer.console.layouts import LAYOUTS, Place
from trainer.console.model import SessionModel
from trainer.console.pane import Lines, Pane, fit, line
from trainer.console.timeline import TimelineView
from trainer.io.orders.grammar import Refused

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
MAX_KEY_ROWS: Final = 3  # [rows] of keys at most
REFRESH_RATE_HZ: Final = 10.0  # [Hz] of drawing what has changed
FIRST_POLL_S: Final = 0.004  # [s] between looks for the first figures
FUNCTION_KEY_PATTERN: Final = re.compile(r"f\d+|ctrl\+[cgt]")  # keys that are no part of an order
CHART_SPANS_S: Final = (60.0, 120.0, 300.0, 600.0, 1200.0)  # [s] of the charts
TIME_SPEEDS: Final = (0.1, 0.2, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0, 100.0)  # of the keys
ROLE_PROMPTS: Final = {
    "instructor": "type an order, such as depth 80; F1 shows help",
    "trainee": "keys move your controls; or type an order, and Enter",
}
DEFAULT_PROMPT: Final = "keys move your controls; Enter to type an order"
# what tells whether something is on, and the orders that switch it on and off
SWITCHES: Final[Mapping[KeyAction, tuple[tuple[str, str], str, str]]] = {
    PlainAction.SHOW: (("time", "shown"), "demonstrate", "demonstrate off"),
    PlainAction.GHOST: (("ghost", "depth"), "ghost on", "ghost off"),
    PlainAction.PREDICT: (("predictor", "depth"), "predictor 60 s", "predictor off"),
}
DIALOG_SUBJECTS: Final[Mapping[str, Callable[[SessionModel], DialogSubject]]] = {
    "help": guide,
    "briefing": briefing,
    "casualties": casualty_choice,
    "sea": sea_choice,
    "moments": lambda model: TimelineView(model, replays=False),
    "plan": PlanView,
    "emergency": lambda _model: blow_question(),
}


@dataclass
class Levers:
    """The last orders by keys to surfaces [deg] and pumps [t], and their times.

    A key adds to the last order and not to what the boat shows, because several presses come before
    the boat has answered the first.
    """

    asked: dict[str, tuple[float, float]] = field(default_factory=dict)
    refused: int = 0

    def move(self, surface: str, by: int, model: SessionModel) -> str:
        """Return the order that moves a surface ``by`` degrees, "" where the boat has none."""
        shown = model.picture.number(SURFACE_CHANNELS[surface], f"ordered_{surface}")
        if shown is None:
            return ""
        # An order was refused, most likely for its limit: begin again from what the boat shows.
        if model.refused != self.refused:
            self.refused = model.refused
            self.asked.clear()
        most = model.vessel.ranges.get(surface, math.inf)
        wanted = min(max(round(self._last(surface, shown, model.clock())) + by, -most), most)
        self.asked[surface] = wanted, model.clock()
        return f"{SURFACE_WORDS[surface][wanted > 0]} {abs(wanted):g}"

    def pump(self, tank: str, by: float, model: SessionModel) -> str:
        """Return the order that moves ``by`` tonnes more than are still to go."""
        remaining = model.picture.number("tanks", f"moving_{tank}")
        if remaining is None:
            return ""
        wanted = round(self._last(tank, remaining, model.clock()) + by, 1)
        self.asked[tank] = wanted, model.clock()
        return f"{PUMP_ORDERS[tank][wanted > 0]} {abs(wanted):g}"

    def _last(self, what: str, shown: float, now: float) -> float:
        """Return the last value that keys ordered, or after a while what the boat shows."""
        value, when = self.asked.get(what, (shown, -math.inf))
        return value if now - when < FORGET_TIME_S else shown


class Console(App[Refused], inherit_bindings=False):
    """The screen of one station. It ends with the session's refusal of the role, if any."""

    CSS_PATH = "console.tcss"
    TITLE = "trainer"
    ENABLE_COMMAND_PALETTE = False
    AUTO_FOCUS = ""  # a station's keys are its controls
    HORIZONTAL_BREAKPOINTS = [  # noqa: RUF012  as the library has it
        (0, "-tiny"),
        (60, "-narrow"),
        (126, "-wide"),
    ]
    VERTICAL_BREAKPOINTS = [  # noqa: RUF012
        (0, "-flat"),
        (20, "-low"),
        (36, "-tall"),
        (50, "-high"),
    ]
    # None of the library's: its Ctrl-Q would end the console, but users press Ctrl-Q to wake a
    # terminal that Ctrl-S has stopped.
    BINDINGS: ClassVar[list[BindingType]] = []

    def __init__(self, model: SessionModel, *, own: bool = False) -> None:
        """Show ``model``. A session that is the console's ``own`` ends with it."""
        super().__init__()
        self.model = model
        self.own = own
        self.span = 1  # of CHART_SPANS_S
        self._post = LAYOUTS[model.role]
        self._keys = by_name(model.role)
        self._levers = Levers()
        self._names = OrderNames(model)
        self._seen: tuple[object, ...] = ()
        self._rung = model.bells
        self._silent = self._mounted = False
        self._early: list[events.Key] = []  # typed before there is a line to type them into
        self._ended, self._released = model.exercise.endings, model.exercise.releases
        self._foot = footer(model.role)
        self._briefed = ""  # the exercise whose briefing was shown

    def get_default_screen(self) -> Screen[None]:
        """Return a screen that has the role's style from its first drawing."""
        return Screen(id="_default", classes=self.model.role)

    def compose(self) -> ComposeResult:
        """Lay the drawings out; the style sheet says which are shown at which size."""
        yield Pane(partial(top, self.model), "top", moving=True)
        yield Horizontal(*map(self._pane, self._post.upper), id="upper")
        if self._post.lower:
            yield Horizontal(*map(self._pane, self._post.lower), id="lower")
        yield Horizontal(*self._charts(range(3)), id="first", classes="charts")
        if len(self._post.charts) > 3:
            yield Horizontal(*self._charts(range(3, 6)), id="second", classes="charts")
        with Horizontal(id="record"):
            yield Pane(partial(log, self.model), "log", wheel=self._scroll)
            if self._post.aside:
                yield Vertical(*map(self._pane, self._post.aside), id="aside")
        if self.model.instructs:
            yield Pane(partial(evaluation, self.model), "evaluation")
        yield Pane(self._line, "line", moving=True, click=self._travel)
        prompt = ROLE_PROMPTS.get(self.model.role, DEFAULT_PROMPT)
        yield Entry(self._names, self._quick(), prompt, self._submit)
        yield Pane(partial(foot, self._foot), "foot", click=self._press)

    async def on_mount(self) -> None:
        """Start the timers, and take keys that came before the instructor's line was there."""
        self.model.hear()  # what has come by now is in the first drawing
        self._mounted = True
        self._expecting = self.set_interval(FIRST_POLL_S, self._expect)
        self.set_interval(1.0 / REFRESH_RATE_HZ, self._look)
        self.set_focus(self.query_one(Entry) if self.model.instructs else None)
        for event in self._early:
            await super().on_event(event)

    async def on_event(self, event: events.Event) -> None:
        """Act on a control's key at once, so that keys right after a colon count as typed."""
        if isinstance(event, events.Key) and not self._mounted and self.model.instructs:
            self._early.append(event)
            return
        if isinstance(event, events.Key) and not event.is_forwarded and self._gives_way(event):
            self.pop_screen()  # now, or keys right behind it would still be the window's
            self.query_one(Entry).begin(event.character or "")
            return
        if isinstance(event, events.Key) and not event.is_forwarded and self._at_controls:
            key = self._keys.get(event.key)
            if key is not None:
                self.act(key.act)
                return
            if event.character and event.character.isalpha():  # no key, so it begins an order
                self.query_one(Entry).begin(event.character)
                return
        await super().on_event(event)

    def _gives_way(self, event: events.Key) -> bool:
        """Return whether a letter begins an order, and so closes the window with an answer."""
        above = self.screen_stack[-1]
        view = above.subject if isinstance(above, Dialog) else None
        return isinstance(view, TextView) and view.typing and (event.character or "").isalpha()

    def on_key(self, event: events.Key) -> None:
        """Act on a key, unless a dialog or a half-typed order takes it.

        An instructor's line is always open, so that only its function keys act.
        """
        if len(self.screen_stack) > 1:
            return
        if (self.focused is not None) is not self.model.instructs:
            if event.key == "escape":
                self.set_focus(None)
            if not FUNCTION_KEY_PATTERN.fullmatch(event.key):
                return
        key = self._keys.get(event.key)
        if key is not None:
            event.stop()
            event.prevent_default()
            self.act(key.act)

    def _submit(self, typed: str) -> None:
        """Send what has been typed."""
        words = typed or self._repeat()
        if not self.model.instructs:
            self.set_focus(None)
        if words in ("detach", "bye"):
            self.exit()
        elif words:
            self.model.order(words)
            self._look()

    def act(self, act: KeyAction) -> None:
        """Carry out the action of a key."""
        words = self._ordered(act)
        self._give(act, words)
        match act:
            case PlainAction.AGAIN if not words:
                self._open(TimelineView(self.model, replays=True))
            case DialogAction(dialog):
                before = self.model.crew.to_repeat(self.model.role)
                self._open(
                    DIALOG_SUBJECTS[dialog](self.model), partial(self._ordered_since, before)
                )
            case TypingAction(text):
                self.query_one(Entry).begin(text)
            case PlainAction.REPEAT if not words:
                self.query_one(Entry).begin("")
            case PlainAction.RING:
                self._silent = not self._silent
                said = "off" if self._silent else "on"
                self.model.journal.add(None, "station", f"the bell is {said}")
            case SpanAction(steps):
                self.span = min(max(self.span + steps, 0), len(CHART_SPANS_S) - 1)
            case ScrollAction(lines):
                self.model.journal.look_back(lines)
            case PlainAction.LEAVE:
                self._leave()
        self._look()

    def _give(self, act: KeyAction, words: str) -> None:
        """Send the order of a key, or show why a control's key does nothing."""
        if words:
            self.model.order(words)
        elif isinstance(act, MoveAction | PumpAction):
            self.model.journal.add(None, "refused", idle_reason(act, self.model))

    def _ordered(self, act: KeyAction) -> str:
        """Return the order of a key, "" for a key that gives none."""
        picture, words = self.model.picture, ""
        match act:
            case OrderAction(given):
                words = given
            case PlainAction.TOGGLE:
                words = "run" if picture.frozen else "freeze"
            case PaceAction(steps):
                words = f"time {nearest_step(TIME_SPEEDS, picture.pace, steps):g}"
            case MoveAction(surface, by):
                words = self._levers.move(surface, by, self.model)
            case PumpAction(tank, tonnes):
                words = self._levers.pump(tank, tonnes, self.model)
            case PlainAction.REPEAT:
                words = self._repeat()
            case PlainAction() if act in SWITCHES:
                (channel, name), *orders = SWITCHES[act]
                words = orders[picture.word(channel, name) not in ("", "no")]
            case PlainAction.AGAIN if picture.word("time", "replay") == "yes":
                words = "take over"
        return words

    def _repeat(self) -> str:
        """Return ``aye`` if this role has a new order to repeat, else ""."""
        return "aye" if self.model.crew.to_repeat(self.model.role) else ""

    # the mouse

    def _press(self, column: int, row: int) -> None:
        """Act on the key that is drawn at a place. Each key of a pair has its own half."""
        pane = self.screen_stack[0].query_one("#foot", Pane)
        label, drawn = key_at(self._foot, pane.size.width, pane.size.height, (column, row))
        other, pair, _ = drawn.partition(":")
        wanted = other if pair else label  # of "0 to 8: bells" the words are no key
        for key in KEYS[self.model.role]:
            if wanted and key.label == wanted:
                self.act(key.act)
                return

    def _travel(self, column: int, _row: int) -> None:
        """Open the dialog of the time line at the place of a click."""
        if self.model.instructs:
            width = self.screen_stack[0].query_one("#line", Pane).size.width
            back = self.model.picture.seconds - time_at(self.model, width, column)
            self._open(TimelineView(self.model, replays=False, lapse=max(back, 0.5)))

    def _scroll(self, lines: int) -> None:
        self.act(ScrollAction(-lines))

    # looking

    def on_resize(self, event: events.Resize) -> None:
        """Give the footer the rows that its keys need."""
        rows = len(flowed(self._foot, event.size.width))
        self.screen_stack[0].query_one("#foot").styles.height = min(rows, MAX_KEY_ROWS)

    def _expect(self) -> None:
        """Show the first values as soon as they come."""
        self.model.hear()
        if self.model.picture.changes:
            self._expecting.stop()
            self._look()

    def _look(self) -> None:
        """Take what the session has sent, and draw what has changed."""
        model = self.model
        model.hear()
        if not self.screen_stack:  # it is being closed
            return
        if model.barred or model.chair or (model.over and model.ended):
            self.exit(model.barred)
            return
        seen = (model.picture.changes, model.journal.changes, model.joined, model.over, self.span)
        changed, self._seen = seen != self._seen, seen
        self._announce()
        if isinstance(self.screen, Dialog):
            self.screen.leave_if_past()
        for pane in self.screen.query(Pane):
            if changed or pane.moving:
                pane.look()
        if len(self.screen_stack) > 1 and changed:
            for pane in self.screen_stack[0].query(Pane):
                pane.look()

    def _announce(self) -> None:
        """Ring the bell for news, and open windows for the end, the marks and long answers."""
        due, self._rung = self.model.bells > self._rung, self.model.bells
        if due and not self._silent:
            self.bell()
        if self.model.exercise.endings > self._ended and not self._typing:
            self._ended = self.model.exercise.endings
            if self.model.instructs or self.model.trains:
                self._open(EndView(self.model), lambda: not self.model.exercise.outcome)
        self._lead_in()
        before, self._released = self._released, self.model.exercise.releases
        if self._released > before and not self.model.instructs and len(self.screen_stack) == 1:
            self._open(briefing(self.model), lambda: not self.model.exercise.outcome)
        while self.model.answers and len(self.screen_stack) == 1:
            self._open(answer(*self.model.answers.pop(0)))

    def _lead_in(self) -> None:
        """Show who trains the briefing before time runs; give what comes and goes its room."""
        model, exercise, timeline = self.model, self.model.exercise, self.model.timeline
        evaluated = bool(timeline.attainable or timeline.unevaluated) and not exercise.outcome
        self.screen_stack[0].set_class(evaluated, "evaluated")
        if not model.trains:
            return
        self.screen_stack[0].set_class(bool(exercise.step.text), "lesson")
        self.screen_stack[0].set_class("ballast" in exercise.by_hand, "tanks")
        title = exercise.values.get("title", "") if model.joined else ""
        begins = model.picture.frozen and not model.picture.seconds and len(self.screen_stack) == 1
        if title and title != self._briefed and begins:
            self._briefed = title
            self._open(briefing(model), lambda: not model.picture.frozen)

    def _ordered_since(self, before: CrewOrder | None) -> bool:
        """Return whether an order has come since that a window would hide."""
        new = self.model.crew.to_repeat(self.model.role)
        return not self.model.instructs and new is not None and new != before

    @property
    def _at_controls(self) -> bool:
        """Return whether keys move controls, because no order is typed and no dialog open."""
        free = len(self.screen_stack) == 1 and self.focused is None
        return self._mounted and not self.model.instructs and free

    @property
    def _typing(self) -> bool:
        """Return whether an order has been begun."""
        return bool(self.screen_stack[0].query_one(Entry).value)

    def _pane(self, place: Place) -> Pane:
        return Pane(partial(place.draw, self.model), place.name, moving=place.moving)

    def _charts(self, places: Sequence[int]) -> list[Pane]:
        """Return the panes of charts, those that the role has."""
        return [
            Pane(partial(self._chart, place), f"chart{place}")
            for place in places
            if place < len(self._post.charts)
        ]

    def _chart(self, place: int, width: int, height: int) -> Lines:
        return strip(place, self.model, CHART_SPANS_S[self.span], width, height)

    def _line(self, width: int, height: int) -> Lines:
        """Return the hint on what may be typed next, or the line of time."""
        try:
            typed = self.screen_stack[0].query_one(Entry).value
        except NoMatches:
            return []
        if typed:
            return [fit(line((f"   {hint(typed, self._names)}", "dim")), width)]
        return time_line(self.model, width, height)

    def _quick(self) -> frozenset[str]:
        """Return the keys that act, and type nothing, while the line is empty."""
        if not self.model.instructs:
            return frozenset()
        return frozenset(name for name in self._keys if len(name) > 1)

    # dialogs

    def _open(self, subject: DialogSubject, past: Callable[[], bool] = lambda: False) -> None:
        self.push_screen(Dialog(subject, past), self._finish)

    def _finish(self, done: DialogOutcome | None) -> None:
        """Send the orders of a dialog that has ended."""
        if done is None:
            return
        for words in done.orders:
            self.model.order(words)
        if done.leave:
            self.exit()

    def _leave(self) -> None:
        """Leave; the instructor is asked whether the run ends too."""
        if self.model.instructs and self.model.joined and not self.model.over:
            self._open(leave_question(own=self.own))
        else:
            self.exit()


def idle_reason(act: MoveAction | PumpAction, model: SessionModel) -> str:
    """Return why a control's key does nothing: no such thing, or no figure of it."""
    channel = "tanks" if isinstance(act, PumpAction) else SURFACE_CHANNELS[act.surface]
    name = act.tank if isinstance(act, PumpAction) else SURFACE_NAMES[act.surface]
    name = f"{name.replace('_', ' ')} tank" if isinstance(act, PumpAction) else name
    if channel in model.picture.last and model.joined:
        return f"this boat has no {name}"
    return f"not ready: the {name}; its panel has shown nothing yet"


def nearest_step(steps: Sequence[float], value: float, by: int) -> float:
    """Return the step ``by`` places beside the one that is nearest to a value."""
    place = min(range(len(steps)), key=lambda i: abs(steps[i] - value))
    return steps[min(max(place + by, 0), len(steps) - 1)]
