"""The order grammar: words and units in, orders or reasons out."""

import math
import re
from collections.abc import Iterable

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from trainer.io.lines import LineDecoder
from trainer.io.orders import grammar
from trainer.io.orders.grammar import (
    FORM_READINGS,
    MAX_LINE_LETTERS,
    BadOrder,
    Order,
    TokenReading,
    match_slot,
    parse,
    tokenise,
)
from trainer.io.orders.help import HELP_WIDTH, help_text
from trainer.io.orders.schedule import BadSchedule, ScheduledOrder, parse_schedule
from trainer.io.orders.table import (
    FORMS,
    HELP_TOPICS,
    MEANT_ORDERS,
    SESSION_TOPIC,
    Slot,
    Word,
    heading_word,
    read_slot,
)
from trainer.io.orders.words import BOAT_TOPICS, SESSION_TOPICS

KNOT = 1852 / 3600
DEG = math.pi / 180

UNDERSTOOD = [
    ("depth 80", "depth", 80.0, "", "depth 80 m"),
    ("DEPTH 80 Metres", "depth", 80.0, "", "depth 80 m"),
    ("depth 260 ft", "depth", 79.248, "", "depth 260 ft"),
    ("dep 80m", "depth", 80.0, "", "depth 80 m"),
    ("depth auto", "depth", 0.0, "auto", "depth auto"),
    ("course 090", "course", 90 * DEG, "", "course 090"),
    ("heading 45.5", "course", 45.5 * DEG, "", "course 045.5"),
    ("course 360", "course", 0.0, "", "course 000"),
    ("course left 30", "course-by", -30 * DEG, "", "course left 30"),
    ("co starboard 30", "course-by", 30 * DEG, "", "course right 30"),
    ("speed 6 m/s", "speed", 6.0, "", "speed 6 m/s"),
    ("turns -4", "turns", -4 * KNOT, "", "turns -4 kn"),
    ("rpm -80", "rpm", -80 / 60, "", "rpm -80"),
    ("bell ahead one-third", "bell", 0.0, "ahead_one_third", "bell ahead one-third"),
    ("ahead 2/3", "bell", 0.0, "ahead_two_thirds", "bell ahead two-thirds"),
    ("ahead one third", "bell", 0.0, "ahead_one_third", "bell ahead one-third"),
    ("bell astern 1/3", "bell", 0.0, "astern_one_third", "bell astern one-third"),
    ("bell stop", "bell", 0.0, "stop", "bell stop"),
    ("rudder port 15 deg", "rudder", -15 * DEG, "", "rudder left 15"),
    ("ru r 15", "rudder", 15 * DEG, "", "rudder right 15"),
    ("rudder midships", "rudder", 0.0, "amidships", "rudder amidships"),
    ("rudder zero", "rudder", 0.0, "amidships", "rudder amidships"),
    ("rudder manual", "rudder", 0.0, "manual", "rudder manual"),
    ("rudder left full", "rudder", -90 * DEG, "full", "rudder left full"),
    ("hard right", "rudder", 90 * DEG, "full", "rudder right full"),
    ("sea state 5", "sea", 5.0, "state", "sea state 5"),
    ("sea height 10 ft", "sea", 3.048, "height", "sea height 10 ft"),
    ("sea from 45", "sea", 45 * DEG, "from", "sea from 045"),
    ("periscope", "periscope", 0.0, "", "periscope depth"),
    ("em blow", "emergency", 0.0, "blow", "emergency blow"),
    ("vent all open", "vent", 0.0, "all_open", "vent all open"),
    ("flood depth-control 2 t", "flood", 2000.0, "depth_control", "flood depth-control 2 t"),
    ("pump aux 1.5", "pump", 1500.0, "auxiliary", "pump auxiliary 1.5 t"),
    ("pump trim forward 3", "pump", 3000.0, "trim_forward", "pump trim forward 3 t"),
    ("drain center", "drain", 0.0, "centre", "drain centre"),
    ("hover on", "hover", 0.0, "on", "hover on"),
    ("hover 60", "hover", 60.0, "", "hover 60 m"),
    ("aye aye aye", "aye", 0.0, "", "aye"),
    ("stern rise 2.50", "stern", 2.5 * DEG, "", "stern planes rise 2.5"),
    ("stern planes zero", "stern", 0.0, "zero", "stern planes zero"),
    ("fairwater planes rise 5", "bow", 5 * DEG, "", "bow planes rise 5"),
    ("sail auto", "bow", 0.0, "auto", "bow planes auto"),
    ("lever dive 8", "lever", -8 * DEG, "", "lever dive 8"),
    ("lev rise 2.5", "lever", 2.5 * DEG, "", "lever rise 2.5"),
    ("sail planes dive full", "bow", -90 * DEG, "full", "bow planes dive full"),
    ("rudder ease 5", "rudder", 5 * DEG, "ease", "rudder ease 5"),
    ("course left to 090", "course-to", -90 * DEG, "to", "course left to 090"),
    ("course steady", "course", 0.0, "steady", "course steady"),
    ("order course 360", "order", 0.0, "course", "order course 000"),
    ("order course port 45", "order", 45 * DEG, "course_left", "order course left 045"),
    ("order depth 200 feet", "order", 60.96, "depth", "order depth 200 ft"),
    ("order periscope", "order", 0.0, "periscope", "order periscope"),
    ("order pitch 5 down", "order", 5 * DEG, "pitch_down", "order pitch 5 down"),
    ("order pitch zero", "order", 0.0, "pitch_zero", "order pitch zero"),
    ("order clear all", "order", 0.0, "clear_all", "order clear all"),
    ("belay", "belay", 0.0, "", "belay"),
    ("belay course", "belay", 0.0, "course", "belay course"),
    ("ack 3", "ack", 3.0, "", "ack 3"),
    ("autopilot literal", "autopilot", 0.0, "literal", "autopilot literal"),
    ("step", "step", 1.0, "", "step"),
    ("step 20", "step", 20.0, "", "step 20"),
    ("time x2", "time", 2.0, "", "time 2"),
    ("help", "help", 0.0, "", "help"),
    ("help heading", "help", 0.0, "course", "help course"),
    ("help jam", "help", 0.0, "casualty", "help casualty"),
    ("help deeper", "help", 0.0, "depth", "help depth"),
    ("help help", "help", 0.0, "help", "help help"),
    ("exit", "quit", 0.0, "", "quit"),
    ("depth 80 # for the exercise", "depth", 80.0, "", "depth 80 m"),
    ("freeze tanks", "hold", 0.0, "tanks", "freeze tanks"),
    ("release pos", "release", 0.0, "position", "release position"),
    ("backtrack 90", "backtrack", 90.0, "", "backtrack 90 s"),
    ("backtrack 2 minutes", "backtrack", 120.0, "", "backtrack 2 min"),
    ("role diving officer", "role", 0.0, "diving", "role diving"),
    ("role officer", "role", 0.0, "diving", "role diving"),
    ("bye", "detach", 0.0, "", "detach"),
]


def test_an_order_is_understood() -> None:
    faults = [
        f"{line}: {order}"
        for line, name, value, word, text in UNDERSTOOD
        for order in [parse(line)]
        if not isinstance(order, Order)
        or (order.name, order.word, order.text) != (name, word, text)
        or order.value != pytest.approx(value, rel=1e-15)
    ]

    assert not faults


MISTYPED = [
    ("dpeth 80", "did you mean depth?"),
    ("go deeper", "did you mean depth?"),
    ("go deepr", "did you mean depth?"),
    ("go zzz", '"go" is no order; help lists them'),
    ("go", "did you mean run?"),
    ("go left", "rudder or course? say rudder left 10, course left 10"),
    ("help left", "did you mean rudder or course?"),
    ("broken", "help lists them"),  # a word that begins otherwise is not offered
    ("pause", "did you mean freeze?"),
    ("break stern planes", "did you mean casualty?"),
    ("sea wind 101", "0 to 100 kn"),
    ("sea state 5.5", "has no decimals"),
    ("sea sideways", "expected state, wind, height, from or calm"),
    ("flood auxiliary -5", "takes no sign"),
    ("dive 80", '"80" is too much after "dive"'),
    ("vent a open", '"a" may be aft or all'),
    ("c auto", '"c" may be casualty, clear, contact or course'),
    ("rudder lefy 15", "did you mean left?"),
    ("rudder 15", "rudder left or rudder right"),
    (
        "rudder",
        "ease, shift, meet, manual, auto, normal, emergency or hand",
    ),
    ("rudder right -15", "takes no sign"),
    ("rudder right 91", "91: an angle is 0 to 90 deg"),
    ("stern 10", "stern planes dive or stern planes rise"),
    ("order pitch 5", "say pitch 5 up or pitch 5 down"),
    ("allow course", "expected rudder, planes, speed or ballast"),
    ("ack", "expected the number of an alert"),
    ("planes dive 10", "say stern planes or bow planes"),
    ("stop", "bell stop, freeze or quit"),
    ("ru", '"ru" may be rudder or run'),
    ("r 80", '"r" may be replay, rpm or rudder'),
    ("snapshot", "snapshot what? expected a name for a moment"),
    ("snapshots first", '"first" is too much after "snapshots"'),
    (
        "snapshot Before the Jam",
        '"the" is too much after "snapshot before"; a name is one word, such as before-the-jam',
    ),
    ("restore 5", "expected a name for a moment"),
    ("backtrack 25 h", "expected s or min"),
    ("backtrack 0", "0 s: a time back is 0.1 to 86400 s"),
    ("replay 1441 min", "1441 min: a time back is 0.1 to 86400 s"),
    ("subscribe diving at 51", "a rate is 0.1 to 50 hz"),
    ("subscribe diving 5", "expected at"),
    (
        "role captain",
        "planes, pilot, ballast, diving, deck, observer, visitor, scope, trainee or class",
    ),
    ("s d 10", '"s" may be sail or stern'),
    ("depth 80 fathoms", "expected m or ft"),
    ("depth 7000 ft", "7000 ft: a depth is 0 to 2000 m"),
    ("depth -5", "takes no sign"),
    ("depth nan", "expected a depth (0 to 2000 m) or auto"),
    ("depth 1e9", "not a plain decimal number"),
    ("depth 1.0000000001", "at most 9 decimals"),
    ("speed 61", "0 to 60 kn"),
    ("rudder 20 left", '"left" after "rudder 20"; did you mean rudder left 20?'),
    ("35 left rudder", '"35 left rudder" is no order; did you mean rudder left 35?'),
    ("80 depth", '"80 depth" is no order; did you mean depth 80 m?'),
    ("dive 10 stern", '"dive 10 stern" is no order; did you mean stern planes dive 10?'),
    ("rudder 500 deg left", "did you mean rudder left 500 deg? 500: an angle is 0 to 90 deg"),
    ("course 045 left", '"left" after "course 045"; did you mean course left to 045?'),
    ("order course 045 left", "did you mean order course left 045?"),
    ("step 2.5", "has no decimals"),
    ("step 20 m", '"m" is too much after "step 20"'),
    ("depth 80\x1b[A", "U+001B cannot be sent"),
    ("depth 80°", '"°" (U+00B0) cannot be sent; type plain letters'),
    ("depth ٨٠", "(U+0668) cannot be sent"),
    ("d" * 81, "81 characters; the longest is 80"),
]


def test_a_bad_order_says_why() -> None:
    faults = [
        f"{line!r}: {bad}"
        for line, reason in MISTYPED
        for bad in [parse(line)]
        if not isinstance(bad, BadOrder)
        or reason not in bad.reason
        or not bad.text.isascii()
        or not bad.text.isprintable()
    ]

    assert not faults


@pytest.mark.parametrize("line", ["", "   \t", "# only a comment", "\r\n"])
def test_a_blank_line_is_no_order_and_no_error(line: str) -> None:
    assert parse(line) is None


def test_a_line_of_the_longest_length_is_read() -> None:
    assert isinstance(parse("depth 80 #".ljust(MAX_LINE_LETTERS, "x")), Order)


@given(st.text(max_size=100) | st.text(alphabet=" $*#.,-+1/3adehopstu", max_size=100))
def test_no_text_makes_the_parser_raise(text: str) -> None:
    assert isinstance(parse(text), Order | BadOrder | None)


@given(st.binary(max_size=300))
def test_no_bytes_make_the_parser_raise(data: bytes) -> None:
    for line in LineDecoder().feed(data + b"\n"):
        assert not isinstance(line, str) or isinstance(parse(line), Order | BadOrder | None)


def test_bytes_that_are_no_text_are_refused() -> None:
    (line,) = LineDecoder().feed(b"depth\xc3 80\n")

    assert isinstance(line, str)
    assert "U+FFFD" in getattr(parse(line), "reason", "")


NUMBERS = st.decimals(min_value=-60, max_value=2000, places=3).map(str)
WORDS = st.sampled_from(
    sorted({word for line, *_ in UNDERSTOOD for word in line.split()} | {"m", "ft", "kn"})
)


@pytest.mark.long
@given(st.lists(WORDS | NUMBERS, min_size=1, max_size=5), st.sampled_from(UNDERSTOOD), NUMBERS)
@settings(max_examples=300)
def test_the_full_wording_reads_back_as_the_same_order(
    words: list[str], row: tuple[str, ...], number: str
) -> None:
    head = row[0].split("#")[0].split()
    for line in (" ".join(words), " ".join([*head[:-1], number]), row[0]):
        order = parse(line)
        if isinstance(order, Order) and not (order.name == "role" and order.subject):
            assert parse(order.text) == order


def test_no_order_typed_in_full_is_in_doubt() -> None:
    topics = read_slot("TOPIC")
    assert isinstance(topics, Word)
    heads = [said for said, _ in topics.spellings] + ["ahead", "astern", "full", "hard"]

    for head in heads:
        assert "may be" not in getattr(parse(head), "reason", ""), head


@given(st.sampled_from(UNDERSTOOD), st.data())
def test_a_shortened_order_means_the_same_or_is_refused(
    row: tuple[str, ...], data: st.DataObject
) -> None:
    whole = row[4]
    cut = " ".join(
        word[: data.draw(st.integers(1, len(word)))] if word[0].isalpha() else word
        for word in whole.split()
    )

    short = parse(cut)

    # Units cannot be cut: "k" is no knot and "m" is no m/s, so both may be refused; nothing else is
    # ever understood instead.
    assert short == parse(whole) or isinstance(short, BadOrder)


def test_a_line_is_compared_with_the_orders_of_its_first_word_alone(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    compared: list[Slot] = []

    def listed(head: Slot, token: str) -> Iterable[TokenReading]:
        compared.append(head)
        return match_slot(head, token)

    monkeypatch.setattr(grammar, "match_slot", listed)
    for first in ("rudder", "rud", "course", "co", "depth"):
        compared.clear()
        parse(first)
        assert compared
        for head in compared:
            assert isinstance(head, Word)
            assert any(said.startswith(first) for said, _ in head.spellings), (first, head)


@given(st.sampled_from([row[0] for row in UNDERSTOOD] + sorted(MEANT_ORDERS)), st.data())
@settings(max_examples=300)
def test_an_answer_is_the_one_that_all_orders_together_give(line: str, data: st.DataObject) -> None:
    letters = st.text(st.sampled_from("abcdefghijklmnopqrstuvwxyz0123456789-/ "), max_size=2)
    begin = data.draw(st.integers(0, len(line)))
    end = data.draw(st.integers(begin, min(begin + 2, len(line))))
    mistyped = line[:begin] + data.draw(letters) + line[end:]
    answer = parse(mistyped)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(
            grammar,
            "HEAD_READINGS",
            grammar.HEAD_READINGS | dict.fromkeys(tokenise(mistyped)[:1], FORM_READINGS),
        )
        assert parse(mistyped) == answer


def test_what_people_say_first_is_no_order_and_leads_to_one() -> None:
    heads = {heading_word(form) for form in FORMS}
    assert {each for meant in MEANT_ORDERS.values() for each in meant.split(" or ")} <= heads
    for said in MEANT_ORDERS:
        found = parse(said)
        assert isinstance(found, BadOrder), found
        meant = "right rudder 10" if said == "right" else MEANT_ORDERS[said]  # a phrase is nearer
        assert found.reason == f'"{said}" is no order; did you mean {meant}?'


@pytest.mark.parametrize("topic", ["", SESSION_TOPIC])
def test_a_list_of_orders_fits_a_small_screen(topic: str) -> None:
    assert len(help_text(topic)) <= 24


def test_help_is_narrow_and_plain() -> None:
    topics = ["", SESSION_TOPIC, *HELP_TOPICS]
    faults = [
        f"{topic}: {line}"
        for topic in topics
        for line in help_text(topic)
        if len(line) > HELP_WIDTH or not line.isascii()
    ]

    assert not faults


def test_help_on_an_order_shows_every_wording() -> None:
    missing = [
        f"{heading_word(form)}: {form.says}"
        for form in FORMS
        if not form.refusal and not any(form.says in line for line in help_text(heading_word(form)))
    ]

    assert not missing


def test_help_on_an_unknown_order_names_the_nearest() -> None:
    assert help_text("ruder") == ['no order "ruder"; did you mean rudder?']


@pytest.mark.parametrize(
    ("line", "subject", "word", "numbers"),
    [
        ("casualty stern-jam", "stern-jam", "", ()),
        ("CASUALTY stern-jam 0.50", "stern-jam", "", (0.5,)),
        ("casualty stern-jam ramp 30 s", "stern-jam", "ramp", (30.0,)),
        ("casualty stern-jam -1 ramp 30", "stern-jam", "ramp", (-1.0, 30.0)),
        ("subscribe diving at 10hz", "diving", "at", (10.0,)),
        ("snapshot before-jam", "before-jam", "", ()),
        ("snap before-jam", "before-jam", "", ()),
        ("REPORT  Stern planes jammed, 6 dive", "Stern planes jammed, 6 dive", "", ()),
        ("Course 045, aye", "course 045", "", ()),
    ],
)
def test_an_order_with_a_name_holds_it_and_its_numbers(
    line: str, subject: str, word: str, numbers: tuple[float, ...]
) -> None:
    order = parse(line)

    assert isinstance(order, Order)
    assert (order.subject, order.word, order.numbers) == (subject, word, numbers)
    assert parse(order.text) == order


def test_a_rate_is_the_value_of_a_subscription() -> None:
    assert getattr(parse("subscribe diving at 2"), "value", None) == 2.0
    assert getattr(parse("subscribe diving"), "value", None) == 0.0


@pytest.mark.parametrize("words", ["role helm", "ROLE Helm", "ro h", "role diving officer"])
@pytest.mark.parametrize("token", ["Se-cRet1", "12ab", "0x", "***", "role", "helm"])
def test_a_token_is_kept_as_it_was_typed_and_told_nowhere(words: str, token: str) -> None:
    order = parse(f"{words} {token}  # mine")

    assert isinstance(order, Order)
    assert order.name == "role"
    assert order.subject == token
    assert order.text in ("role helm", "role diving")
    assert "subject" not in repr(order)


@pytest.mark.parametrize(
    "line",
    [
        "role hlem Se-cRet1",
        "roel diving Se-cRet1",
        "role helm Se-cRet1 Se-cRet1",
        "role helm Se-cRet1\x01",
        "r hell Se-cRet1",
        f"role helm Se-cRet1{' ' * 80}.",
    ],
)
def test_a_token_in_a_line_that_is_no_order_is_told_nowhere(line: str) -> None:
    bad = parse(line)

    assert isinstance(bad, BadOrder)
    assert "se-cret1" not in f"{bad.text} {bad.reason}".lower()


@pytest.mark.parametrize(
    ("line", "whole"),
    [
        ("i 5 surface", "in 5 s surface"),
        ("a 30 s surface", "at 30 s surface"),
        ("when depth>60 then surf", "when depth>60 then surface"),
        ("wh i surface", "what if surface"),
    ],
)
def test_an_order_that_holds_another_may_be_cut_short(line: str, whole: str) -> None:
    assert parse(line) == parse(whole)
    assert isinstance(parse(whole), Order)


@pytest.mark.parametrize("line", ["i 5 foo", "a 30 belay", "whe x then foo", "what i order"])
def test_an_order_that_holds_none_is_refused_cut_short_too(line: str) -> None:
    assert isinstance(parse(line), BadOrder)


def test_every_example_of_the_overview_is_an_order() -> None:
    for topic in BOAT_TOPICS + SESSION_TOPICS:
        assert isinstance(parse(topic.example.partition("|")[0]), Order), topic


def test_a_schedule_is_sorted_by_time_and_keeps_the_order_of_the_file() -> None:
    text = "\ufeff# test\r\n600 rudder right 15\n\n0.5 depth 80 # first\n600 freeze\n"

    schedule = parse_schedule(text, "orders.txt")

    assert isinstance(schedule, list)
    assert all(isinstance(entry, ScheduledOrder) for entry in schedule)
    assert [(e.seconds, e.order.text, e.line_number) for e in schedule] == [
        (0.5, "depth 80 m", 4),
        (600.0, "rudder right 15", 2),
        (600.0, "freeze", 5),
    ]


@pytest.mark.parametrize(
    ("line", "reason"),
    [
        ("12 rudder lefy 3", "orders.txt:2: .*did you mean left"),
        ("rudder left 3", "orders.txt:2: a line is SECONDS ORDER"),
        ("-1 freeze", "SECONDS ORDER"),
        ("1e3 freeze", "SECONDS ORDER"),
        ("1000001 freeze", "latest time is 1000000 s"),
        (f"12 {'d' * 81}", "longest is 80"),
    ],
)
def test_a_bad_schedule_names_file_line_and_reason(line: str, reason: str) -> None:
    bad = parse_schedule(f"1 freeze\n{line}\n2 run\n", "orders.txt")

    assert isinstance(bad, BadSchedule)
    assert re.search(reason, str(bad))


@given(st.text())
def test_no_text_makes_the_schedule_raise(text: str) -> None:
    assert isinstance(parse_schedule(text, "x"), list | BadSchedule)
