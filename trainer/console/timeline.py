"""The dialog of the time line, which goes back to a moment or replays.

``app`` opens it for the instructor. It only chooses: it ends with an order (``backtrack``,
``replay``), and the session does what is ordered.
"""

from dataclasses import dataclass
from typing import Final

from trainer.console.dialogs import NO_OUTCOME, DialogOutcome
from trainer.console.drawing.event_log import end_of, moments, time_at, time_line
from trainer.console.journal import clock
from trainer.console.model import SessionModel
from trainer.console.pane import Lines, fit, line

KEY_STEPS_S: Final = {"left": 5.0, "right": -5.0, "shift+left": 60.0, "shift+right": -60.0}  # [s]
SHOWN_MOMENTS: Final = 8  # the latest moments, in the list
TIMELINE_ROW: Final = 3  # the row of the time line
NEAR_MOMENT_S: Final = 0.26  # [s] from a moment within which a time counts as that moment
MOMENT_SIGNS: Final = {"S": "snapshot", "C": "broken", "M": "mark"}


@dataclass
class TimelineView:
    """A moment [s] before now on the time line, and whether Enter replays from there."""

    model: SessionModel
    replays: bool
    lapse: float = 30.0
    size: tuple[int, int] = (78, 20)

    @property
    def there(self) -> float:
        """Return the time [s] of the chosen moment."""
        return max(self.model.picture.seconds - self.lapse, 0.0)

    @property
    def snapshot(self) -> str:
        """Return the snapshot at that time, "" for none."""
        kept = self.model.timeline.snapshots
        near = [each.text for each in kept if abs(each.seconds - self.there) < NEAR_MOMENT_S]
        return near[-1] if near else ""

    def order(self, *, replay: bool) -> str:
        """Return the order that goes to the chosen moment."""
        if replay:
            return f"replay {max(self.lapse, 0.5):g} s"
        if self.there <= 0.0:
            return "reset"
        return f"restore {self.snapshot}" if self.snapshot else f"backtrack {self.lapse:g} s"

    def press(self, key: str, character: str | None) -> DialogOutcome | None:
        """Take a key; return how the dialog ends, None while it goes on."""
        if key == "escape":
            return NO_OUTCOME
        if key in ("enter", "r", "b"):
            replay = key == "r" or (key == "enter" and self.replays)
            return DialogOutcome((self.order(replay=replay),))
        if key in ("up", "down"):
            self._jump(earlier=key == "up")
        elif key == "home":
            self.lapse = self.model.picture.seconds
        elif character and character in "123456789":
            self.lapse = 60.0 * int(character)
        self.lapse += KEY_STEPS_S.get(key, 0.0)
        self.lapse = min(max(self.lapse, 0.5), max(self.model.picture.seconds, 0.5))
        return None

    def click(self, column: int, row: int, width: int) -> DialogOutcome | None:
        """Choose the moment of a click, on the time line or in the list."""
        shown = moments(self.model)[-SHOWN_MOMENTS:]
        if row in (TIMELINE_ROW, TIMELINE_ROW + 1):
            self.lapse = self.model.picture.seconds - time_at(self.model, width, column)
        elif 0 <= row - TIMELINE_ROW - 2 < len(shown):
            self.lapse = self.model.picture.seconds - shown[row - TIMELINE_ROW - 2].seconds
        self.lapse = max(self.lapse, 0.5)
        return None

    def _jump(self, *, earlier: bool) -> None:
        """Choose the next moment that is earlier or later than the chosen moment."""
        times = sorted({0.0, *(kept.seconds for kept in moments(self.model))})
        side = [
            t
            for t in times
            if (t < self.there - NEAR_MOMENT_S) == earlier and abs(t - self.there) > NEAR_MOMENT_S
        ]
        if side:
            self.lapse = self.model.picture.seconds - (side[-1] if earlier else side[0])

    def draw(self, width: int, height: int) -> Lines:
        """Return the dialog."""
        verb = "Replay from" if self.replays else "Go back to"
        rows = [
            line((f"   {clock(each.seconds)}  {MOMENT_SIGNS[each.sign]}: {each.text}", "plain"))
            for each in moments(self.model)[-SHOWN_MOMENTS:]
        ]
        # an arrow under the moment on the time line
        end = end_of(self.model)
        room = width - 7 - 10
        lines = [
            line((f" {verb}", "title")),
            line(),
            line((f"   {clock(self.there)}", "value"), f"   {self.lapse:g} s ago"),
            *time_line(self.model, width, 1),
            line((" " * (7 + round(self.there / end * max(room - 1, 0))) + "▲", "value")),
            *(rows or [line(("   no snapshots, marks or casualties yet", "dim"))]),
            line(),
            line((" 1 to 9: minutes ago    Left, Right: 5 s    Shift with them: 1 min", "dim")),
            line((" Up, Down: from one moment to the next    Home: the start", "dim")),
            line((" B goes back there    R replays from there    Esc stays", "dim")),
            line((" Enter sends: ", "dim"), (self.order(replay=self.replays), "ordered")),
        ]
        return [fit(each, width) for each in lines[:height]]
