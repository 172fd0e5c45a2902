"""The table of a control room's phrases, and the orders that they mean.

A phrase is looked for only where a line is no order of ``table``. It means the ``order`` when a
station works its own control. It means the ``crew`` order, where there is one, when the instructor,
the diving officer or a schedule orders the crew. A pattern is a row of items: ``a|b`` one of these
words, ``[a]`` may be left out, CAPITALS stand for SLOT_PATTERNS. Numbers may be words: ``zero four
five``, ``one eighty``, ``two hundred``.
"""

import difflib
import re
from functools import cache
from typing import Final, NamedTuple

from trainer.io.orders.quantities import FEET, METRES, TONNES, RefusedError

SLOT_PATTERNS: Final = {
    "SIDE": r"(?P<side>left|right|port|starboard)",
    "COURSE": r"(?P<n>\d{3}(?:\.\d+)?)",
    "ANGLE": r"(?P<n>\d{1,2}(?:\.\d+)?)",
    "N": r"(?P<n>\d+(?:\.\d+)?)",
    "UNIT": f"(?P<unit>{'|'.join((*METRES.names, *FEET.names))})",
    "TONNES": f"(?:{'|'.join(TONNES.names)})",
    "DEGREES": "(?:degrees?|deg)",
    "KNOTS": "(?:knots?|kn)",
    "WAY": "(?P<way>up|down)",
    "TILT": "(?P<tilt>dive|rise)",
    "BUBBLE": "(?:bubble|angle)",
    "PITCH": "(?:pitch|bubble)",
    "STERN": "(?P<planes>stern|bow|sail|fairwater) planes",
    "AHEAD": "(?P<bell>one-third|two-thirds|1/3|2/3|standard|full|flank)",
    "ASTERN": "(?P<bell>one-third|two-thirds|1/3|2/3|full)",
    "AUXILIARY": "(?:auxiliary|auxiliaries|aux)",
    "GROUP": "(?P<group>forward|mid|aft)",
    "OPEN": "(?P<open>open|shut)",
    "AXIS": "(?P<axis>rudder|planes|speed|ballast)",
}
# fmt: off
UNIT_WORDS: Final = (
    "zero", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine",
    "ten", "eleven", "twelve", "thirteen", "fourteen", "fifteen", "sixteen", "seventeen",
    "eighteen", "nineteen",
)
# fmt: on
TENS_WORDS: Final = ("twenty", "thirty", "forty", "fifty", "sixty", "seventy", "eighty", "ninety")
DIGIT_VALUES: Final = {word: f"{i}" for i, word in enumerate(UNIT_WORDS[:10])} | {"niner": "9"}
TEEN_VALUES: Final = {word: i for i, word in enumerate(UNIT_WORDS) if i >= 10}
TENS_VALUES: Final = {word: 10 * i for i, word in enumerate(TENS_WORDS, start=2)}
NUMBER_WORDS: Final = {*DIGIT_VALUES, *TEEN_VALUES, *TENS_VALUES, "hundred"}
USUAL_ANGLE: Final = "10"  # [deg] of an example, where none was said
ANY_DIGIT: Final = "0"  # stands for any number that a phrase may begin with


class Phrase(NamedTuple):
    """One way to say an order."""

    example: str
    pattern: str
    order: str  # of whoever works it
    crew: str = ""  # of whoever orders the crew, "" where it is the same


class PhraseMeaning(NamedTuple):
    """The meaning of a phrase, in the words of the grammar."""

    order: str
    crew: str


PHRASES: Final = (
    Phrase("left full rudder", "SIDE full [rudder]", "rudder {side} full"),
    Phrase("full left rudder", "full SIDE rudder", "rudder {side} full"),
    Phrase("hard a-port", "hard [a] SIDE [rudder]", "rudder {side} full"),
    Phrase("right 10 degrees rudder", "SIDE ANGLE [DEGREES] [of] [rudder]", "rudder {side} {n}"),
    Phrase("right rudder 10", "SIDE rudder ANGLE [DEGREES]", "rudder {side} {n}"),
    Phrase("midships", "amidships|midships", "rudder amidships"),
    Phrase("ease to 5", "ease [her|the|your] [rudder] to ANGLE [DEGREES]", "rudder ease {n}"),
    Phrase("ease her", "ease her", "rudder ease 5"),
    Phrase("shift your rudder", "shift [your|the] [rudder]", "rudder shift"),
    Phrase("meet her", "meet her", "rudder meet"),
    Phrase(
        "come left to 045",
        "[come|turn] SIDE to [course] COURSE",
        "course {side} to {n}",
        "order course {side} {n}",
    ),
    Phrase("steady on 045", "steady [up] on [course] COURSE", "course {n}", "order course {n}"),
    Phrase("steer 045", "steer [course] COURSE", "course {n}", "order course {n}"),
    Phrase("come to 045", "come to [course] COURSE", "course {n}", "order course {n}"),
    Phrase("steady as she goes", "steady as she goes", "course steady", "order course steady"),
    Phrase("I have the planes", "i have the AXIS", "have {axis}"),
    Phrase("I have the helm", "i have the helm", "have rudder"),
    Phrase("steady", "steady [so]", "course steady", "order course steady"),
    Phrase("all ahead two thirds", "all [engines] ahead AHEAD", "bell ahead {bell}"),
    Phrase("back full", "[bell] [all] [engines] back|astern ASTERN", "bell astern {bell}"),
    Phrase("full astern", "[bell] [all] [engines] ASTERN back|astern", "bell astern {bell}"),
    Phrase("full ahead", "[bell] [all] [engines] AHEAD ahead", "bell ahead {bell}"),
    Phrase("all stop", "all [engines] stop", "bell stop"),
    Phrase("stop engines", "stop [the] engine|engines", "bell stop"),
    Phrase("make turns for 8 knots", "make turns for N [KNOTS]", "turns {n}"),
    Phrase("make 8 knots", "make N KNOTS", "turns {n}", "order speed {n}"),
    Phrase(
        "make your depth 60 metres",
        "[make] your|ordered depth N [UNIT]",
        "depth {n} {unit}",
        "order depth {n} {unit}",
    ),
    Phrase(
        "go to 60 metres",
        "go|come [up|down] to N UNIT",
        "depth {n} {unit}",
        "order depth {n} {unit}",
    ),
    Phrase(
        "come to periscope depth",
        "go|come [up|down] to periscope depth",
        "periscope depth",
        "order periscope depth",
    ),
    Phrase(
        "dive to 60 metres",
        "dive|descend|ascend|take|bring [her|the] [boat] [up|down] to N [UNIT]",
        "depth {n} {unit}",
        "order depth {n} {unit}",
    ),
    Phrase("five degrees down bubble", "ANGLE [DEGREES] WAY BUBBLE", "order pitch {n} {way}"),
    Phrase("pitch 5 down", "[order] PITCH ANGLE [DEGREES] WAY", "order pitch {n} {way}"),
    Phrase("pitch down 5", "[order] PITCH WAY ANGLE [DEGREES]", "order pitch {n} {way}"),
    Phrase("zero bubble", "0 [DEGREES] BUBBLE", "order pitch zero"),
    Phrase("pitch zero", "PITCH 0 [DEGREES]", "order pitch zero"),
    Phrase("rudder zero degrees", "rudder 0 [DEGREES]", "rudder amidships"),
    Phrase("stern planes 10 dive", "STERN ANGLE [DEGREES] TILT", "{planes} planes {tilt} {n}"),
    Phrase(
        "10 dive on the stern planes",
        "ANGLE [DEGREES] TILT on [the] STERN",
        "{planes} planes {tilt} {n}",
    ),
    Phrase("bow planes full rise", "STERN full TILT", "{planes} planes {tilt} full"),
    Phrase(
        "full rise on the bow planes", "full TILT on [the] STERN", "{planes} planes {tilt} full"
    ),
    Phrase("stern planes zero degrees", "STERN 0 [DEGREES]", "{planes} planes zero"),
    Phrase("zero the planes", "0 [the] planes", "planes zero"),
    Phrase("planes zero degrees", "planes 0 [DEGREES]", "planes zero"),
    Phrase(
        "flood depth control 2 tonnes", "flood depth control N [TONNES]", "flood depth-control {n}"
    ),
    Phrase(
        "flood 2 tonnes to depth control",
        "flood N [TONNES] to|into [the] depth control",
        "flood depth-control {n}",
    ),
    Phrase(
        "pump depth control 2 tonnes", "pump depth control N [TONNES]", "pump depth-control {n}"
    ),
    Phrase(
        "pump 2 tonnes from depth control",
        "pump N [TONNES] from [the] depth control",
        "pump depth-control {n}",
    ),
    Phrase("flood auxiliaries 2 tonnes", "flood AUXILIARY N [TONNES]", "flood auxiliary {n}"),
    Phrase("pump auxiliaries 2 tonnes", "pump AUXILIARY N [TONNES]", "pump auxiliary {n}"),
    Phrase("pump 3 forward to aft", "pump N [TONNES] [from] forward to aft", "pump trim aft {n}"),
    Phrase(
        "pump 3 aft to forward", "pump N [TONNES] [from] aft to forward", "pump trim forward {n}"
    ),
    Phrase("flood negative", "flood [the] negative [tank]", "negative flood"),
    Phrase("blow negative", "blow [the] negative [tank]", "negative blow"),
    Phrase("open vents", "OPEN [all] [the] [main] vents", "vent all {open}"),
    Phrase("open forward vents", "OPEN [the] GROUP vents", "vent {group} {open}"),
    Phrase("blow main ballast", "blow [all] [the] main ballast", "blow all"),
    Phrase("secure the blow", "secure [the] blow|air", "blow stop"),
    Phrase("EMBT blow", "embt blow", "emergency blow"),
    Phrase("raise scope", "raise|up [the] scope|periscope", "scope raise"),
    Phrase("lower scope", "lower|down [the] scope|periscope", "scope lower"),
    Phrase("scope up", "scope|periscope up", "scope raise"),
    Phrase("scope down", "scope|periscope down", "scope lower"),
)

# What a sailor says of more than one order, and what is asked in return.
DOUBTFUL_PHRASES: Final = {
    "turn|come|go|alter [course] SIDE [by] [ANGLE] [DEGREES]": (
        "rudder or course? say rudder {side} {n}, course {side} {n} or course {side} to 045"
    ),
    "[order] PITCH ANGLE [DEGREES]": "bow up or down? say pitch {n} up or pitch {n} down",
}


@cache
def pattern(row: str) -> re.Pattern[str]:
    """Return the regular expression of a row of items, each with the blank after it.

    It is made where a phrase is looked for, because few starts of the program hear one.
    """
    pieces = []
    for item in row.split():
        plain = item.strip("[]")
        word = "|".join(SLOT_PATTERNS.get(each, each) for each in plain.split("|"))
        pieces.append(f"(?:(?:{word}) ){'?' * item.startswith('[')}")
    return re.compile("".join(pieces))


def openings(row: str) -> list[str]:
    """Return an expression for each word that a row may begin with."""
    items = row.split()
    first = next(i for i, item in enumerate(items) if not item.startswith("["))
    words = [each for item in items[: first + 1] for each in item.strip("[]").split("|")]
    return [SLOT_PATTERNS.get(each, each) for each in words]


def first_words(row: str) -> set[str]:
    """Return the words that a row may begin with; ANY_DIGIT for any number."""
    said = [each for expression in openings(row) for each in spoken_as(expression)]
    return {ANY_DIGIT if each[0].isdigit() else each for each in said}


def spoken_as(expression: str) -> list[str]:
    """Return the first words that an expression may match; ANY_DIGIT for a number."""
    inner = re.sub(r"^\(\?(?:P<\w+>|:)|\)", "", expression)
    if "\\d" in inner:
        return [ANY_DIGIT]
    return [each.split()[0] for each in inner.split("|")]


PHRASES_BY_WORD: Final[dict[str, list[Phrase]]] = {}
for _phrase in PHRASES:
    for _word in first_words(_phrase.pattern):
        PHRASES_BY_WORD.setdefault(_word, []).append(_phrase)


def meaning(tokens: list[str]) -> PhraseMeaning | None:
    """Return what a phrase means, None if it is none. Refuses one that may mean two orders."""
    text = plain_text(tokens)
    first = text.partition(" ")[0]
    for phrase in PHRASES_BY_WORD.get(ANY_DIGIT if first[:1].isdigit() else first, ()):
        if match := pattern(phrase.pattern).fullmatch(f"{text} "):
            said = {name: value or "" for name, value in match.groupdict().items()}
            said["n"] = said.get("n", "")
            order = phrase.order.format(**said).strip()
            return PhraseMeaning(order, phrase.crew.format(**said).strip())
    for row, question in DOUBTFUL_PHRASES.items():
        if match := pattern(row).fullmatch(f"{text} "):
            said = {"side": "", **match.groupdict(), "n": match["n"] or USUAL_ANGLE}
            raise RefusedError(f'"{text}": {question.format(**said)}')
    return None


def nearest_phrase(tokens: list[str]) -> str:
    """Return the phrase most like a wrong one that begins as it does. "": none."""
    text = plain_text(tokens)
    first = text.partition(" ")[0]
    examples = {
        plain_text(phrase.example.lower().split()): phrase.example
        for phrase in PHRASES
        if re.fullmatch("|".join(openings(phrase.pattern)), first)
    }
    near = difflib.get_close_matches(text, examples, n=1, cutoff=0.5)
    return examples[near[0]] if near else ""


def plain_text(tokens: list[str]) -> str:
    """Return tokens with the numbers in digits, without the old "a-" before a side."""
    words = [token.strip(",.").removeprefix("a-") for token in tokens]
    split = [part for word in words for part in parts_of(word)]
    return " ".join(filter(None, numerals(split)))


def parts_of(word: str) -> list[str]:
    """Return the parts of a number with dashes, such as forty-five, or the word itself."""
    parts = word.split("-")
    return parts if all(part in NUMBER_WORDS for part in parts) else [word]


def numerals(words: list[str]) -> list[str]:
    """Return the words with numbers in digits, said digit by digit or as a whole."""
    numbers: list[str] = []
    digits, rest = "", list(words)
    while rest:
        chunk = chunk_of(rest)
        if chunk:
            digits += chunk
            continue
        numbers += [digits, rest.pop(0)]
        digits = ""
    return [word for word in (*numbers, digits) if word]


def chunk_of(rest: list[str]) -> str:
    """Take the first number off the words, such as two hundred, forty five, nine. Return it."""
    if len(rest) > 1 and rest[0] in DIGIT_VALUES and rest[1] == "hundred":
        hundreds = int(DIGIT_VALUES[rest.pop(0)])
        rest.pop(0)
        if rest[:1] == ["and"]:
            rest.pop(0)
        return str(100 * hundreds + int(chunk_of(rest) or 0))
    if rest[0] in TENS_VALUES if rest else False:
        tens = TENS_VALUES[rest.pop(0)]
        unit = (
            DIGIT_VALUES[rest.pop(0)]
            if rest and rest[0] in DIGIT_VALUES and rest[0] != "zero"
            else "0"
        )
        return str(tens + int(unit))
    if rest and rest[0] in TEEN_VALUES:
        return str(TEEN_VALUES[rest.pop(0)])
    return DIGIT_VALUES[rest.pop(0)] if rest and rest[0] in DIGIT_VALUES else ""
