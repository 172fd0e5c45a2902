"""Lines of programs: framed, checked, answered with their tag."""

import random
import tracemalloc

import pytest
from hypothesis import given
from hypothesis import strategies as st

from trainer.io.lines import LineDecoder, OverlongLine, line_bytes, plain
from trainer.io.orders import sentences
from trainer.io.orders.grammar import MAX_LINE_LETTERS, BadOrder, Order, parse, understood_order
from trainer.io.orders.sentences import (
    Message,
    Sentence,
    checksum,
    order_sentence,
    parse_line,
    parse_sentence,
)


def framed(body: str) -> str:
    return f"${body}*{checksum(body):02X}"


def test_the_checksum_is_that_of_nmea_0183() -> None:
    # $GPGLL,5057.970,N,00146.110,E,142451,A*27, an example widely printed with the standard.
    assert checksum("GPGLL,5057.970,N,00146.110,E,142451,A") == 0x27


def test_a_program_and_a_person_say_the_same_words() -> None:
    line = order_sentence("rudder left 15")
    order = parse("rudder left 15")

    assert line == "$TRO,rudder left 15*6A"
    assert isinstance(order, Order)
    assert parse_line(line) == parse_line(line[:-2] + "6a\r\n") == Message(order, machine=True)
    assert parse_line("rudder left 15") == Message(order)


@pytest.mark.parametrize("line", ["", "   \t", "# only a comment", "\r\n"])
def test_a_blank_line_is_nothing(line: str) -> None:
    assert parse_line(line) is None


@pytest.mark.parametrize("tag", ["1", "07", "123456"])
def test_a_tag_is_heard_with_the_order_and_with_words_that_are_none(tag: str) -> None:
    good, bad = (
        parse_line(order_sentence("depth 80", tag)),
        parse_line(order_sentence("dpeth 80", tag)),
    )

    assert good
    assert good.tag == tag
    assert getattr(good.order, "text", "") == "depth 80 m"
    assert bad
    assert (bad.tag, bad.machine) == (tag, True)
    assert "did you mean depth?" in getattr(bad.order, "reason", "")


@pytest.mark.parametrize(
    ("line", "reason"),
    [
        ("$TRO,depth 80", "ends in * and the two digits"),
        ("$TRO,depth 80*00", "wrong checksum 00; this line's is 20"),
        ("$TRO,depth 80*202", "ends in * and the two digits"),
        (framed("TRX,depth 80"), "$TRO,[tag,]order*checksum"),
        (framed("TRO"), "$TRO,[tag,]order*checksum"),
        (framed("TRO,"), "a sentence without an order"),
        (framed("TRO,12,# no more"), "a sentence without an order"),
        (framed("TRO,1234567,depth 80"), "a tag is one to six digits"),
        (framed("TRO,,depth 80"), "a tag is one to six digits"),
        (framed("TRO,depth 80" + " " * MAX_LINE_LETTERS), "the longest is 80"),
        ("$TRO,depth \u0668*00", "plain ASCII"),
        ("$TRO,depth\t80*00", "plain ASCII"),
    ],
)
def test_a_damaged_sentence_says_what_is_wrong(line: str, reason: str) -> None:
    heard = parse_line(line)

    assert heard
    assert heard.machine
    assert isinstance(heard.order, BadOrder)
    assert heard.order.text.isascii()
    assert reason in heard.order.reason


def test_every_single_corrupted_character_is_noticed() -> None:
    line = order_sentence("depth 80", "12")

    for i in range(len(line)):
        corrupted = line[:i] + chr(ord(line[i]) ^ 1) + line[i + 1 :]
        heard = parse_line(corrupted)
        assert heard
        assert isinstance(heard.order, BadOrder), corrupted


def test_a_token_in_a_damaged_sentence_is_told_nowhere() -> None:
    for line in ("$TRO,12,role helm Secret1*00", "$TRO,role helm Secret1", "$X,role hlem Secret1*"):
        heard = parse_line(line)
        assert heard
        assert isinstance(heard.order, BadOrder)
        assert "ecret" not in repr(heard)


def test_a_token_with_a_role_arrives_as_it_was_sent() -> None:
    heard = parse_line(order_sentence("role helm Se-cRet1", "12"))

    assert heard
    assert getattr(heard.order, "subject", "") == "Se-cRet1"


# From the session


def test_answers_names_states_and_events_read_back() -> None:
    lines = [
        sentences.say("12", "a first line, with a comma"),
        sentences.answer("12", accepted=True, text="keeping depth 80 m"),
        sentences.answer("", accepted=False, text="this boat's greatest depth is 300 m, not 400 m"),
        sentences.names("diving", [("depth", "m"), ("pitch", "deg")]),
        sentences.state("diving", 120, 60.0, ["60.02", "-1.50"]),
        sentences.event(120, 60.0, "order", "helm: rudder left 15, by hand"),
    ]

    assert [parse_sentence(line) for line in lines] == [
        Sentence("TRA", "12", ("say", "a first line, with a comma")),
        Sentence("TRA", "12", ("ok", "keeping depth 80 m")),
        Sentence("TRA", "", ("no", "this boat's greatest depth is 300 m, not 400 m")),
        Sentence("TRN", "", ("diving", "depth:m", "pitch:deg")),
        Sentence("TRS", "", ("diving", "120", "60.000", "60.02", "-1.50")),
        Sentence("TRE", "", ("120", "60.000", "order", "helm: rudder left 15, by hand")),
    ]


def test_a_state_is_not_taken_for_one_with_a_tag() -> None:
    assert parse_sentence(sentences.state("7", 120, 60.0, ["1"])) == Sentence(
        "TRS", "", ("7", "120", "60.000", "1")
    )


@pytest.mark.parametrize(
    "line",
    [
        "",
        "keeping depth 80 m",
        "$TRA,ok,done*00",
        framed("TRA,ok"),
        framed("TRS,diving,12"),
        framed("TRE,1,0.5,order"),
        framed("TRO,depth 80"),
        framed("GPGLL,1,2,3,4"),
    ],
)
def test_what_is_no_whole_sentence_is_not_read(line: str) -> None:
    assert parse_sentence(line) is None


@given(st.text(max_size=200), st.from_regex(r"([0-9]{1,6})?", fullmatch=True), st.booleans())
def test_any_text_makes_a_sentence_that_reads_back(text: str, tag: str, accepted: bool) -> None:  # noqa: FBT001  drawn
    line = sentences.answer(tag, accepted=accepted, text=text)
    told = sentences.event(1, 0.5, text, text)

    assert line.isascii()
    assert line.isprintable()
    found, event = parse_sentence(line), parse_sentence(told)
    assert found
    assert (found.tag, found.fields[0]) == (tag, "ok" if accepted else "no")
    assert len(found.fields[1]) == len(text)
    assert event
    assert len(event.fields) == 4


def test_news_for_thirty_stations_is_framed_once(monkeypatch: pytest.MonkeyPatch) -> None:
    framed, frame = list[str](), sentences.frame

    def noted(kind: str, tag: str, content: str) -> str:
        framed.append(kind)
        return frame(kind, tag, content)

    monkeypatch.setattr(sentences, "frame", noted)
    told = [
        (sentences.fact(7, 3.5, "order", "depth 81"), sentences.event(7, 3.5, "order", "depth 81"))
        for _ in range(30)
    ]

    assert len(set(told)) == 1
    assert framed == ["TRF", "TRE"]


def test_a_comma_within_a_field_is_told_as_a_semicolon() -> None:
    found = parse_sentence(sentences.state("orders", 1, 0.5, ["mind the sea, come up", "2"]))
    assert found
    assert found.fields[3:] == ("mind the sea; come up", "2")


@given(
    st.text(max_size=100) | st.text(alphabet="$*,#TROASNE0123456789ABCDEF depthok.", max_size=90)
)
def test_no_text_makes_either_reader_raise(text: str) -> None:
    for line in (text, f"${text}*00", framed("TRO," + text.encode("ascii", "ignore").decode())):
        assert isinstance(parse_line(line), Message | None)
        assert isinstance(parse_sentence(line), Sentence | None)


# Noise


def noise(source: random.Random) -> bytes:
    """Return a line of garbage: raw bytes, a torn order, or words in the wrong places."""
    kind = source.random()
    if kind < 0.4:
        return source.randbytes(source.randrange(120)) + b"\n"
    good = source.choice(GOOD)
    if kind < 0.7:
        torn = bytearray(good)
        torn[source.randrange(len(torn))] = source.randrange(256)
        return bytes(torn[: source.randrange(len(torn) + 1)]) + b"\r\n"
    words = [word for _ in range(2) for word in source.choice(GOOD).split()]
    source.shuffle(words)
    return b" ".join(words) + b"\n"


GOOD = [
    *(b"depth 80", b"rudder left 15", b"casualty stern-jam 0.5 ramp 30", b"blow all", b"time x2"),
    *(b"role helm secret", b"subscribe diving at 5 hz", b"backtrack 2 min", b"bell ahead 2/3"),
    *(order_sentence("planes auto").encode(), order_sentence("stern rise 5", "123").encode()),
]


@pytest.mark.slow
@pytest.mark.parametrize("lines", [15_000, pytest.param(95_000, marks=pytest.mark.slow)])
def test_lines_of_noise_are_survived_in_flat_memory(lines: int) -> None:
    source = random.Random(1967)  # noqa: S311  noise, not a secret
    decoder = LineDecoder()
    heard = {Order: 0, BadOrder: 0, OverlongLine: 0}

    def feed(count: int) -> None:
        for _ in range(count):
            for line in decoder.feed(noise(source)):
                found = parse_line(line) if isinstance(line, str) else Message(BadOrder("", ""))
                kind = type(found.order) if found and isinstance(line, str) else type(line)
                heard[kind] = heard.get(kind, 0) + 1

    def kept() -> int:
        understood_order.cache_clear()  # which has what other tests ordered, and trades it for ours
        return tracemalloc.get_traced_memory()[0]

    feed(lines)
    tracemalloc.start()
    feed(1000)
    settled = kept()
    feed(4000)
    _, peak = tracemalloc.get_traced_memory()
    after = kept()
    tracemalloc.stop()

    assert min(heard[Order], heard[BadOrder], heard[OverlongLine]) > 300
    # the interpreter's own cache of names trades 16 to 25 kB for noise; 4000 lines have 250
    assert after - settled < 60_000
    assert peak < 500_000


@pytest.mark.parametrize(
    "words",
    ["TRS,motion,3,[[1]],60", "TRS,motion,x,1.5,60", "TRS,motion,3,nan,60", "TRE,3,1e5,time,over"],
)
def test_a_sentence_that_does_not_tell_when_in_numbers_is_none(words: str) -> None:
    assert parse_sentence(framed(words)) is None


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("depth 80", "depth 80"),
        ("Ünterseeboot", "Ünterseeboot"),
        ("\x1b[2J\x1b]0;x\x07", r"\x1b[2J\x1b]0;x\x07"),
        ("one\rtwo\ttwo\x7f\x9b1m", r"one\rtwo\ttwo\x7f\x9b1m"),
        ("a\u202eb\u2028c\u200bd\u2066e", r"a\u202eb\u2028c\u200bd\u2066e"),
    ],
)
def test_what_a_terminal_would_obey_is_made_visible(text: str, shown: str) -> None:
    assert plain(text) == shown


def test_no_line_that_comes_in_or_goes_out_moves_a_cursor() -> None:
    decoder = LineDecoder()
    (line,) = decoder.feed(b"hello \x1b[31mred\x1b]52;c;aGk=\x07\x9b\n")
    assert isinstance(line, str)
    assert line.startswith(r"hello \x1b[31mred\x1b]52;c;aGk=\x07")
    assert line_bytes("a\x1b[2J\u202eü") == rb"a\x1b[2J\u202e?"
