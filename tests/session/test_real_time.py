"""A session in real time among stations that hang, babble, guess, vanish: no tick is missed."""

import contextlib
import itertools
import os
import random
import re
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from helpers.nursery import start_trainer
from helpers.places import environment
from helpers.sessions import TROUBLED_SEA
from helpers.waiting import PATIENCE, eventually
from soak.session_process import Caller, GoneError, SessionProcess

from trainer.io.orders.sentences import order_sentence
from trainer.io.recording.recording import RecordedEvent, Recording

pytestmark = [
    pytest.mark.clock,
    pytest.mark.process,
    pytest.mark.skipif(not hasattr(os, "openpty"), reason="no pseudo-terminals here"),
]

SOAK = float(os.environ.get("TRAINER_SOAK", "8"))  # [s]
FUZZ = 100_000 if "TRAINER_SOAK" in os.environ else 20_000  # [lines]
FLAT = 6_000  # [kB] that a process may grow by and call it flat: caches of what was said
BUSY = "while True: pass"
TOKEN = "xyzzy-1967"  # noqa: S105  a word of the test
EXERCISE = f"""{TROUBLED_SEA}
[[casualties]]
at_s = 0.5
name = "depth-gauge-noisy"

[[casualties]]
at_s = 1
name = "flooding-aft"
severity = 0.1
ramp_s = 25
"""


class Served(SessionProcess):
    """A session that is recorded."""

    def __init__(self, process: "subprocess.Popen[str]", recording: Path) -> None:
        super().__init__(process)
        self.recording = recording

    def finish(self, by: Caller) -> str:
        """Let the instructor end the session; return its account."""
        answer = by.ask("quit")
        if "quit again" in answer[1]:  # others are attached
            answer = by.ask("quit")
        assert answer == (True, "ending")
        assert self.ended(PATIENCE) == 0, self.told
        return "\n".join(self.account)

    def events(self, kind: str) -> list[RecordedEvent]:
        with contextlib.closing(Recording.look(self.recording)) as recording:
            return [each for each in recording.events() if each.kind == kind]


Serve = Callable[..., Served]


def trained(*words: str) -> "subprocess.Popen[str]":
    pipe = subprocess.PIPE
    return start_trainer(*words, env=environment(), stdout=pipe, stderr=pipe)


@pytest.fixture
def serve(tmp_path: Path) -> Iterator[Serve]:
    """Return a function that serves the exercise at ten ticks a second; it is killed at the end."""
    exercise, recording = tmp_path / "all.toml", tmp_path / "kept.trainer"
    exercise.write_text(EXERCISE)
    with contextlib.ExitStack() as started:

        def begin(*words: str) -> Served:
            process = trained(
                *("serve", str(exercise), "--verbose", "--speed", "5", "--listen", "127.0.0.1:0"),
                *("--socket", "none", "--record", str(recording), *words),
            )
            session = Served(process, recording)
            started.callback(session.kill)
            return session

        yield begin


@pytest.fixture
def pty() -> Iterator[Callable[[], tuple[int, str]]]:
    """Return a function that makes a serial line; it returns this end and the name of the other."""
    with contextlib.ExitStack() as opened:

        def make() -> tuple[int, str]:
            ours, theirs = os.openpty()
            opened.callback(quietly_close, ours)
            opened.callback(quietly_close, theirs)
            os.set_blocking(ours, False)
            return ours, os.ttyname(theirs)

        yield make


def quietly_close(descriptor: int) -> None:
    with contextlib.suppress(OSError):
        os.close(descriptor)


def come(descriptor: int) -> bytes:
    """Return what has come at a serial line by now."""
    try:
        return os.read(descriptor, 65536)
    except BlockingIOError:
        return b""


def replayed(path: Path) -> str:
    """Return what `trainer replay` says of a recording."""
    with trained("replay", str(path)) as process:
        out, err = process.communicate(timeout=PATIENCE)
    assert process.returncode == 0, out + err
    return out


def garbage(dice: random.Random) -> bytes:
    """Return a line of noise, or an order spoilt in one place."""
    if dice.random() < 0.5:
        return dice.randbytes(dice.randrange(12)).replace(b"\n", b"!") + b"\n"
    words = dice.choice([b"rudder left 5", b"depth 80", b"blow all", b"$TRO,1,depth 80*30", b"run"])
    place = dice.randrange(len(words))
    return words[:place] + dice.randbytes(1) + words[place + 1 :] + b"\n"


def babble(line: socket.socket, stop: threading.Event) -> None:
    """Send noise until told to stop; what is answered is read and forgotten."""
    dice = random.Random(3)  # noqa: S311  noise, not a secret
    line.settimeout(0.0)
    while not stop.wait(0.01):
        with contextlib.suppress(BlockingIOError):
            line.send(b"".join(garbage(dice) for _ in range(10)))
        with contextlib.suppress(BlockingIOError):
            line.recv(65536)


def lines_of(caller: Caller, words: str) -> list[str]:
    """Return the lines of a long answer."""
    assert caller.ask(words)[0]
    return caller.said


def lost(account: str) -> int:
    """Return how many lines a station has lost by its account in `who`."""
    found = re.search(r"(\d+) lines lost", account)
    return int(found[1]) if found else 0


@pytest.mark.slow
def test_no_tick_is_missed_among_hung_and_babbling_stations(
    serve: Serve, pty: Callable[[], tuple[int, str]]
) -> None:
    helm, helm_name = pty()
    ballast, ballast_name = pty()
    with contextlib.ExitStack() as stack:
        busy = stack.enter_context(subprocess.Popen([sys.executable, "-c", BUSY]))
        stack.callback(busy.kill)
        session = serve("--line", f"helm={helm_name}", "--line", f"ballast={ballast_name}")
        stop = threading.Event()
        by, hung, noisy = (stack.enter_context(c) for c in stations(session))
        noise = threading.Thread(target=babble, args=(noisy.line, stop))
        noise.start()
        stack.callback(noise.join)
        stack.callback(stop.set)
        hung.line.sendall(b"help\n" * 400)  # and never reads what it is told
        os.write(ballast, b"subscribe tanks at 50 hz\rsubscribe air at 50 hz\r")  # likewise
        os.write(helm, b"subscribe steering at 50 hz\r")

        orders = itertools.cycle(("depth 50", "casualty gyro-noisy", "speed 9", "sea state 4"))
        said, end = b"", time.monotonic() + SOAK
        while time.monotonic() < end:
            assert by.ask(next(orders))[0]
            os.write(helm, b"rudder right 10\r")
            said = said[-1000:] + come(helm)
            time.sleep(0.1)  # as somebody types
        accounts = lines_of(by, "who")
        stop.set()
        noise.join()
        account = session.finish(by)

    assert on_time(account), account
    who = {text.split()[0]: text for text in accounts}
    assert lost(who["planes"]) > 100
    assert lost(who["ballast"]) > 10
    assert lost(who["instructor"]) == 0
    assert lost(who["helm"]) < 10  # its reader is this busy test
    bad = re.search(r"(\d+) bad lines", who["observer"])
    assert bad
    assert int(bad[1]) > 100
    assert b"rudder right 10, by hand" in said
    assert "the same to the last bit" in replayed(session.recording)


def stations(session: Served) -> Iterator[Caller]:
    """Yield the instructor, one that is to hang, and one that is to babble."""
    yield session.caller("instructor")
    hung = session.caller("planes", buffer=4096)
    for channel in ("teletype", "gauges", "diving", "time"):
        assert hung.ask(f"subscribe {channel} at 50 hz")[0]
    yield hung
    yield session.caller()


def on_time(account: str) -> bool:
    """Return whether hardly a tick was missed: a machine that others use may stand still once."""
    found = re.search(r"overruns (\d+), caught up \d+, slipped (\d+), gaps (\d+)", account)
    assert found, account
    return sum(int(number) for number in found.groups()) <= 2


# Those who should not


def refused_ones(session: Served) -> None:
    """Be everybody that a session has to refuse."""
    with session.caller() as stranger:
        assert not stranger.ask("rudder left 5")[0]
        assert "needs a token" in stranger.ask("role helm")[1]
        for guess in ("a", "b", "c"):
            obeyed, text = stranger.ask(f"role instructor {guess}")
            assert (obeyed, text[:11]) == (False, "wrong token")
        assert "closed" in text
        with pytest.raises(GoneError, match="closed"):
            stranger.hear()
    with session.caller("helm", TOKEN) as helm:
        for words in ("depth 80", "blow all", "freeze", "quit", "restore a", "subscribe motion"):
            assert not helm.ask(words)[0]
        assert "keeps its role" in helm.ask(f"role instructor {TOKEN}")[1]
        helm.line.sendall(b"rudder left 5" * 1000 + b"\n")
        assert helm.ask("help rudder")[0]


def half_open(session: Served) -> list[socket.socket]:
    """Leave sockets behind: one silent, one within an order; and reset another there."""
    left = [session.caller("helm", TOKEN).line, session.caller().line]
    left[0].sendall(b"rudder left 2")
    reset = session.caller("helm", TOKEN)
    reset.line.sendall(b"rudder left 20")
    reset.cut()
    return left


def fuzz(session: Served, lines: int, seed: int) -> None:
    """Send so many lines of noise on one connection, and wait until all have been heard."""
    dice = random.Random(seed)  # noqa: S311  noise, not a secret
    last = f"\n{order_sentence('who', '777')}\n".encode("ascii")
    with session.caller("observer", TOKEN) as client:
        client.line.settimeout(0.0)
        waiting, said, asked = b"".join(garbage(dice) for _ in range(lines)), b"", 0.0
        while waiting or b"$TRA,777,ok" not in said:
            if not waiting and time.monotonic() > asked:  # an answer may be lost in the crowd
                waiting, asked = last, time.monotonic() + 1.0
            with contextlib.suppress(BlockingIOError):
                waiting = waiting[client.line.send(waiting) :]
            with contextlib.suppress(BlockingIOError):
                said = said[-50:] + client.line.recv(65536)
            time.sleep(0.002)  # babbling, and not alone on the machine


def fuzz_all(session: Served, lines: int) -> None:
    """Send noise on four connections at once."""
    threads = [threading.Thread(target=fuzz, args=(session, lines // 4, seed)) for seed in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()


def test_who_may_not_or_cannot_order_is_refused_logged_and_changes_nothing(
    serve: Serve, tmp_path: Path
) -> None:
    session = serve("--token", TOKEN)
    with session.caller("instructor", TOKEN) as by:
        refused_ones(session)
        left = half_open(session)
        fuzz_all(session, 2000)
        memory = session.memory()
        fuzz_all(session, FUZZ)
        grown = session.memory() - memory
        assert eventually(lambda: "observer" not in " ".join(lines_of(by, "who")))
        account = session.finish(by)
    for line in left:
        line.close()

    gone = "\n".join(each.text for each in session.events("station"))
    heard = sum(int(number) for number in re.findall(r"(\d+) bad lines.*: gone", gone))
    assert heard > 0.9 * (FUZZ + 2000)  # a line of noise may be blank
    assert grown < FLAT
    assert on_time(account)
    refused = session.events("refused")
    texts = "\n".join(each.text for each in refused)
    for told in ("wrong token", "the depth is", "longer than 80", "more of the same"):
        assert told in texts, told
    assert TOKEN.encode() not in session.recording.read_bytes()
    assert len(refused) < 2000
    assert unchanged(session.recording, tmp_path)


def unchanged(path: Path, folder: Path) -> bool:
    """Return whether every state is the one of a run that nobody attends to."""
    with contextlib.closing(Recording.look(path)) as recording:
        disturbed = list(recording.states(1))
        assert {each.who for each in recording.orders(1)} == {"schedule"}
    seconds = str(0.5 * disturbed[-1][0])
    alone = folder / "alone.trainer"
    with trained(
        *("run", str(folder / "all.toml"), "--headless", "--speed", "max"),
        *("--duration", seconds, "--record", str(alone)),
    ) as process:
        assert process.wait(PATIENCE) == 0
        process.communicate()
    with contextlib.closing(Recording.look(alone)) as recording:
        return list(recording.states(1)) == disturbed


MORE = re.compile(r"(\d+) more of the same")


def guess(session: Served, lines: int) -> None:
    """Say three wrong tokens on each line, and hang up without waiting for the answers."""
    for number in range(lines):
        with (
            contextlib.suppress(OSError, GoneError),  # the oldest stranger gives way
            session.caller() as stranger,
        ):
            guesses = b"".join(b"role instructor %d-%d\n" % (number, i) for i in range(3))
            stranger.line.sendall(guesses)
            stranger.line.shutdown(socket.SHUT_WR)
            while stranger.line.recv(4096):
                pass


def test_wrong_tokens_leave_the_log_readable_and_nobody_waits_behind_them(serve: Serve) -> None:
    session = serve("--token", TOKEN)
    with session.caller("instructor", TOKEN) as by:
        for number in range(40):
            assert by.ask(f"mark before {number}")[0]
        assert by.ask("subscribe events")[0]
        guessers = [
            threading.Thread(target=guess, args=(session, 60), daemon=True) for _ in range(3)
        ]
        for each in guessers:
            each.start()
        for each in guessers:
            each.join(PATIENCE)
            assert not each.is_alive()
        with session.caller("helm", TOKEN) as helm:  # right, and at once
            assert helm.ask("rudder left 5")[0]
        assert eventually(lambda: any("wrong token" in line for line in lines_of(by, "log 500")))
        kept = lines_of(by, "log 500")
        session.finish(by)

    assert sum("mark by instructor: before" in line for line in kept) == 40
    of_strangers = [line for line in kept if "stranger" in line or "has come" in line]
    assert 0 < sum("role instructor: wrong token" in line for line in of_strangers) <= 20
    assert len(of_strangers) <= 50
    written = session.events("refused") + session.events("station")
    assert len(written) <= 70
    total = sum(int(found[1]) for each in written if (found := MORE.match(each.text)))
    assert total > 180  # what is not written is counted, to the end of the session


def test_a_guesser_waits_for_his_answers_and_no_right_token_does(serve: Serve) -> None:
    session = serve("--token", TOKEN)
    with session.caller() as first:
        for token in ("a", "b"):
            assert first.ask(f"role helm {token}")[1] == "wrong token"
    answers = []
    for token in ("c", "d"):
        with session.caller() as line:
            answers.append(line.ask(f"role helm {token}")[1])
    late = "wrong token; answered after 1 s, because there were many"
    assert answers == ["wrong token", late]
    with (
        session.caller() as waiting,
        session.caller("instructor", TOKEN) as by,
    ):
        waiting.line.sendall(b"role helm f\n")
        assert any(each.startswith("stranger at") for each in lines_of(by, "who"))  # it waits still
        session.finish(by)


def test_a_serial_station_unplugged_and_plugged_in_again_goes_on(
    serve: Serve, pty: Callable[[], tuple[int, str]], tmp_path: Path
) -> None:
    port = tmp_path / "ttyHELM"
    first, name = pty()
    port.symlink_to(name)
    session = serve("--line", f"helm={port}")
    with session.caller("instructor") as by:
        os.write(first, b"rudder left 5\r")
        assert eventually(lambda: b"left 5, by hand" in come(first))
        os.write(first, b"rudder right 3")  # and the plug is pulled
        second, name = pty()
        port.unlink()
        port.symlink_to(name)
        os.close(first)
        assert eventually(lambda: os.write(second, b"\rstatus\r") and b"rudder" in come(second))
        os.write(second, b"rudder left 8\r")
        assert eventually(lambda: b"left 8, by hand" in come(second))
        assert any(text.startswith(f"helm at {port}") for text in lines_of(by, "who"))
        session.finish(by)

    with contextlib.closing(Recording.look(session.recording)) as recording:
        given = [each.text for each in recording.orders(1) if each.who != "schedule"]
        told = [each.text for each in recording.events() if each.text.startswith(f"{port}: ")]
    assert given == ["rudder left 5", "rudder left 8"]
    assert [text.split(" (")[0] for text in told] == [
        f"{port}: the line is lost",
        f"{port}: the line is back",
    ]
    assert "the same to the last bit" in replayed(session.recording)
