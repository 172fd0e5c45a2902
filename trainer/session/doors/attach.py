"""The command ``trainer attach`` without a screen: a plain terminal as a station.

What is typed goes to the session as lines; its answers are printed. It also serves terminals that
cannot draw a screen (``console`` has the screens), and input from a pipe.
"""

import os
import re
import signal
import threading
from collections.abc import Callable
from typing import Final

import click

from trainer.config.files import ConfigError
from trainer.io import paths
from trainer.io.client import answer_of, dial
from trainer.io.line import Inbox, Line, Outbox, reader, writer
from trainer.io.lines import OverlongLine
from trainer.io.orders import sentences
from trainer.io.orders.grammar import describe_sign
from trainer.io.orders.sentences import Sentence
from trainer.io.serial_line import LinkError

CLOSING_FACTS: Final = ("over", "left", "next")  # facts after which the line is to be gone
CHOICE_FORM: Final = re.compile(r" *(?:run|end exercise|next(?: +[a-z0-9-]+)?) *")
CHOICE_TEXT: Final = (
    "choose in the browser, or type here: next (what you train next), "
    "next exercise-5, or run (sail freely); Ctrl-C ends"
)
FLUSH_TIMEOUT_S: Final = 2.0  # [s] for the last lines to go out at the end


def attach_to(url: str | None, role: str, token: str | None) -> int:
    """Attach a teletype of a role until session or user ends it. Return the exit code."""
    wake = threading.Event()
    token = token or paths.left_token(url)  # where the system has no local sockets
    try:
        line = dial(url or paths.nearest_session(), wake)
    except LinkError as error:
        raise ConfigError(str(error)) from None
    # A program's sentence makes the session send facts; typed lines still get answers in words.
    line.send(sentences.order_sentence(f"role {role}{f' {token}' if token else ''}"))
    if os.isatty(0):
        line.send("subscribe teletype")
    inbox, out = Inbox(reader(0), wake), Outbox(writer(1), line_end=b"\n")
    properly = carry_lines(line, inbox, out, wake)
    line.close(FLUSH_TIMEOUT_S)
    out.close(FLUSH_TIMEOUT_S)
    if properly:
        return 0
    click.echo(f"trainer: {line.name}: the session is gone: {line.trouble or 'closed'}", err=True)
    return 1


def offer_choice(url: Callable[[], str], token: str) -> None:
    """Let this terminal choose, as who trains, what the session at ``url()`` does."""
    if not os.isatty(0):
        return
    if hasattr(signal, "SIGTTIN"):  # a shell may put this program aside
        signal.signal(signal.SIGTTIN, signal.SIG_IGN)
    click.echo(CHOICE_TEXT, err=True)

    def hear() -> None:
        wake = threading.Event()
        typed = Inbox(reader(0), wake)
        while not typed.ended or typed.waiting:
            wake.wait()
            wake.clear()
            for words in map(str, typed.take()):
                chooses = CHOICE_FORM.fullmatch(words)
                click.echo(choose(url(), token, words) if chooses else CHOICE_TEXT, err=True)

    threading.Thread(target=hear, name="choice", daemon=True).start()


def choose(url: str, token: str, words: str) -> str:
    """Give one order as who trains, and leave; return the answer."""
    arrived = threading.Event()
    try:
        line = dial(url, arrived)
        line.send(sentences.order_sentence(f"role trainee {token}".strip()))
        line.send(sentences.order_sentence(words, "1"))
        answer = answer_of(line, arrived, "1")[1]
        line.close(FLUSH_TIMEOUT_S)
    except LinkError as error:
        return f"? {error}"
    return answer


def carry_lines(line: Line, inbox: Inbox, out: Outbox, wake: threading.Event) -> bool:
    """Carry lines both ways until the session closes. Return whether the session announced that.

    Ctrl-C, and the end of an input that nobody types, leave the session.
    """
    properly = interrupted = False
    handler = signal.signal(signal.SIGINT, lambda *_: line.send("detach"))
    try:
        while not line.ended:
            wake.wait()
            wake.clear()
            for typed in inbox.take():
                if isinstance(typed, OverlongLine):
                    continue
                if foreign := re.search(r"[^ -~]", typed):
                    out.send(f"? {describe_sign(foreign[0])}")
                else:
                    line.send(typed)
            if inbox.ended and not inbox.waiting and not interrupted and not os.isatty(0):
                interrupted = True
                line.send("detach")
            for said in line.take(1000):
                if isinstance(said, OverlongLine):
                    continue
                sentence = sentences.parse_sentence(said)
                if sentence and sentence.kind == "TRF":
                    properly = properly or sentence.fields[2] in CLOSING_FACTS
                elif text := in_words(said, sentence):
                    out.send(text)
    finally:
        signal.signal(signal.SIGINT, handler)
    return properly


def in_words(said: str, sentence: Sentence | None) -> str:
    """Return a line of the session in words for people."""
    if sentence is None or sentence.kind not in {"TRA", "TRE"}:
        return said
    text = sentence.fields[-1]
    return f"? {text}" if sentence.kind == "TRA" and sentence.fields[0] == "no" else text
