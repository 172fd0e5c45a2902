"""The panes of a role's screen, and its line of orders.

``app`` shows them. It hears of a click as of a key: an action, or a window to be opened.
"""

from collections.abc import Callable
from functools import partial
from typing import Final

from textual.app import ComposeResult
from textual.containers import Horizontal, Vertical

from trainer.console.dialogs import DialogSubject
from trainer.console.drawing.alerts import alerts
from trainer.console.drawing.chart import strip
from trainer.console.drawing.evaluation import evaluation
from trainer.console.drawing.event_log import log, time_at, time_line
from trainer.console.drawing.panels import flowed, foot, key_at, top
from trainer.console.entry import Entry, OrderNames, hint
from trainer.console.keys import KEYS, KeyAction, ScrollAction, by_name, footer
from trainer.console.layouts import LAYOUTS, PaneDrawing
from trainer.console.model import SessionModel
from trainer.console.pane import Lines, Pane, fit, line
from trainer.console.timeline import TimelineView

MAX_KEY_ROWS: Final = 3  # [rows] of keys at most
CHART_SPANS_S: Final = (60.0, 120.0, 300.0, 600.0, 1200.0)  # [s] of the charts
ROLE_PROMPTS: Final = {
    "instructor": "type an order, such as depth 80; F1 shows help",
    "trainee": "keys move your controls; or type : and an order, and Enter",
}
DEFAULT_PROMPT: Final = "keys move your controls; Enter to type an order"


class RolePanes:
    """The panes of one screen, from the top to the line of keys."""

    def __init__(
        self,
        model: SessionModel,
        act: Callable[[KeyAction], None],
        show: Callable[[DialogSubject], None],
        submit: Callable[[str], None],
    ) -> None:
        """Show ``model``, and hand on what is clicked and typed."""
        self.span = 1  # of CHART_SPANS_S
        self._model = model
        self._act, self._show = act, show
        self._names = OrderNames(model)
        # the keys that act, and type nothing, while an instructor's line is empty
        quick = frozenset(name for name in by_name(model.role) if len(name) > 1)
        prompt = ROLE_PROMPTS.get(model.role, DEFAULT_PROMPT)
        self.entry = Entry(self._names, quick if model.instructs else frozenset(), prompt, submit)
        self._line = Pane(self._draw_line, "line", moving=True, click=self._travel)
        self._keys = footer(model.role)
        self._foot = Pane(partial(foot, self._keys), "foot", click=self._press)

    def compose(self) -> ComposeResult:
        """Lay the panes out; the style sheet says which are shown at which size."""
        model, layout = self._model, LAYOUTS[self._model.role]
        charts = [Pane(partial(self._chart, n), f"chart{n}") for n in range(len(layout.charts))]
        yield Pane(partial(top, model), "top", moving=True)
        yield Pane(partial(alerts, model), "alerts", moving=True)
        yield Horizontal(*map(self._pane, layout.upper), id="upper")
        if layout.lower:
            yield Horizontal(*map(self._pane, layout.lower), id="lower")
        yield Horizontal(*charts[:3], id="first", classes="charts")
        if charts[3:]:
            yield Horizontal(*charts[3:], id="second", classes="charts")
        with Horizontal(id="record"):
            yield Pane(partial(log, model), "log", wheel=self._scroll)
            if layout.aside:
                yield Vertical(*map(self._pane, layout.aside), id="aside")
        if model.instructs:
            yield Pane(partial(evaluation, model), "evaluation")
        yield Vertical(self._line, self.entry, self._foot, id="bottom")

    def widen(self, steps: int) -> None:
        """Show charts over a longer time, by so many steps."""
        self.span = min(max(self.span + steps, 0), len(CHART_SPANS_S) - 1)

    def flow(self, width: int) -> None:
        """Give the line of keys the rows that it needs."""
        self._foot.styles.height = min(len(flowed(self._keys, width)), MAX_KEY_ROWS)

    def _pane(self, drawing: PaneDrawing) -> Pane:
        return Pane(partial(drawing.draw, self._model), drawing.name, moving=drawing.moving)

    def _chart(self, number: int, width: int, height: int) -> Lines:
        return strip(number, self._model, CHART_SPANS_S[self.span], width, height)

    def _draw_line(self, width: int, height: int) -> Lines:
        """Return the hint on what may be typed next, or the line of time."""
        if (typed := self.entry.value) and self.entry.lost:
            return [fit(line((f" {self.entry.lost}", "warning")), width)]
        if typed:
            return [fit(line((f"   {hint(typed, self._names)}", "dim")), width)]
        return time_line(self._model, width, height)

    def _press(self, column: int, row: int) -> None:
        """Act on the key that is drawn at a point. Each key of a pair has its own half."""
        size = self._foot.size
        label, drawn = key_at(self._keys, size.width, size.height, (column, row))
        other, pair, _ = drawn.partition(":")
        wanted = other if pair else label  # of "0 to 8: bells" the words are no key
        for key in KEYS[self._model.role]:
            if wanted and key.label == wanted:
                self._act(key.act)
                return

    def _scroll(self, lines: int) -> None:
        self._act(ScrollAction(-lines))

    def _travel(self, column: int, _row: int) -> None:
        """Open the dialog of the time line at the moment of a click."""
        if self._model.instructs:
            clicked = time_at(self._model, self._line.size.width, column)
            back = max(self._model.picture.seconds - clicked, 0.5)
            self._show(TimelineView(self._model, replays=False, lapse=back))
