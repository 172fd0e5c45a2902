"""The tables of a debrief, as HTML."""

import re
from collections.abc import Iterable, Iterator, Sequence
from html import escape
from typing import Final

from trainer.analysis.debrief.data import Answered, Dossier
from trainer.analysis.debrief.episodes import SCHEDULE
from trainer.analysis.debrief.scoring import Scored
from trainer.analysis.report.svg import clock

MOST: Final = 1000  # lines of the log
PLACED: Final = re.compile(r"tick \d+ \([\d.]+ s\): ")  # in an event that says its own place
TOLD: Final = 4  # digits of a value that count


def number(value: float | None) -> str:
    """Return a value as it is told, '-' for none."""
    return "-" if value is None else f"{value:.{TOLD}g}"


def table(headings: Sequence[str], rows: Iterable[Sequence[str]], style: str = "") -> str:
    """Return a table; cells are HTML already."""
    head = "".join(f"<th scope='col'>{escape(each)}</th>" for each in headings)
    body = "".join(f"<tr>{''.join(f'<td>{cell}</td>' for cell in row)}</tr>" for row in rows)
    return (
        f'<div class="wide"><table class="{style}"><thead><tr>{head}</tr></thead>'
        f"<tbody>{body}</tbody></table></div>"
    )


def place(dossier: Dossier, tick: int | None) -> str:
    """Return a moment of the record as time and tick."""
    if tick is None:
        return "-"
    return f"{clock(tick * dossier.step)} <small>tick {tick}</small>"


def verdict(dossier: Dossier) -> str:
    """Return the marks of the whole, in words."""
    card = dossier.card
    if not card.scores:
        return "<p>This run has no scoring rules.</p>"
    counted = sum(each.marks is not None for each in card.scores)
    total = "-" if card.total is None else f"{card.total:.0f}"
    lines = [f'<p class="total"><b>{total}</b> of 100 marks</p>']
    if counted < len(card.scores):
        lines.append(f"<p>{counted} of {len(card.scores)} rules count.</p>")
    lacking = _unflown(dossier)
    if lacking:
        lines.append(f"<p>{lacking}</p>")
    return "".join(lines)


def _unflown(dossier: Dossier) -> str:
    """Return that the record ends before the exercise, '' if it does not."""
    flown, planned = float(dossier.passage.seconds[-1]), dossier.plan.duration
    if planned is None or flown >= planned - dossier.step:
        return ""
    return f"The record ends at {clock(flown)}; the exercise lasts {clock(planned)}."


def scores(dossier: Dossier) -> str:
    """Return the table of the scores."""
    headings = ("", "score", "value", "full at", "none at", "marks", "weight", "place", "formula")
    rows = (_score(dossier, i, each) for i, each in enumerate(dossier.card.scores, start=1))
    return table(headings, rows, "scores")


def _score(dossier: Dossier, i: int, each: Scored) -> tuple[str, ...]:
    score, attained = each.rule.score, each.attained
    unit = "" if each.unit == "-" else f"&nbsp;{each.unit}"
    value = escape(attained.why) if attained.value is None else number(attained.value) + unit
    marks = "not counted"
    if each.marks is not None:
        marks = f'{each.marks:.0f} <i class="share"><i style="width:{each.marks:.0f}%"></i></i>'
    return (
        *(f"S{i}", escape(each.name), value, number(score.full), number(score.zero), marks),
        *(f"{each.rule.weight:g}", place(dossier, attained.tick), escape(each.formula)),
    )


def casualties(dossier: Dossier) -> str:
    """Return the table of the casualties and of what was done about them."""
    headings = (
        "",
        "casualty",
        "began",
        "gone",
        "first order",
        "after",
        "first deflection",
        "after",
    )
    rows = (_casualty(dossier, i, each) for i, each in enumerate(dossier.casualties, start=1))
    return table(headings, rows)


def _casualty(dossier: Dossier, i: int, each: Answered) -> tuple[str, ...]:
    spell, order, moved = each.spell, each.order, each.deflection

    def after(tick: int) -> str:
        return f"{(tick - spell.begun) * dossier.step:g} s"

    return (
        *(f"C{i}", spell.kind, place(dossier, spell.begun)),
        "at the end still there" if spell.ended is None else place(dossier, spell.ended),
        escape(f"{order.text} ({order.who})") if order else "none",
        after(order.tick) if order else "-",
        moved.surface if moved else "none",
        after(moved.tick) if moved else "-",
    )


def marks(dossier: Dossier) -> str:
    """Return the table of the marks with their remarks."""
    rows = (
        (f"M{i}", place(dossier, each.tick), escape(each.text), escape(each.who))
        for i, each in enumerate(dossier.of_kind("mark"), start=1)
    )
    return table(("", "moment", "remark", "by"), rows)


def hands(dossier: Dossier) -> str:
    """Return the table of who gave orders."""
    rows = (
        (
            "the exercise" if each.who == SCHEDULE else escape(each.who),
            str(each.orders),
            str(each.refused),
        )
        for each in dossier.hands
    )
    return table(("line", "orders", "refused"), rows)


def log(dossier: Dossier) -> str:
    """Return the table of orders and events, in the order in which they were."""
    entries = sorted(_entries(dossier), key=lambda entry: entry[0])
    rows = ((place(dossier, tick), *cells) for tick, *cells in entries[:MOST])
    more = len(entries) - MOST
    rest = f"<p>{more} more are in the record: trainer export has all.</p>" if more > 0 else ""
    return table(("moment", "who", "what", "answer"), rows, "log") + rest


def _entries(dossier: Dossier) -> Iterator[tuple[int, str, str, str]]:
    """Yield tick, who, what and answer of orders and events."""
    for each in dossier.passage.orders:
        answer = (
            escape(each.answer)
            if each.accepted is not False
            else (f"<strong>refused:</strong> {escape(each.answer)}")
        )
        yield each.tick, escape(each.who), escape(each.text), answer
    for event in dossier.events:
        words = PLACED.sub("", event.text)
        yield event.tick, escape(event.who or event.kind), escape(words), ""


def branches(dossier: Dossier) -> str:
    """Return the table of the branches."""
    rows = []
    for branch, last in dossier.branches:
        begun = "the start" if branch.parent is None else f"branch {branch.parent}"
        here = " <b>debriefed here</b>" if branch.id == dossier.branch.id else ""
        moments = place(dossier, branch.tick), place(dossier, last)
        rows.append((f"{branch.id}{here}", begun, *moments, escape(branch.why)))
    return table(("branch", "from", "at", "to", "why"), rows)


def ledger(dossier: Dossier) -> str:
    """Return what became of the ticks, and every trouble with them."""
    ticks = dossier.ticks
    if not ticks.work or not ticks.lateness or ticks.duty_cycle is None:
        return "<p>No tick was timed.</p>"
    rows = [
        ("work", *(f"{value / 1e3:.1f} us" for value in ticks.work)),
        ("lateness", *(f"{value / 1e3:.1f} us" for value in ticks.lateness)),
    ]
    troubles = dossier.of_kind("trouble")
    told = (
        f"{ticks.timed} ticks of {dossier.step:g} s timed, duty cycle "
        f"{100 * ticks.duty_cycle:.3f} %; {len(troubles)} troubles called out"
    )
    listed = "".join(
        f"<li>{place(dossier, each.tick)}: {escape(each.text)}</li>" for each in troubles[:50]
    )
    return (
        f"<p>{told}.</p>"
        + table(("", "median", "99 %", "most"), rows)
        + (f"<ul>{listed}</ul>" if listed else "")
    )


def made_of(dossier: Dossier) -> str:
    """Return what computed the run."""
    header, method = dossier.header, dossier.plan.method
    rows = [
        ("boat", escape(dossier.plan.file.name)),
        ("sea at the start", escape(dossier.plan.sea.name)),
        ("computed by", f"{method.equations} set, {method.rates} rates, {method.integrator}"),
        ("step", f"{method.step:g} s"),
        ("seed", str(dossier.plan.seed)),
        ("recorded", escape(header.get("started", "-"))),
        ("trainer", escape(f"{header.get('trainer', '-')}, core {header.get('core', '-')}")),
        ("record", escape(dossier.source.name)),
    ]
    return table(("", ""), rows, "facts")
