"""What lies before and after the present: what a late screen has not seen, what is planned."""

import re

import pytest
from helpers.screens import CREW, Tape, sight_of, tape, values

from trainer.console.charts import Sample, Trace
from trainer.console.client import LineLoss, RoleTaken
from trainer.console.drawing.event_log import log, time_at, time_line
from trainer.console.journal import MAX_ENTRIES, JournalEntry
from trainer.console.layouts import LAYOUTS
from trainer.console.model import SessionModel
from trainer.console.pane import plain
from trainer.io.orders import sentences


def late(role: str = "planes", tick: int = 1200) -> tuple[Tape, SessionModel]:
    """Return a session of ten minutes, and a screen that comes to it now."""
    talk = tape(role)
    talk.items = [item for item in talk.items if getattr(item, "kind", "") != "TRS"]
    talk.tick(tick)
    return talk, sight_of(talk, role)


def asked(talk: Tape) -> list[str]:
    return [words.removeprefix("history ") for words in talk.given if "history" in words]


def send(talk: Tape, channel: str, *ticks: int, **changed: str) -> None:
    """Send the past of a channel."""
    talk.say(sentences.fact(1200, 600.0, "past", f"begin,{channel}"))
    for tick in ticks:
        told = {name: text.format(tick) for name, text in changed.items()}
        talk.say(sentences.state(channel, tick, tick / 2.0, values(channel, **told)))
    talk.say(sentences.fact(1200, 600.0, "past", f"end,{channel}"))


@pytest.mark.parametrize("role", ["instructor", *CREW])
def test_who_comes_late_asks_for_the_past_of_its_charts_once(role: str) -> None:
    talk, model = late(role)
    for _ in range(3):
        model.hear()
        talk.tick(1201)
    wanted = asked(talk)
    assert "events" in wanted
    assert set(wanted) - {"events"} <= set(LAYOUTS[role].channels)
    assert len(wanted) == len(set(wanted)) > 2


def test_who_is_there_from_the_start_asks_for_nothing() -> None:
    talk, model = late(tick=4)
    model.hear()
    assert asked(talk) == []


def test_who_returns_asks_again_if_it_has_missed_more_than_a_moment() -> None:
    talk, model = late(tick=4)
    model.hear()
    for tick, times in ((10, 0), (1200, 1)):
        talk.items += [LineLoss("gone"), RoleTaken()]
        talk.tick(tick)
        model.hear()
        assert asked(talk).count("events") == times


def test_charts_show_what_was_before_and_the_present_stays() -> None:
    talk, model = late()
    model.hear()
    send(talk, "gauges", 0, 400, 800, depth="{}", pitch="1.0")
    send(talk, "diving", 0, 400, 800, ordered_depth="9{}")
    send(talk, "orders", 0, 400, 800)
    model.hear()
    assert model.charts.trace.times == [0.0, 200.0, 400.0, 600.0]
    depths = [samples[0] for samples in model.charts.trace.samples]
    assert depths[:3] == [Sample(0.0, 90.0), Sample(400.0, 9400.0), Sample(800.0, 9800.0)]
    assert depths[3] == Sample(60.0, 80.0)
    assert model.picture.seconds == 600.0
    assert model.picture.number("gauges", "depth") == 60.0


def test_the_track_and_the_time_line_show_what_was_before() -> None:
    talk, model = late("instructor")
    model.hear()
    for channel in set(asked(talk)) - {"events"}:
        send(talk, channel, 0, 400, 800, north="{}", east="5.0")
    talk.say(sentences.fact(1200, 600.0, "past", "begin,events"))
    talk.say(sentences.event(100, 50.0, "exercise", "casualty stern-stuck"))
    talk.say(sentences.fact(100, 50.0, "order", "casualty stern-stuck"))
    talk.say(sentences.fact(200, 100.0, "mark", "well done"))
    talk.say(sentences.fact(200, 100.0, "crew-order", "depth 60 m"))
    talk.say(sentences.fact(1200, 600.0, "past", "end,events"))
    model.hear()
    assert [north for north, _ in model.charts.track][:3] == [0.0, 400.0, 800.0]
    marks = model.timeline.marks
    assert [(kept.sign, kept.seconds) for kept in marks] == [
        ("C", 50.0),
        ("M", 100.0),
    ]
    assert JournalEntry(50.0, "exercise", "casualty stern-stuck") in model.journal.entries
    assert model.crew.oldest is None  # what stands now is told by itself
    assert model.bells == 0


def test_the_past_of_the_log_comes_first_and_nothing_twice() -> None:
    _, model = late()
    model.hear()
    model.journal.add(600.0, "time", "now")
    for _ in range(2):
        model.journal.recall(
            [JournalEntry(1.0, "time", "then"), JournalEntry(600.0, "time", "now")]
        )
    assert [entry.text for entry in model.journal.entries if entry.seconds] == ["then", "now"]
    assert next(iter(model.journal.entries)).text == "then"


def test_a_full_log_keeps_its_newest_lines_when_the_past_is_told() -> None:
    _, model = late()
    for second in range(MAX_ENTRIES):
        model.journal.add(600.0 + second, "time", f"now {second}")
    model.journal.recall([JournalEntry(1.0, "time", "then")])
    assert model.journal.entries[-1].text == f"now {MAX_ENTRIES - 1}"
    assert len(model.journal.entries) == MAX_ENTRIES


def test_what_was_sampled_live_is_not_replaced() -> None:
    trace = Trace()
    for second in (5.0, 6.0):
        trace.add(second, [Sample(second, None)])
    trace.recall([(second, [Sample(-1.0, None)]) for second in (1.0, 5.0, 9.0)])
    assert trace.times == [1.0, 5.0, 6.0]
    assert [samples[0].actual for samples in trace.samples] == [-1.0, 5.0, 6.0]


def test_the_time_line_shows_what_is_planned_and_reaches_so_far() -> None:
    talk = tape()
    ahead = (
        "1,150.000,casualty stern-stuck",
        "2,90.000,depth 80",
        ",depth > 80,casualty rudder-stuck",
    )
    for what, subject in (("plans", "3"), *(("planned", each) for each in ahead)):
        talk.say(sentences.fact(120, 60.0, what, subject))
    model = sight_of(talk)
    model.hear()
    (drawn,) = time_line(model, 80, 1)
    room = 80 - len(" 00:00 ") - len(" 00:02:30 ")
    signs = "".join(text for text, _ in drawn)[len(" 00:00 ") :]
    assert {sign: place for place, sign in enumerate(signs[:room]) if sign in "co┃"} == {
        "┃": round(60.0 / 150.0 * (room - 1)),
        "o": round(90.0 / 150.0 * (room - 1)),
        "c": room - 1,
    }
    assert time_at(model, 80, 7 + room - 1) == 150.0
    assert re.findall(r"[\d:]{5,}", signs[:room]) == ["02:00"]  # a sign stands at 01:00
    middle = 7 + signs.index("02:00") + 2
    assert abs(time_at(model, 80, middle) - 120.0) < 150.0 / room

    talk.say(sentences.fact(124, 62.0, "plans", "0"))
    model.hear()
    assert plain(time_line(model, 80, 1)).endswith("┃ 00:01:00")


def test_a_log_without_room_for_an_entry_shows_its_beginning() -> None:
    _, model = late("planes")
    told = "hint, 5 marks: bell astern full, due since 00:01:11: the gauges show stern < -4"
    model.journal.entries.clear()
    model.journal.entries.append(JournalEntry(70.0, "order", "depth 80"))
    model.journal.entries.append(JournalEntry(75.0, "answer", told))

    (one,) = log(model, 60, 1)
    assert plain([one]).strip().startswith("00:01:15")
    assert "hint, 5 marks: bell astern full, due since ..." in plain([one])
    assert "stern < -4" in plain(log(model, 60, 2)), "room for all of it"
    assert "depth 80" in plain(log(model, 60, 3))
    model.journal.back = 1
    assert "1 more lines below" in plain(log(model, 60, 1)), "who reads back is told so"
