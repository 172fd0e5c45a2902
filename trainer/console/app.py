"""The screen of one role in a terminal, as a Textual application.

It shows the panes of the role (``role_panes``), takes keys (``keys``) and typed orders, and opens
dialogs. All that it knows of the session is in ``model``; what has changed is drawn ten times a
second.
"""

import re
from collections.abc import Callable, Mapping
from functools import partial
from typing import ClassVar, Final

from textual import events
from textual.app import App, ComposeResult
from textual.binding import BindingType
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
from trainer.console.guide import (
    LEADING_KEYS,
    EndView,
    PlanView,
    TextView,
    answer,
    briefing,
    guide,
    steps_after,
)
from trainer.console.journal import wrap_entry
from trainer.console.key_orders import KeyOrders, TypedKeys
from trainer.console.keys import (
    DialogAction,
    KeyAction,
    MoveAction,
    PlainAction,
    PumpAction,
    ScrollAction,
    SpanAction,
    TypingAction,
    by_name,
)
from trainer.console.model import SessionModel
from trainer.console.pane import Pane
from trainer.console.role_panes import RolePanes
from trainer.console.timeline import TimelineView
from trainer.io.orders.grammar import Refused

REFRESH_RATE_HZ: Final = 10.0  # [Hz] of drawing what has changed
FIRST_POLL_S: Final = 0.004  # [s] between looks for the first figures
FUNCTION_KEY_PATTERN: Final = re.compile(r"f\d+|ctrl\+[cgt]")  # keys that are no part of an order
DIALOG_SUBJECTS: Final[Mapping[str, Callable[[SessionModel], DialogSubject]]] = {
    "help": guide,
    "briefing": briefing,
    "casualties": casualty_choice,
    "sea": sea_choice,
    "moments": lambda model: TimelineView(model, replays=False),
    "plan": PlanView,
    "emergency": lambda _model: blow_question(),
}


class Console(App[Refused], inherit_bindings=False):
    """The screen of one station. It ends with the session's refusal of the role, if any."""

    CSS_PATH = "console.tcss"
    TITLE = "trainer"
    ENABLE_COMMAND_PALETTE = False
    AUTO_FOCUS = ""  # a station's keys are its controls
    # lists, as the library has them
    HORIZONTAL_BREAKPOINTS = [(0, "-tiny"), (60, "-narrow"), (126, "-wide")]  # noqa: RUF012
    VERTICAL_BREAKPOINTS = [  # noqa: RUF012
        *((0, "-flat"), (20, "-short"), (24, "-low")),
        *((26, "-middle"), (36, "-tall"), (50, "-high")),
    ]
    # None of the library's: its Ctrl-Q would end the console, but users press Ctrl-Q to wake a
    # terminal that Ctrl-S has stopped.
    BINDINGS: ClassVar[list[BindingType]] = []

    def __init__(self, model: SessionModel, *, own: bool = False) -> None:
        """Show ``model``. A session that is the console's ``own`` ends with it."""
        super().__init__()
        self.model = model
        self.own = own
        self._keys = by_name(model.role)
        self._orders = KeyOrders(model)
        self._typed = TypedKeys(model.clock)
        self._panes = RolePanes(model, self.act, self._open, self._submit)
        self._seen: tuple[object, ...] = ()
        self._rung = model.bells
        self._silent = self._mounted = False
        self._early: list[events.Key] = []  # typed before there is a line to type them into
        self._ended, self._released = model.exercise.endings, model.exercise.releases
        self._briefed = ""  # the exercise whose briefing was shown

    def get_default_screen(self) -> Screen[None]:
        """Return a screen that has the role's style from its first drawing."""
        return Screen(id="_default", classes=self.model.role)

    def compose(self) -> ComposeResult:
        """Show the panes of the role."""
        yield from self._panes.compose()

    async def on_mount(self) -> None:
        """Start the timers, and take keys that came before the instructor's line was there."""
        self.model.hear()  # what has come by now is in the first drawing
        self._mounted = True
        self._expecting = self.set_interval(FIRST_POLL_S, self._expect)
        self.set_interval(1.0 / REFRESH_RATE_HZ, self._look)
        self.set_focus(self._panes.entry if self.model.instructs else None)
        for event in self._early:
            await super().on_event(event)

    async def on_event(self, event: events.Event) -> None:
        """Act on a control's key at once, so that keys right after a colon count as typed."""
        if isinstance(event, events.Key) and not self._mounted and self.model.instructs:
            self._early.append(event)
            return
        if isinstance(event, events.Key) and not event.is_forwarded and self._gives_way(event):
            self.pop_screen()  # now, or keys right behind it would still be the window's
            self._panes.entry.begin(event.character or "")
            return
        if isinstance(event, events.Key) and not event.is_forwarded and self._at_controls:
            if self._leads_on((event.character or "").lower()):
                return
            key = self._keys.get(event.key)
            if key is not None:
                self._typed.take(event.character, key.act)
                self.act(key.act)
                return
            if event.character and event.character.isalpha():  # no key, so it begins an order
                why = self._typed.explain_lost()
                self._panes.entry.begin(event.character, why)
                if why:
                    self.model.journal.add(None, "refused", why)
                return
        await super().on_event(event)

    def _leads_on(self, key: str) -> bool:
        """Act on a key of the window of an exercise that is over, though it was closed."""
        model = self.model
        if not (model.trains and model.exercise.outcome and key in LEADING_KEYS):
            return False
        if key not in steps_after(model):
            return False
        window = EndView(model)
        done = window.lead_on(key)
        self._finish(done)
        if done is None:  # it asks once more, or shows what comes
            self.push_screen(Dialog(window, lambda: not model.exercise.outcome), self._finish)
        return True

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
        words = typed or self._orders.make(PlainAction.REPEAT)
        if not self.model.instructs:
            self.set_focus(None)
        if words in ("detach", "bye"):
            self.exit()
        elif words:
            self.model.order(words)
            self._look()

    def act(self, act: KeyAction) -> None:
        """Carry out the action of a key."""
        words = self._orders.make(act)
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
                self._panes.entry.begin(text)
            case PlainAction.REPEAT if not words:
                self._panes.entry.begin("")
            case PlainAction.RING:
                self._silent = not self._silent
                said = "off" if self._silent else "on"
                self.model.journal.add(None, "station", f"the bell is {said}")
            case SpanAction(steps):
                self._panes.widen(steps)
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
            self.model.journal.add(None, "refused", self._orders.why_idle(act))

    # looking

    def on_resize(self, event: events.Resize) -> None:
        """Give the footer the rows that its keys need."""
        self._panes.flow(event.size.width)

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
        changes, span = (model.picture.changes, model.journal.changes), self._panes.span
        seen = (changes, model.joined, model.over, span)
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
        if self.model.exercise.endings > self._ended and not self._panes.entry.value:
            self._ended = self.model.exercise.endings
            if self.model.instructs or self.model.trains:
                self._open(EndView(self.model), lambda: not self.model.exercise.outcome)
        self._lead_in()
        before, self._released = self._released, self.model.exercise.releases
        if self._released > before and not self.model.instructs and len(self.screen_stack) == 1:
            self._open(briefing(self.model), lambda: not self.model.exercise.outcome)
        while self.model.sent.answers and len(self.screen_stack) == 1:
            self._open(answer(*self.model.sent.answers.pop(0)))

    def _lead_in(self) -> None:
        """Show who trains the briefing before time runs; give what comes and goes its room."""
        model, exercise, timeline = self.model, self.model.exercise, self.model.timeline
        evaluated = bool(timeline.attainable or timeline.unevaluated) and not exercise.outcome
        self.screen_stack[0].set_class(evaluated, "evaluated")
        self.screen_stack[0].set_class(bool(model.alerts.alerts), "alerted")
        if not model.trains:
            return
        self.screen_stack[0].set_class(bool(exercise.step.text), "lesson")
        self.screen_stack[0].set_class("ballast" in exercise.by_hand, "tanks")
        self.screen_stack[0].set_class(bool(model.picture.word("plant", "main_pressure")), "fed")
        entries = model.journal.entries
        rows = wrap_entry(entries[-1], self.size.width) if entries else []
        self.screen_stack[0].set_class(len(rows) > 1, "long-entry")  # such as a hint
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
