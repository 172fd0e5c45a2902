"""What is said in a control room, as orders."""

import pytest
from helpers.document_tables import as_tokens
from helpers.orders import read_order

from trainer.io.orders.grammar import BadOrder, parse, to_the_crew
from trainer.io.orders.phrases import (
    ANY_DIGIT,
    PHRASES,
    PHRASES_BY_WORD,
    numerals,
    pattern,
    plain_text,
)
from trainer.io.orders.schedule import parse_schedule

SAID = [
    ("hard a starboard", "rudder right full"),
    ("port full", "rudder left full"),
    ("Right ten degrees rudder", "rudder right 10"),
    ("starboard ten", "rudder right 10"),
    ("port twenty-five", "rudder left 25"),
    ("ease to five degrees", "rudder ease 5"),
    ("ease the rudder to 5", "rudder ease 5"),
    ("shift", "rudder shift"),
    ("all ahead one third", "bell ahead one-third"),
    ("all ahead flank", "bell ahead flank"),
    ("all back one third", "bell astern one-third"),
    ("full astern", "bell astern full"),
    ("bell back full", "bell astern full"),
    ("full ahead", "bell ahead full"),
    ("pitch 5 down", "order pitch 5 down"),
    ("bubble up 5", "order pitch 5 up"),
    ("all astern full", "bell astern full"),
    ("stern planes ten degrees dive", "stern planes dive 10"),
    ("sail planes full rise", "bow planes rise full"),
    ("fairwater planes 5 rise", "bow planes rise 5"),
    ("rudder 0", "rudder amidships"),
    ("pump depth control 2", "pump depth-control 2 t"),
    ("pump three tonnes from aft to forward", "pump trim forward 3 t"),
    ("shut the main vents", "vent all shut"),
    ("up scope", "scope raise"),
    ("raise the periscope", "scope raise"),
]
BOTH = [  # by a station, by who orders the crew
    ("come left to zero four five", "course left to 045", "order course left 045"),
    ("take her down to 75", "depth 75 m", "order depth 75 m"),
    ("bring the boat up to 100 ft", "depth 100 ft", "order depth 100 ft"),
    ("left to 045", "course left to 045", "order course left 045"),
    ("turn left to 045", "course left to 045", "order course left 045"),
    ("come right to three six zero", "course right to 000", "order course right 000"),
    ("steer course one eight zero", "course 180", "order course 180"),
    ("make your depth sixty", "depth 60 m", "order depth 60 m"),
    ("ordered depth 60", "depth 60 m", "order depth 60 m"),
    ("ascend to 100 ft", "depth 100 ft", "order depth 100 ft"),
    ("come to 200ft", "depth 200 ft", "order depth 200 ft"),
    ("come up to periscope depth", "periscope depth", "order periscope depth"),
    ("5 up angle", "order pitch 5 up", "order pitch 5 up"),
]
WRONG = [
    ("left 045", "left to 045"),
    ("turn left", "say rudder left 10, course left 10 or course left to 045"),
    ("come right 20 degrees", "say rudder right 20, course right 20 or course right to 045"),
    ("pitch 5", "say pitch 5 up or pitch 5 down"),
    ("right to port 045", ""),
    ("come to 60", "come to 045"),
    ("come to 361", "0 to 360"),
    ("steady on forty five", "steady on 045"),
    ("left 95", "0 to 90 deg"),
    ("right rudder", ""),
    ("hard to port", "hard"),
    ("ease to", "ease"),
    ("ease to left", "ease to 5"),
    ("shift your planes", "shift your rudder"),
    ("down 50", "did you mean depth?"),
    ("planes down", "which planes? say stern planes or bow planes"),
    ("stern planes down 5", "did you mean stern planes dive 5?"),
    ("what now", "say hint, which tells what to order now"),
    ("flood aft", "auxiliary or depth-control; did you mean pump trim aft or drain aft?"),
    ("pump forward", "did you mean pump trim forward or drain forward?"),
    ("fire", '"fire" is no order; did you mean fight fire?'),
    ("depth gauge stuck", "did you mean casualty depth-gauge-stuck?"),
    ("a 30 depth 80", "did you mean at 30 s depth 80 m?"),
    ("i 2 min course 090", "did you mean in 2 min course 090?"),
    ("sea depth", "expected state, wind, height, from or calm"),
    ("all ahead three thirds", "all ahead two thirds"),
    ("all ahead slow", ""),
    ("all halt", "all stop"),
    ("back flank", "back full"),
    ("make turns 8 knots", "make turns for 8 knots"),
    ("make turns for knots", "make turns for 8 knots"),
    ("make your depth", "make your depth 60 metres"),
    ("make your depth 9000", "0 to 2000 m"),
    ("five degrees bubble", "five degrees down bubble"),
    ("5 down", ""),
    ("stern planes 10", "stern planes dive or stern planes rise"),
    ("10 dive on the rudder", ""),
    ("flood control 2 tonnes", ""),
    ("pump 3 forward", "pump"),
    ("blow everything", ""),
]


@pytest.mark.parametrize(("said", "text"), SAID)
def test_a_phrase_works_its_control_whoever_says_it(said: str, text: str) -> None:
    assert read_order(said).text == text
    assert to_the_crew(read_order(said)).text == text


@pytest.mark.parametrize(("said", "works", "orders"), BOTH)
def test_a_phrase_that_says_where_to_go_is_an_order_to_the_crew_from_who_may_give_one(
    said: str, works: str, orders: str
) -> None:
    assert read_order(said).text == works
    assert to_the_crew(read_order(said)).text == orders


@pytest.mark.parametrize(("said", "hint"), WRONG)
def test_a_doubtful_phrase_is_refused_with_the_nearest(said: str, hint: str) -> None:
    found = parse(said)
    assert isinstance(found, BadOrder), found
    assert hint in found.reason


def test_every_row_has_an_example_of_its_own_that_no_other_row_takes() -> None:
    for phrase in PHRASES:
        text = plain_text(as_tokens(phrase.example))
        taken = [row for row in PHRASES if pattern(row.pattern).fullmatch(f"{text} ")]
        assert taken == [phrase]
        assert to_the_crew(read_order(phrase.example)).text


def test_a_phrase_is_looked_for_among_those_of_its_first_word() -> None:
    for words in (*(words for words, _ in SAID), *(phrase.example for phrase in PHRASES)):
        text = plain_text(as_tokens(words))
        first = ANY_DIGIT if text[0].isdigit() else text.partition(" ")[0]
        tried = PHRASES_BY_WORD.get(first, [])
        fitting = [row for row in PHRASES if pattern(row.pattern).fullmatch(f"{text} ")]
        assert [row for row in tried if row in fitting] == fitting, words
    assert max(len(rows) for rows in PHRASES_BY_WORD.values()) < len(PHRASES) / 5


@pytest.mark.parametrize(
    ("words", "digits"),
    [
        ("zero four five", "045"),
        ("three six zero", "360"),
        ("forty five", "45"),
        ("zero forty five", "045"),
        ("ninety", "90"),
        ("nineteen", "19"),
        ("one eighty", "180"),
        ("two hundred", "200"),
        ("one hundred and fifty", "150"),
        ("one hundred five", "105"),
        ("niner", "9"),
        ("hundred", "hundred"),
        ("ten degrees", "10 degrees"),
    ],
)
def test_numbers_may_be_words(words: str, digits: str) -> None:
    assert " ".join(numerals(words.split())) == digits


def test_a_schedule_orders_the_crew() -> None:
    (entry,) = parse_schedule("60 come left to 045\n", "x")  # type: ignore[misc]
    assert entry.order.text == "order course left 045"
