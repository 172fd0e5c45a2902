"""Lines of programs: words and numbers framed with a checksum, both ways.

    order     = "$TRO," [ tag "," ] words "*" checksum          to the session
    answer    = "$TRA," [ tag "," ] ( "ok" | "no" | "say" ) "," text "*" checksum
    names     = "$TRN," channel { "," name ":" unit } "*" checksum
    state     = "$TRS," channel "," tick "," seconds { "," value } "*" checksum
    event     = "$TRE," tick "," seconds "," kind "," text "*" checksum
    fact      = "$TRF," tick "," seconds "," what "," subject "*" checksum
    tag       = one to six digits, chosen by the sender, returned with every answer to that order
    checksum  = two hexadecimal digits, the exclusive or of every character between "$" and "*"

An answer is any number of "say" lines and then one "ok" or "no". `text` is always last and may hold
commas. Facts (FACTS) are for programs, because texts may be reworded. A program must ignore lines
of a kind that it does not know. People type the words alone (``grammar``). A damaged line gets no
framed answer, because its tag may be damaged too.
"""

import functools
import operator
import re
from collections.abc import Iterable
from dataclasses import dataclass

from trainer.io.orders.grammar import MAX_LINE_LETTERS, BadOrder, Order, Refused, parse, printable

# [characters]  of a line from the session; NMEA's 82 would cut states apart
MAX_ANSWER_LETTERS = 2000
KEPT_SENTENCES = 8  # sentences; the last ones are asked for again by each station in turn

FRAME_PATTERN = re.compile(r"\$([^$*]*)\*([0-9A-Fa-f]{2})")
TAG_PATTERN = re.compile(r"[0-9]{1,6}")
UNSAFE_PATTERN = re.compile(r"[^ -~]|[$*]")
# Of each kind: the commas after which they belong to the text, and the fields it has at least.
SENTENCE_KINDS = {"TRA": (1, 2), "TRN": (-1, 1), "TRS": (-1, 3), "TRE": (3, 4), "TRF": (3, 4)}
# Sentences with a time: the place of the tick among their fields; the seconds follow it.
TIME_FIELDS = {"TRS": 1, "TRE": 0, "TRF": 0}
TICK_PATTERN = re.compile(r"[0-9]{1,18}")
SECONDS_PATTERN = re.compile(r"[0-9]{1,18}(?:\.[0-9]{1,9})?")

FACTS = {  # what the subject of each is; texts are for people, and may be reworded
    "order": "an order that was obeyed, in the grammar's words",
    "mark": "the remark of a mark",
    "back": "the order that has jumped to this tick; the orders to the crew that wait there follow",
    "branch": "number, parent, begun, last [s], and why; all before `back`, or that to `branches`",
    "exercise-over": "how it ended: lost, ended, done or not done; time stands still, all stay",
    "marks": "outcome, total [%], aids that were used; to all once they are released",
    "shown": "an order of the reference crew, which shows the way",
    "attainable": "time [s], marks [%] to be had from it, those so far, outcome, branch, left out; "
    "then the instructor's order that they are not for",
    "no-attainable": "why nothing is told of the marks still to be had",
    "reason": "a reason of the marks that were told last, after the time [s] it is about, if any",
    "debriefing": "the share of a debrief that is written, from 0 to 1; none when that has ended",
    "debrief": "the file that was written; what each minute cost follows as `reason`",
    "debrief-page": "its address at the pages' server, told to a page where the file is there",
    "next": "the next exercise begins here, its file for the instructor; connect again",
    "chair": "the role that this line has taken in place of its own; what it is told follows anew",
    "command": "the line of the instructor who has command now",
    "asked": "the line of the instructor who asks for command",
    "ready": "the line that is ready",
    "stations": "how many stations are here: as many follow as `aboard`, before that to `who`",
    "aboard": "role, name of its own, which of `you`, `command`, `ready` it is or has, and line",
    "said": "who has said or done what the next text tells, a role or `schedule`, and its words",
    "past": "begin or end, and the channel: the lines between them are what it has shown so far",
    "step": "number, how many, instrument to look at, text of a lesson's step; 0: no more",
    "step-hint": "what helps with the present step",
    "step-missed": "number of a step that was not done in its time, and `again` or `on`",
    "steps-undone": "at a lesson's end: name of what follows it, numbers of the steps not done",
    "snapshot": "the name of a moment kept; all of them come before the answer to `snapshots`",
    "casualty": "name, degree and meaning of one that can be had; before that to `casualties`",
    "degree": "name, severity, ramp [s], amount, unit, its side, and both sides where it has them",
    "plans": "how many orders are ahead: at most 40 follow, and those told before hold no more",
    "planned": "number to cancel it by, none of the exercise's own; time [s] or condition; order",
    "depth": "the depth [m] passed on the way down, at test depth, before it or beyond it",
    "collapse": "the depth [m] at which the hull has collapsed; time stands still",
    "crew-order": "an order to the crew as it is told: `course left to 045`; `tell` and its words",
    "own-order": "the order to the crew told just before, which this line has given",
    "repeated": "an order to the crew that has been repeated, as it was told",
    "wrong-repeat": "what was repeated, and after a semicolon the order as it was told",
    "belayed": "an order to the crew that stands no longer, as it was told",
    "has": "a hand axis, the station that works it now, and the one that did before, if any",
    "watch": "a station's role, the person who has the watch there, and who had it, if told",
    "wrong-way": "the order given at a station, and after a semicolon the order to the crew",
    "report": "the role that reports, and after a colon its words",
    "exercise": "a key of the exercise and its value: `hand=rudder,planes`",
    "range": "a key of the vessel and its value: `rudder=35`",
    "rate": "orders that wait beyond: `second=20`, or given at once `once=100`",
    "alert": "the number of an alert, its kind and its words, after commas",
    "alert-rank": "the number of the next alert, then emergency, alarm, warning or caution",
    "alerts": "how many alerts are open: as many follow, and those told before hold no more",
    "alert-state": "number of an alert, state, silence left [s], `you` or who answers, its name",
    "ack": "the number of an alert that somebody has seen",
    "own-alert": "an alert of a page's own: its name, `seen`, `silent` or `over`, for how long [s]",
    "over": "nothing: the session has ended",
    "no-room": "how many lines a session takes: so many are here, and this one is closed",
    "left": "nothing: this line has been let go, as it asked",
}


@dataclass(frozen=True)
class Message:
    """The content of a line. A framed one gets a framed answer with its tag."""

    order: Order | BadOrder
    machine: bool = False
    tag: str = ""


@dataclass(frozen=True)
class Sentence:
    """A line from the session with a right checksum: its kind and its fields.

    A kind is TRS, for example.
    """

    kind: str
    tag: str
    fields: tuple[str, ...]


def parse_line(line: str) -> Message | None:
    """Return what `line` holds, None when it is blank or a comment; never raises."""
    if line.lstrip().startswith("$"):
        return hear_machine(line.strip())
    order = parse(line)
    return Message(order) if order else None


def hear_machine(line: str) -> Message:
    """Return the content of a program's line."""

    def bad(reason: str, tag: str = "") -> Message:
        return Message(BadOrder(printable(line), reason), machine=True, tag=tag)

    if len(line) > MAX_LINE_LETTERS:
        return bad(f"line of {len(line)} characters; the longest is {MAX_LINE_LETTERS}")
    body = open_frame(line)
    if isinstance(body, Refused):
        return bad(body.reason)
    head, comma, rest = body.partition(",")
    if head != "TRO" or not comma:
        return bad("a program's line is $TRO,[tag,]order*checksum")
    first, comma, words = rest.partition(",")
    if not comma:
        first, words = "", rest
    elif not TAG_PATTERN.fullmatch(first):
        return bad("a tag is one to six digits")
    order = parse(words)
    if order is None:
        return bad("a sentence without an order", first)
    return Message(order, machine=True, tag=first)


def open_frame(line: str) -> str | Refused:
    """Return the content of a sentence, or why it is damaged."""
    match = FRAME_PATTERN.fullmatch(line)
    if not match:
        return Refused("a program's line ends in * and the two digits of its checksum")
    if not (line.isascii() and line.isprintable()):
        return Refused("a program's line is plain ASCII")
    body, sum_digits = match.groups()
    due = f"{checksum(body):02X}"
    wrong = sum_digits.upper() != due
    return Refused(f"wrong checksum {sum_digits.upper()}; this line's is {due}") if wrong else body


def parse_sentence(line: str) -> Sentence | None:
    """Return the sentence on `line`, None when it is damaged or no sentence; never raises."""
    body = open_frame(line.strip())
    if isinstance(body, Refused):
        return None
    kind, _, content = body.partition(",")
    if kind not in SENTENCE_KINDS:
        return None
    tag, _, rest = content.partition(",")
    if kind != "TRA" or not TAG_PATTERN.fullmatch(tag):
        tag, rest = "", content
    commas, least = SENTENCE_KINDS[kind]
    fields = tuple(rest.split(",", commas))
    if not rest or len(fields) < least:
        return None
    if kind in TIME_FIELDS:
        tick, seconds = fields[TIME_FIELDS[kind] : TIME_FIELDS[kind] + 2]
        if not (TICK_PATTERN.fullmatch(tick) and SECONDS_PATTERN.fullmatch(seconds)):
            return None
    return Sentence(kind, tag, fields)


def order_sentence(words: str, tag: str = "") -> str:
    """Return an order as a program sends it."""
    return frame("TRO", tag, words)


def unsendable_sign(words: str) -> str:
    """Return the first character that no order can hold, "" where there is none."""
    found = UNSAFE_PATTERN.search(words)
    return found[0] if found else ""


def answer(tag: str, *, accepted: bool, text: str) -> str:
    """Return the last line of an answer: done, or why not."""
    return frame("TRA", tag, f"{'ok' if accepted else 'no'},{safe(text)}")


def say(tag: str, text: str) -> str:
    """Return a line of a long answer, before the last."""
    return frame("TRA", tag, f"say,{safe(text)}")


def names(channel: str, fields: Iterable[tuple[str, str]]) -> str:
    """Return the names and units of a channel's values, in their order."""
    return frame("TRN", "", ",".join([channel, *(f"{name}:{unit}" for name, unit in fields)]))


def state(channel: str, tick: int, seconds: float, values: Iterable[str]) -> str:
    """Return the values of a channel at a tick [-], a time [s]."""
    fields = map(safe_field, values)
    return frame("TRS", "", ",".join([channel, f"{tick}", f"{seconds:.3f}", *fields]))


@functools.lru_cache(KEPT_SENTENCES)
def event(tick: int, seconds: float, kind: str, text: str) -> str:
    """Return the sentence of an event at a tick [-], a time [s]."""
    return frame("TRE", "", f"{tick},{seconds:.3f},{safe_field(kind)},{safe(text)}")


@functools.lru_cache(KEPT_SENTENCES)
def fact(tick: int, seconds: float, what: str, subject: str) -> str:
    """Return a fact for programs, one of FACTS, of a tick [-], a time [s]."""
    return frame("TRF", "", f"{tick},{seconds:.3f},{what},{safe(subject)}")


def frame(kind: str, tag: str, content: str) -> str:
    """Return a sentence with its checksum; the content holds no character that frames."""
    body = ",".join(filter(None, (kind, tag, content)))
    return f"${body}*{checksum(body):02X}"


def checksum(body: str) -> int:
    """Return the exclusive or of the characters, as NMEA 0183 has it."""
    return functools.reduce(operator.xor, body.encode("ascii"), 0)


def safe(text: str) -> str:
    """Return `text` in plain ASCII, without the characters that frame a sentence."""
    return UNSAFE_PATTERN.sub("?", text)


def safe_field(text: str) -> str:
    """Return `text` for a field before the last: as `safe`, with semicolons for commas."""
    return safe(text).replace(",", ";")
