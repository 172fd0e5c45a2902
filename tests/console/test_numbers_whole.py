"""No screen shows a part of a number: what has no room for it shows `#`."""

import re
from collections.abc import Callable, Iterator
from functools import partial
from itertools import pairwise

import pytest
from helpers.screens import Tape, at_the_console, seen, shown, sight_of, tape
from hypothesis import given
from hypothesis import strategies as st
from textual.pilot import Pilot

from trainer.console.app import Console
from trainer.console.drawing import event_log, panels
from trainer.console.drawing.chart import strip, time_axis
from trainer.console.layouts import LAYOUTS, Layout
from trainer.console.model import SessionModel
from trainer.console.pane import Lines, beside, cut, fit, length, line, plain
from trainer.console.role_panes import CHART_SPANS_S
from trainer.io.orders import sentences
from trainer.io.orders.grammar import Refused
from trainer.session.stations.channels import CHANNELS

WIDEST = 400  # [columns] where nothing is short of room
FIGURE = re.compile(r"[0-9]+(?:[.,:/][0-9]+)*")
WORDS = {
    "time": "running", "bell": "ahead-flank", "speed_mode": "hand", "rudder_mode": "auto",
    "stern_mode": "hand", "bow_mode": "auto", "branch": "12", "replay": "yes", "held": "depth",
    "compressor": "on", "hover": "on", "draining": "centre", "depth_unit": "m", "told": "",
    "course_side": "", "going": "up", "view": "clear", "sighted": "tug-345",
    "casualty_1": "depth-gauge-biased", "casualty_1_says": "-12.5 m", "contact_1": "trawler-123",
    "contact_2": "tanker",
}  # fmt: skip
NUMBERS = {  # no beginning of one is another
    "depth": "1987.6", "heading": "354.7", "speed": "-28.9", "pitch": "-38.5", "heel": "-47.1",
    "ordered_depth": "1876.5", "ordered_course": "263.0", "ordered_speed": "-27.6",
    "rudder": "-34.6", "ordered_rudder": "35.8", "stern": "-24.2", "ordered_stern": "25.7",
    "bow": "-26.4", "ordered_bow": "29.3", "rpm": "-157", "ordered_rpm": "-168",
    "heavy": "-4321.0", "course": "172.0", "course_error": "-176.3", "depth_error": "-999.8",
    "speed_error": "-55.4", "pitch_error": "-63.2", "sounding": "593.6", "height": "15.3",
    "period": "19.0", "from": "278.0", "over_sail": "14.6", "set": "186.0", "drift": "12.8",
    "course_over_ground": "294.0", "speed_over_ground": "23.5", "turn_rate": "-11.7",
    "main": "65.3", "emergency": "66.8", "bearing": "286.0",
}  # fmt: skip


def value_of(channel: str, name: str) -> str:
    """Return the widest value of a field: no whole number that could be read is a part of it."""
    if name in WORDS:
        return WORDS[name]
    if channel == "time" and name == "speed":
        return "1"
    if name.startswith(("vent_", "blow_", "negative_flood")):
        return "open"
    if name.endswith("_full"):
        return "100"
    if re.fullmatch(r"(casualty|contact)_\d+", name):
        return ""
    return NUMBERS.get(name, "-8642.7" if not name.endswith("_rate") else "0.0")


class Wide(Tape):
    """A session whose every value is as wide as it comes."""

    def tick(self, tick: int, **changed: str) -> None:
        for channel in self.channels:
            fields = [each.name for each in CHANNELS[channel].fields]
            row = [changed.get(name) or value_of(channel, name) for name in fields]
            self.say(sentences.state(channel, tick, tick / 2.0, row))


def model_of(role: str) -> SessionModel:
    talk = Wide(LAYOUTS[role].channels)
    for tick in range(121, 160):
        talk.tick(tick)
    model = sight_of(talk, role)
    model.hear()
    return model


def figures(lines: Lines) -> set[str]:
    """Return the numbers that can be read."""
    return set(FIGURE.findall(plain(lines)))


Drawing = Callable[[SessionModel, int, int], Lines]


def title_of_chart(number: int, model: SessionModel, width: int, height: int) -> Lines:
    return strip(number, model, 60.0, width, height)[:1]


def drawings(post: Layout) -> Iterator[Drawing]:
    """Yield all that is drawn for a role but the charts' and the track's own scales."""
    yield panels.top
    yield event_log.time_line
    for place in (*post.upper, *post.lower, *post.aside):
        if place.name != "plan":
            yield place.draw
    for number in range(len(post.charts)):
        yield partial(title_of_chart, number)


@pytest.mark.slow
@pytest.mark.parametrize("role", LAYOUTS)
def test_every_number_on_a_panel_is_one_that_is_there_whatever_its_size(role: str) -> None:
    model = model_of(role)
    for draw in drawings(LAYOUTS[role]):
        whole = set().union(*(figures(draw(model, WIDEST, rows)) for rows in (1, 7, 24)))
        known = whole | set(allowed(model))
        for width in (*range(8, 101), *range(101, 251, 7)):  # little is cut where there is room
            for height in (5, 12):  # with small numbers, and with large ones
                lines = [fit(each, width) for each in draw(model, width, height)]
                assert all(length(each) == width for each in lines)
                assert figures(lines) <= known, (width, height, plain(lines))


def allowed(model: SessionModel) -> Iterator[str]:
    """Yield the values of all channels to as many decimals as a short wording may have."""
    for channel in model.picture.last:
        for text in model.picture.last[channel].values.values():
            if re.fullmatch(r"-?[0-9.]+", text):
                yield from (f"{abs(float(text)):.{decimals}f}" for decimals in range(3))
                yield f"{float(text) % 360.0:03.0f}"


@pytest.mark.parametrize("size", [(80, 24), (100, 30), (120, 40), (200, 50), (250, 70)])
def test_the_instructor_reads_revolutions_and_tanks_whole_at_every_size(
    size: tuple[int, int],
) -> None:
    async def look(pilot: Pilot[Refused], app: Console) -> None:
        await seen(pilot, app, "-157 > -168")
        text = shown(app)
        assert "depth  1987.6 > 1876.5 m" in text
        assert "main 100/100/100" in text
        assert "dc 100 %" in text

    talk = Wide(LAYOUTS["instructor"].channels)
    talk.facts = tape().facts
    at_the_console(look, talk, "instructor", size)


@given(st.floats(-1e9, 1e9), st.integers(0, 3), st.integers(0, 40), st.integers(0, 12))
def test_a_line_that_is_cut_holds_a_number_whole_or_not_at_all(
    value: float, decimals: int, width: int, label: int
) -> None:
    number = f"{value:.{decimals}f}"
    drawn = line(("x" * label + " ", "dim"), (number[:1], "value"), (number[1:], "plain"), " m")
    for found in (cut(drawn, width), beside(drawn, line(" end"), width)):
        text = "".join(part for part, _ in found)
        assert len(text) <= width
        assert number in text or not re.search("[0-9]", text)


@pytest.mark.parametrize("span", CHART_SPANS_S)
def test_the_times_below_a_chart_do_not_write_over_each_other(span: float) -> None:
    for columns in range(10, 251):
        text = "".join(part for part, _ in time_axis(span, columns))
        assert len(text) == columns + 7
        marks = re.findall(r"-?[0-9]+(?:s|min)|[0-9a-z]+", text)
        assert all(re.fullmatch(r"-[0-9]+(s|min)|now", each) for each in marks), text
        ago = [
            float(each[1:].rstrip("smin")) * (60.0 if "min" in each else 1.0)
            for each in marks
            if each != "now"
        ]
        assert all(earlier > later for earlier, later in pairwise(ago)), text
