"""A drawing of the alerts: a line each, with the order that acknowledges it."""

from typing import Final

from trainer.console.alerts import SILENCED_STATE, ListedAlert
from trainer.console.journal import clock
from trainer.console.model import SessionModel
from trainer.console.pane import Line, Lines, beside, fit, line

RANK_INKS: Final = {"emergency": "alarm", "alarm": "alarm", "warning": "warning"}  # while active
STATE_WORDS: Final = {"rectified": "over, not seen"}


def alerts(model: SessionModel, width: int, height: int) -> Lines:
    """Return the alerts, what is owed first; the last line counts those without room."""
    listed, now = model.alerts.listed, model.clock()
    room = height if len(listed) <= height else max(height - 1, 1)
    lines = [alert_row(each, each.state(now), width) for each in listed[:room]]
    if more := len(listed) - room if room < height else 0:
        lines.append(line((f" and {more} more: type alerts", "dim")))
    return [fit(each, width) for each in lines]


def alert_row(alert: ListedAlert, state: str, width: int) -> Line:
    """Return the line of an alert, with the order that is due at its right."""
    active = state == "active" and alert.rank in RANK_INKS
    ink = RANK_INKS[alert.rank] if active else "warning" if alert.owed else "dim"
    said = f"{alert.rank}, {STATE_WORDS.get(state, state)}: {alert.text}"
    return beside(
        line((f" {clock(alert.seconds)} ", "dim"), (said, ink)),
        line((f" {duty_of(alert, state)} ", "value" if alert.owed else "dim")),
        width,
    )


def duty_of(alert: ListedAlert, state: str) -> str:
    """Return the order that is due, or who is to give it; "" for none."""
    if not alert.owed:
        return ""
    silence = "" if state in (SILENCED_STATE, "rectified") else f"ack silent {alert.number}"
    if alert.rank == "emergency":  # it takes no acknowledgement
        return silence
    if alert.duty == "you":
        return f"ack {alert.number}"
    theirs = f"for {' or '.join(alert.duty.split())}"
    return f"{theirs}; {silence}" if silence else theirs
