"""The console with aids: dots for ghost and way ahead, both in words, and the way shown."""

import pytest
from helpers.screens import ScriptedLine

from trainer.console.drawing.aids import aid_rows, interpolated_way
from trainer.console.drawing.chart import strip
from trainer.console.drawing.crew_orders import order_line
from trainer.console.drawing.panels import top, trainee
from trainer.console.guide import briefing_rows
from trainer.console.key_orders import SWITCH_ORDERS, KeyOrders
from trainer.console.keys import KEYS, OrderAction, PlainAction
from trainer.console.layouts import LAYOUTS, wishes
from trainer.console.model import SessionModel
from trainer.console.pane import plain
from trainer.io.orders.sentences import names, state

WAY = ";".join(f"{5 * n}:{60 + n:.1f}:10.0:-{n / 2:.1f}" for n in range(1, 13))
GHOST = {"depth": "62.0", "heading": "0.0", "pitch": "-1.0", "depth_off": "-2.0"}
GHOST |= {"heading_off": "3.0", "pitch_off": "1.5"}
AHEAD = {"seconds": "60", "depth": "72.0", "heading": "10.0", "pitch": "-6.0", "way": WAY}
TIME = {"time": "running", "speed": "1.0"}


def show(line: ScriptedLine, tick: int, **channels: dict[str, str]) -> None:
    """Let the session show some channels at a tick; the gauges come last."""
    gauges = {"depth": "60.0", "heading": "359.0", "speed": "8.0", "pitch": "0.5", "heel": "0.0"}
    for name, values in {"time": TIME, **channels, "gauges": gauges}.items():
        fields = [(each, "") for each in values]
        line.say(names(name, fields), state(name, tick, tick / 2.0, list(values.values())))


def seen(**channels: dict[str, str]) -> SessionModel:
    """Return a trainee's model that has been shown some channels for a minute."""
    line = ScriptedLine()
    model = SessionModel(line, "trainee", LAYOUTS["trainee"].charts)
    for tick in range(121):
        show(line, tick, **channels)
    model.hear()
    return model


def test_every_screen_asks_for_the_aids_and_the_gauges_stay_last() -> None:
    for role, post in LAYOUTS.items():
        wished = list(wishes(post))
        assert {"ghost", "predictor"} <= set(wished), role
        assert wished[-1] == post.channels[-1], role


def test_while_the_aids_are_off_nothing_is_drawn_of_them() -> None:
    model = seen(ghost=dict.fromkeys(GHOST, ""), predictor=dict.fromkeys(AHEAD, ""))
    assert aid_rows(model, 80) == []
    drawn = plain(strip(0, model, 120.0, 40, 6))
    assert "··" not in drawn
    assert "╌" not in drawn.splitlines()[-1]


def test_both_aids_stand_in_words_in_one_row_of_eighty_columns() -> None:
    text = plain(aid_rows(seen(ghost=GHOST, predictor=AHEAD), 80))
    assert text == " off the ghost 2.0 m higher, 3.0 right, 1.5 up  in 60 s 72.0 m 010 6.0 down"
    assert len(text) <= 80
    panel = plain(trainee(seen(ghost=GHOST, predictor=AHEAD), 80, 17))
    assert "off the ghost 2.0 m higher" in panel


def test_the_ghost_is_dotted_and_the_way_ahead_goes_on_beyond_now() -> None:
    ghost = GHOST | {"depth": "66.0"}
    drawn = strip(0, seen(ghost=ghost, predictor=AHEAD), 120.0, 80, 10)
    assert "·· 66.0" in plain(drawn[:1])
    inks = {ink for line in drawn[1:-1] for _, ink in line}
    assert {"plain", "good"} <= inks
    dots = [sign for line in drawn[1:-1] for text, ink in line if ink == "dim" for sign in text]
    assert sum("\u2800" < sign <= "\u28ff" for sign in dots) > 10
    axis = plain(drawn[-1:])
    assert axis.index("now") < axis.index("╌")
    ahead = [text for line in drawn[1:-1] for text, ink in line if ink == "good"]
    assert sum(map(len, ahead)) > 10


def test_a_heading_ahead_is_drawn_the_short_way_round() -> None:
    drawn = plain(strip(1, seen(ghost=GHOST, predictor=AHEAD), 120.0, 80, 10))
    scale = [row[:6].strip() for row in drawn.splitlines()[1:-1] if row[:6].strip()]
    low, high = min(map(int, scale)), max(map(int, scale))
    assert min((high - low) % 360, (low - high) % 360) <= 40
    assert high - low > 180  # the chart goes through north


def test_a_way_is_interpolated_between_its_points() -> None:
    assert interpolated_way([(5.0, 10.0), (10.0, 20.0)], 4) == [10.0, 10.0, 15.0, 20.0]


def test_the_ghosts_past_is_asked_for_once_when_it_comes() -> None:
    line = ScriptedLine()
    model = SessionModel(line, "trainee", LAYOUTS["trainee"].charts)
    for tick in range(40):
        show(line, tick, ghost=GHOST if tick > 20 else dict.fromkeys(GHOST, ""))
    model.hear()
    assert line.orders.count("history ghost 60 min") == 1
    before = [each and each.ghost for each in model.charts.trace.series(0, 19.5, 40)]
    assert before[:21] == [None] * 21
    model.charts.trace.recall_ghost([(0.0, [50.0, 1.0]), (5.0, [55.0, 2.0])])
    after = [each and each.ghost for each in model.charts.trace.series(0, 19.5, 40)]
    assert after[0] == 50.0
    assert after[20] == 55.0
    assert after[21] == 62.0


def test_while_the_way_is_shown_the_first_line_and_the_orders_line_say_so() -> None:
    told = {"told": "shown: bell astern full"}
    model = seen(time=TIME | {"shown": "yes"}, orders=told)
    assert "THE WAY SHOWN" in plain(top(model, 80, 1))
    assert plain([order_line(model, 80)]) == " shown: bell astern full"
    assert "THE WAY SHOWN" not in plain(top(seen(time=TIME | {"shown": "no"}), 80, 1))


@pytest.mark.parametrize(
    ("act", "channels", "words"),
    [
        (PlainAction.SHOW, {"time": TIME | {"shown": "no"}}, "demonstrate"),
        (PlainAction.SHOW, {"time": TIME | {"shown": "yes"}}, "demonstrate off"),
        (PlainAction.GHOST, {}, "ghost on"),
        (PlainAction.GHOST, {"ghost": GHOST}, "ghost off"),
        (PlainAction.PREDICT, {"predictor": dict.fromkeys(AHEAD, "")}, "predictor 60 s"),
        (PlainAction.PREDICT, {"predictor": AHEAD}, "predictor off"),
    ],
)
def test_a_key_switches_an_aid_on_and_off_again(
    act: PlainAction, channels: dict[str, dict[str, str]], words: str
) -> None:
    assert KeyOrders(seen(**channels)).make(act) == words
    assert act in SWITCH_ORDERS
    assert act in [key.act for key in KEYS["trainee"]]


def test_a_key_asks_for_a_hint_and_the_briefing_has_its_price() -> None:
    acts = {name: key.act for key in KEYS["trainee"] for name in key.names}
    assert acts["f8"] == OrderAction("hint")
    model = seen()
    assert "hint" not in plain(briefing_rows(model))
    model.exercise.values["hint"] = "5"
    assert "a hint costs    5 marks" in plain(briefing_rows(model))
