"""A class with a page that floods, and a full disk: the other boats keep every deadline."""

import contextlib
import resource
import sys
import threading
import time

import pytest
from helpers.classes import class_at_sea, post
from helpers.waiting import await_that
from helpers.wire import ask, dialled
from soak.session_process import Caller
from websockets.exceptions import ConnectionClosed

from trainer.io.orders.sentences import order_sentence

pytestmark = [
    pytest.mark.process,
    pytest.mark.slow,
    pytest.mark.skipif(sys.platform != "linux", reason="limits another process by Linux alone"),
]

ATTACKED_S = 20.0
FLOOD_LINES = 2000  # at least, of what is sent
LEDGER_TICKS, LEDGER_MISSED = 2, (4, 6, 7)  # fields: overruns, slipped ticks and gaps


def ledger_of(boat: Caller) -> tuple[int, int]:
    """Return how many ticks a boat has done, and how many deadlines it has missed."""
    assert boat.ask("who")[0]
    ledger = boat.shown["ledger"]
    return int(ledger[LEDGER_TICKS]), sum(int(ledger[place]) for place in LEDGER_MISSED)


def flood(port: int, cookies: str, ended: threading.Event, sent: list[str]) -> None:
    """Send what a page may not, and more than it may, and come again whenever it is shut out."""
    noise = ("x" * 79, order_sentence("stern dive 3", "1"), order_sentence("log 20", "2"))
    while not ended.is_set():
        with (
            contextlib.suppress(ConnectionClosed, OSError, TimeoutError),
            dialled(port, cookies=cookies, root="/boat/1") as page,
        ):
            ask(page, "role planes")
            while not ended.is_set():
                for words in noise:
                    page.send(words)
                    sent.append(words)


def test_one_boats_flooded_page_and_anothers_full_disk_make_no_other_boat_late() -> None:
    with class_at_sea("depth-changes", "--boats", "3", boats=3) as lesson:
        boats = {number: lesson.attach(number) for number in (1, 2, 3)}
        ended, cookies = threading.Event(), post(lesson, "/seat", "1\nplanes\n\nA. Flood")[2]
        sent = list[str]()
        flooding = [
            threading.Thread(target=flood, args=(lesson.port, cookies, ended, sent))
            for _ in range(4)
        ]
        for boat in boats.values():
            assert boat.ask("subscribe ledger")[0]
            assert boat.ask("subscribe events")[0]
            assert boat.ask("run")[0]
        full = lesson.process_of(2)
        (ahead,) = lesson.folder.glob("boat-2/*-wal")
        resource.prlimit(full, resource.RLIMIT_FSIZE, (ahead.stat().st_size, -1))
        for thread in flooding:
            thread.start()
        try:
            until = time.monotonic() + ATTACKED_S
            while time.monotonic() < until:
                assert boats[3].ask("who")[0]
                time.sleep(0.2)
        finally:
            ended.set()
            for thread in flooding:
                thread.join()
        assert len(sent) > FLOOD_LINES, len(sent)
        assert any(text.startswith("NOT RECORDED") for text in heard(boats[2]))
        for number in (2, 3):
            ticks, missed = ledger_of(boats[number])
            assert ticks >= 2 * ATTACKED_S - 3
            assert missed == 0, number
        resource.prlimit(full, resource.RLIMIT_FSIZE, (-1, -1))
        await_that(lambda: any("recorded again" in each for each in heard(boats[2])))


def heard(boat: Caller) -> list[str]:
    """Return what a boat has told so far."""
    assert boat.ask("who")[0]
    return [each.fields[-1] for each in boat.news]
