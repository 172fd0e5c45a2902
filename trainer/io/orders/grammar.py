"""The order grammar: one line of words to one order.

    line      = [ words ] [ "#" comment ]
    words     = an order of trainer.io.orders.table, any word of it cut short if no doubt arises

The grammar knows words and units, not the boat: the session decides whether an order can be
obeyed. How a program frames the words stands in trainer.io.orders.sentences.

A line may give a secret token with a role. No answer and no log repeats it. It is found by its
place in the line, before the words are understood, because those before it may be misspelt.
"""

import re
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import NamedTuple

from trainer.io.orders.nearest import join_names, kindred_orders, meant_order, nearest_word
from trainer.io.orders.phrases import meaning, nearest_phrase
from trainer.io.orders.quantities import NUMBER_KINDS, Number, RefusedError, Unit, quantity
from trainer.io.orders.table import (
    FORMS,
    GOING_WORDS,
    MEANT_ORDERS,
    NAME_SLOTS,
    SIDE_SIGNS,
    WORD_SETS,
    Form,
    Name,
    Secret,
    Slot,
    UnitWord,
    Word,
    heading_word,
    spellings,
    variants,
)
from trainer.io.orders.words import ORDER_WORDS

HIDDEN_TOKEN = "***"  # noqa: S105
ROLE_BEGINNINGS = "|".join(sorted({said[:2] for said, _ in spellings(WORD_SETS["ROLE"])}))
TOKEN_PATTERN = re.compile(
    r"((?:^|,|^\s*(?:in|at|when)\b.*\s)\s*"  # a planned one is refused, and hidden all the same
    # The word role cut short or misspelt counts too: "ro... WORD TOKEN", or "r... ROLE TOKEN".
    rf"r(?:o\S*\s+\S+|\S*\s+(?:{ROLE_BEGINNINGS})\S*)\s+)(\S.*?)\s*$",
    re.IGNORECASE,
)
HELP_HEAD = "help"
SIDE_WORDS = {"down": "dive", "up": "rise"}  # as they are said of planes
CREW_HEAD = "order"  # heads an order to the crew; the side of its course is a word of it
KEPT_ORDERS = 1024  # of the wordings that were understood last
MAX_LINE_LETTERS = 80  # [characters]  of a line, its comment included
MAX_MOVED_WORDS = 8  # of an order in which a word is looked for that stands too late
# the crew's `course left 90` is a course to come to; the autopilot's needs the word `to`
CREW_TURN_PATTERN = re.compile("^course (left|right)")
PRINTABLE_PATTERN = re.compile(r"[\t -~]*")
SPLIT_WORDS = (
    (re.compile(r"\b(one|two)\s+third", re.IGNORECASE), r"\1-third"),
    (re.compile(r"\bdiving\s+officer\b", re.IGNORECASE), "diving"),
)
GLUED_PATTERN = re.compile(r"([+-]?[0-9.]+)([a-z][a-z/]*)")
NAME_PATTERN = re.compile(r"[a-z][a-z0-9-]*")
DECIMAL_PATTERN = re.compile(r"[+-]?(?:[0-9]{1,9}(?:\.[0-9]*)?|\.[0-9]+)")
REMARK_PATTERN = re.compile(r"\s*(mark|tell|report|relief)\s+(\S.*?)\s*", re.IGNORECASE)
REPEAT_PATTERN = re.compile(r"\s*(?:(\S.*?)[\s,]+)??aye(?:[\s,]+aye)*\s*", re.IGNORECASE)
TIME_NUMBER = NUMBER_KINDS["TIME"]
TIME_UNITS = "|".join(name for unit in TIME_NUMBER.units for name in unit.names)
PLAN_PATTERN = re.compile(
    rf"\s*(?:(?P<at>in|at)\s+(?P<time>[-+.\d]\S*?)\s*(?P<unit>{TIME_UNITS})?"
    r"|when\s+(?P<condition>\S.*?)\s+then)\s+(?P<order>\S.*?)\s*",
    re.IGNORECASE,
)
WHAT_IF_PATTERN = re.compile(r"\s*what\s+if\s+(\S.*?)\s*", re.IGNORECASE)
ORDER_HEADS = {heading_word(form) for form in FORMS}
NAMING_HEADS = {heading_word(form) for form in FORMS if NAME_SLOTS.keys() & form.pattern.split()}


def hide_token(text: str) -> str:
    """Return `text` with a token in it hidden."""
    return TOKEN_PATTERN.sub(rf"\1{HIDDEN_TOKEN}", text)


def find_token(text: str) -> str:
    """Return the token in `text`, "" when there is none."""
    match = TOKEN_PATTERN.search(text)
    return match[2] if match else ""


@dataclass(frozen=True)
class Order:
    """An order understood.

    `value` is in SI and radians (rpm in revolutions a second), starboard and rise positive, 0 when
    there is none; `word` is the keyword the order turns on, "" when the value says it all; `text`
    is the full wording, which reads back as the same order; `numbers` are all that were
    given, in SI and unsigned, and `subject` is the name given. A token given with a role is the
    `subject` too, and never in `text`. `crew` is what a phrase means when it is given to the crew,
    where that is another order. `side` is -1 for left or dive, 1 for right or rise, 0 for neither;
    `unit` is that of the last number; `words` are the text without its numbers and names.
    """

    name: str
    value: float
    word: str
    text: str
    numbers: tuple[float, ...] = ()
    subject: str = field(default="", repr=False)  # no token in a traceback
    crew: str = field(default="", compare=False)
    side: float = field(default=0.0, compare=False)
    unit: Unit | None = field(default=None, compare=False)
    words: str = field(default="", compare=False)


@dataclass(frozen=True)
class BadOrder:
    """A line that is no order. It is printable, with the reason and the nearest order.

    Neither tells a token that the line held.
    """

    text: str
    reason: str


class TokenReading(NamedTuple):
    """The meaning of one token in one reading of the line."""

    spelling: str
    word: str


class PartialReading(NamedTuple):
    """One way to understand the tokens so far."""

    form: Form
    slots: tuple[Slot, ...]
    said: tuple[TokenReading, ...]


FORM_READINGS = tuple(PartialReading(form, slots, ()) for form in FORMS for slots in variants(form))


def openings() -> dict[str, list[PartialReading]]:
    """Return the readings of a line by its first word, whole or cut short."""
    readings: dict[str, list[PartialReading]] = {}
    for reading in FORM_READINGS:
        first = reading.slots[0]
        heads = {said for said, _ in first.spellings} if isinstance(first, Word) else set()
        for word in {said[:length] for said in heads for length in range(1, len(said) + 1)}:
            readings.setdefault(word, []).append(reading)
    return readings


HEAD_READINGS = openings()


def parse(line: str) -> Order | BadOrder | None:
    """Return the order on `line`, None when it is blank or a comment; never raises."""
    text = line.strip()
    try:
        said = readable(text).partition("#")[0]
        if remark := REMARK_PATTERN.fullmatch(said):
            name = remark[1].lower()
            return Order(name, 0.0, "", f"{name} {remark[2]}", (), remark[2])
        if (repeat := REPEAT_PATTERN.fullmatch(said)) and not find_token(said):
            words = (repeat[1] or "").lower()
            return Order("aye", 0.0, "", f"{words} aye".strip(), (), words)
        if plan := PLAN_PATTERN.fullmatch(said):
            return planned_order(plan)
        if supposed := WHAT_IF_PATTERN.fullmatch(said):
            return supposed_order(supposed[1])
        words = said
        for pattern, whole in SPLIT_WORDS:  # one in the table
            words = pattern.sub(whole, words)
        tokens = tokenise(hide_token(words))
        return read_whole(tokens, find_token(words)) if tokens else None
    except RefusedError as refused:
        return BadOrder(printable(text), str(refused))


def name_of(text: str) -> str:
    """Return the name of the order that words are, "" for none of this version."""
    return found.name if isinstance(found := parse(text), Order) else ""


def read_whole(tokens: list[str], token: str) -> Order | BadOrder | None:
    """Return the order of tokens; one whose head is cut short may hold another."""
    found = with_token(understood_order(*tokens), token)
    return parse(found.text) if found.name in ("plan", "what-if") else found


def planned_order(said: re.Match[str]) -> Order:
    """Return the order that plans another; refuses what is none, or cannot be planned."""
    if not isinstance(inner := parse(said["order"]), Order):
        raise RefusedError(inner.reason if inner else f"{said[0].strip()}: no order")
    inner = to_the_crew(inner)
    if not ORDER_WORDS[inner.name].planned:
        raise RefusedError(f"{inner.text} cannot be planned: give it when it is time")
    if said["condition"]:
        words = " ".join(said["condition"].lower().split())
        text = readable(f"when {words} then {inner.text}")  # written in full it may be too long
        return Order("plan", 0.0, "when", text, (), inner.text)
    head, digits = said["at"].lower(), said["time"].lower()
    if not DECIMAL_PATTERN.fullmatch(digits):
        raise RefusedError(
            f'"{digits}" after "{head}": expected {describe_slots([TIME_NUMBER])[0]}'
        )
    unit = next(each for each in TIME_NUMBER.units if (said["unit"] or "s").lower() in each.names)
    value, wording = quantity(TIME_NUMBER, digits, unit)
    text = readable(f"{head} {wording} {inner.text}")
    return Order("plan", value, head, text, (value,), inner.text)


def supposed_order(words: str) -> Order:
    """Return the question what another order would bring; refuses what is none."""
    if not isinstance(inner := parse(words), Order):
        raise RefusedError(inner.reason if inner else f"what if {words}: no order")
    return Order("what-if", 0.0, "", readable(f"what if {inner.text}"), (), inner.text)


@lru_cache(maxsize=KEPT_ORDERS)
def understood_order(*words: str) -> Order:
    """Return the order of the tokens, or of the phrase they are. Refuses what is neither.

    A debrief asks for the same few orders ten thousand times. A token is not among the words.
    """
    tokens = list(words)
    if tokens[0] == HELP_HEAD and MEANT_ORDERS.get(" ".join(tokens[1:])) in ORDER_HEADS:
        tokens = [HELP_HEAD, MEANT_ORDERS[tokens[1]]]
    try:
        return order(read_form(tokens))
    except RefusedError as refused:
        phrase = meaning(tokens)
        if phrase is None:
            goes = len(tokens) == 2 and tokens[0] in GOING_WORDS and tokens[1] in MEANT_ORDERS
            near = "" if goes or tokens[0] in ORDER_HEADS else nearest_phrase(tokens)
            reason = f'"{" ".join(tokens)}" is no order; did you mean {near}?'
            hint = (moved_word(tokens) if len(tokens) <= MAX_MOVED_WORDS else "") or meant_line(
                tokens
            )
            raise RefusedError(reason if near else hint or str(refused)) from None
    return replace(order(read_form(tokenise(phrase.order))), crew=phrase.crew)


def meant_line(tokens: list[str]) -> str:
    """Return the order that other words mean, as a hint; "" where none helps."""
    head, *rest = tokens
    said = f'"{" ".join(tokens)}" is no order;'
    if rest and head not in NAMING_HEADS and MEANT_ORDERS.get(tokens[-1]) == "casualty":
        return f"{said} did you mean casualty {'-'.join(tokens)}?"
    heads = (each for each in ("in", "at", "when") if each.startswith(head) and each != head)
    plans = [parse(" ".join((each, *rest))) for each in heads]
    if planned := next((each for each in plans if isinstance(each, Order)), None):
        return f"{said} did you mean {planned.text}?"
    meant = [head, *(SIDE_WORDS.get(token, token) for token in rest)]
    if meant == tokens:
        return ""
    try:
        return f"{said} did you mean {order(read_form(meant)).text}?"
    except RefusedError as refused:  # which is of help where it asks for more
        return "" if str(refused).startswith('"') else f"{said} {refused}"


def moved_word(tokens: list[str]) -> str:
    """Return the hint to say a word further ahead, "" where none helps.

    The last word may be meant as the first, or all words in reverse, as in "35 left rudder".
    """
    places = [(j, i) for j in range(2, len(tokens)) for i in range(1, j)]
    moves = [(j, [*tokens[:i], tokens[j], *tokens[i:j], *tokens[j + 1 :]]) for j, i in places]
    for last, moved in [*moves, (0, [tokens[-1], *tokens[:-1]]), (0, tokens[::-1])]:
        if not last and moved[0] not in ORDER_HEADS:
            continue
        kept = CREW_TURN_PATTERN.sub(r"course \1 to", " ".join(moved)).split()  # no turn by so much
        try:
            reading = read_form(kept)
        except RefusedError:
            continue
        before = f' after "{" ".join(tokens[:last])}"'
        said = f'"{tokens[last]}"{before}' if last else f'"{" ".join(tokens)}" is no order'
        hint = f"{said}; did you mean"
        try:
            return f"{hint} {order(reading).text}?"
        except RefusedError as beyond:
            return f"{hint} {' '.join(kept)}? {beyond}"
    return ""


def to_the_crew(said: Order) -> Order:
    """Return what an order means when it is given to the crew."""
    order = parse(said.crew) if said.crew else said
    return order if isinstance(order, Order) else said


def to_the_autopilot(said: Order) -> "Order | BadOrder | None":
    """Return the order to the autopilot that is meant like one to the crew."""
    return parse(CREW_TURN_PATTERN.sub(r"course \1 to", said.text.removeprefix(f"{CREW_HEAD} ")))


def condition_words(planned: Order, inner: Order) -> str:
    """Return the words of the condition that a planned order waits for."""
    return planned.text.removeprefix("when ").removesuffix(f" then {inner.text}")


def readable(text: str) -> str:
    """Return a line; refuse one that is too long or not plain ASCII."""
    if len(text) > MAX_LINE_LETTERS:
        raise RefusedError(f"line of {len(text)} characters; the longest is {MAX_LINE_LETTERS}")
    plain = PRINTABLE_PATTERN.match(text)
    end = plain.end() if plain else 0
    if end < len(text):
        raise RefusedError(describe_sign(text[end]))
    return text


def describe_sign(sign: str) -> str:
    """Return why a character is refused. Its code is told too: a line may show "?"."""
    code = f"U+{ord(sign):04X}"
    shown = f'"{sign}" ({code})' if sign.isprintable() else code
    return f"{shown} cannot be sent; type plain letters"


def printable(text: str) -> str:
    """Return `text` for a log: short, plain ASCII, a token in it hidden."""
    return hide_token("".join(c if " " <= c <= "~" else "?" for c in text[:MAX_LINE_LETTERS]))


def with_token(order: Order, token: str) -> Order:
    """Return the order with the token that was hidden as its subject."""
    if len(token.split()) > 1:
        raise RefusedError("a token is one word, the last of the line")
    return replace(order, subject=token) if token else order


def tokenise(text: str) -> list[str]:
    """Return the words in lower case, units split from their numbers."""
    words = text.lower().split()
    split = [
        glued.groups() if (glued := GLUED_PATTERN.fullmatch(word)) else (word,) for word in words
    ]
    return [token for tokens in split for token in tokens]


def read_form(tokens: list[str]) -> PartialReading:
    """Return the one reading of the tokens. Refuses where there is none, or more than one."""
    alive = HEAD_READINGS.get(tokens[0], [])
    for i, token in enumerate(tokens):
        before, reached = alive, [reading for reading in alive if len(reading.slots) > i]
        alive = [
            PartialReading(form, slots, (*said_before, said))
            for form, slots, said_before in reached
            for said in match_slot(slots[i], token)
        ]
        if not alive:
            slots = list_alternatives(reached if i else list(FORM_READINGS), i)
            raise RefusedError(describe_unexpected(tokens, i, slots, before))
        alive = in_full(alive, i, token)
    refuse_doubt(tokens, alive)
    whole = [reading for reading in alive if len(reading.slots) == len(tokens)]
    if not whole:
        expected = join_names(describe_slots(list_alternatives(alive, len(tokens))))
        raise RefusedError(f"{' '.join(tokens)} what? expected {expected}")
    if whole[0].form.refusal:
        raise RefusedError(whole[0].form.refusal)
    return whole[0]


def in_full(alive: list[PartialReading], i: int, token: str) -> list[PartialReading]:
    """Return the readings, without those that take a whole word for a shortened one."""
    words = [reading for reading in alive if isinstance(reading.slots[i], Word)]
    if not any(reading.said[i].spelling == token for reading in words):
        return alive
    return [
        reading
        for reading in alive
        if reading.said[i].spelling == token or not isinstance(reading.slots[i], Word)
    ]


def list_alternatives(readings: list[PartialReading], i: int) -> list[Slot]:
    """Return the slots at `i`. Wrong forms count only where no right one fits."""
    good = [reading for reading in readings if not reading.form.refusal]
    return [reading.slots[i] for reading in good or readings]


def match_slot(slot: Slot, token: str) -> Iterable[TokenReading]:
    """Return the ways `token` fits the slot: none, itself, or every word it abbreviates."""
    if isinstance(slot, Number):
        digits = token.removeprefix(slot.prefix)
        return (TokenReading(token, digits),) if DECIMAL_PATTERN.fullmatch(digits) else ()
    if isinstance(slot, Name):
        return (TokenReading(token, token),) if NAME_PATTERN.fullmatch(token) else ()
    if isinstance(slot, Secret):
        return (TokenReading(token, token),) if token == HIDDEN_TOKEN else ()
    if isinstance(slot, UnitWord):
        fits = any(token in unit.names for unit in slot.number.units)
        return (TokenReading(token, token),) if fits else ()
    if not token[0].isalpha() or token in MEANT_ORDERS:  # a beginner's word cuts none short
        return (TokenReading(token, word) for said, word in slot.spellings if said == token)
    return (TokenReading(said, word) for said, word in slot.spellings if said.startswith(token))


def refuse_doubt(tokens: list[str], alive: list[PartialReading]) -> None:
    """Refuse a token that is short for different words, naming them."""
    for i, token in enumerate(tokens):
        spellings = {reading.said[i].word: reading.said[i].spelling for reading in alive}
        if len(spellings) > 1:
            raise RefusedError(f'"{token}" may be {join_names(sorted(spellings.values()))}')


def describe_unexpected(
    tokens: list[str], i: int, slots: list[Slot], readings: list[PartialReading]
) -> str:
    """Return why token `i`, after these readings, fits none of the slots, and what would."""
    token, before = tokens[i], " ".join(tokens[:i])
    if not slots:
        named = any(isinstance(each.slots[i - 1], Name) for each in readings)
        whole = f"; a name is one word, such as {'-'.join(tokens[i - 1 :])}" if named else ""
        return f'"{token}" is too much after "{before}"{whole}'
    if token[0] in "+-.0123456789" and any(isinstance(slot, Number) for slot in slots):
        return f'"{token}" is not a plain decimal number'
    spelled = {said for slot in slots if isinstance(slot, Word) for said, _ in slot.spellings}
    heads = before in ("", HELP_HEAD)
    near = (meant_order(tokens[i:]) if heads else "") or nearest_word(token, spelled)
    kindred = "" if near or i > 1 or before == HELP_HEAD else kindred_orders(token, before)
    hint = f"; did you mean {near or kindred}?" if near or kindred else ""
    if not before:
        return f'"{token}" is no order{hint or "; help lists them"}'
    expected = "" if near else f": expected {join_names(describe_slots(slots))}"
    return f'"{token}" after "{before}"{expected}{hint}'


def describe_slots(slots: list[Slot]) -> list[str]:
    """Return what fits the slots, in words, once each."""
    descriptions: dict[str, None] = {}
    for slot in slots:
        if isinstance(slot, Word):
            descriptions |= dict.fromkeys(word for _, word in slot.spellings)
        elif isinstance(slot, Number):
            descriptions[f"{slot.says} ({slot.limits})"] = None
        elif isinstance(slot, Name):
            descriptions[slot.says] = None
        elif isinstance(slot, Secret):
            descriptions["a token"] = None
        else:
            descriptions |= dict.fromkeys(unit.names[0] for unit in slot.number.units)
    return list(descriptions)


def order(reading: PartialReading) -> Order:
    """Return the order of a whole reading. Refuses a number beyond the limits of the grammar."""
    form, slots, said = reading
    head = heading_word(form)
    optional = [item.strip("[]") for item in form.pattern.split()[1:] if item.startswith("[")]
    sign, text, words, rest, subject = 1.0, [head, *optional], [], [], ""
    side, unit = 0.0, None
    numbers: list[float] = []
    for i, (slot, token) in enumerate(zip(slots, said, strict=True)):
        if isinstance(slot, Number):
            unit = unit_after(slot, said[i + 1 :])
            value, wording = quantity(slot, token.word, unit)
            numbers.append(value)
            rest.append(wording)
        elif isinstance(slot, Name):
            subject = token.word
            rest.append(subject)
        elif isinstance(slot, UnitWord | Secret) or token.word in (optional if i else [head]):
            continue
        elif token.word in SIDE_SIGNS and head != CREW_HEAD:
            sign = side = SIDE_SIGNS[token.word]
            text.append(token.word)
        else:
            side = SIDE_SIGNS.get(token.word, side)
            words.append(token.word)
            rest.append(token.word)
    word = "_".join(words).replace("-", "_")
    # Adding zero turns -0.0 into 0.0, so that "left 0" and "right 0" steer alike.
    value = sign * (numbers[-1] if numbers else form.value) + 0.0
    whole, kept = " ".join((*text, *rest)), " ".join((*text, *words))
    return Order(
        form.name or head, value, word, whole, tuple(numbers), subject, "", side, unit, kept
    )


def unit_after(number: Number, rest: tuple[TokenReading, ...]) -> Unit:
    """Return the unit that follows a number, or the one understood."""
    named = [unit for unit in number.units if rest and rest[0].word in unit.names]
    return (named or list(number.units))[0]


@dataclass(frozen=True)
class Refused:
    """A "no": why an order changes nothing, or why something may not be."""

    reason: str


Reply = str | Refused
