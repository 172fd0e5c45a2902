"""A session that is asked for more than its machine can do: it hears orders, and it ends."""

import contextlib
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from helpers.places import environment
from helpers.waiting import stay_for
from soak.session_process import Caller, SessionProcess

from trainer.boat import compilation

ANSWER = 5.0  # [s] for an order; half a second is promised
END = 10.0  # [s] after Ctrl-C; one second is promised


@contextlib.contextmanager
def interpreted(tmp_path: Path, *words: str) -> Iterator[tuple["subprocess.Popen[str]", Caller]]:
    """Have an interpreted session of REMUS 100, whose step is short, and its instructor."""
    serve = ["serve", "--vessel", "remus100", "--listen", "127.0.0.1:0", "--socket", "none"]
    process = subprocess.Popen(
        [sys.executable, "-m", "trainer", *serve, *words],
        env=environment(NUMBA_DISABLE_JIT="1", XDG_STATE_HOME=str(tmp_path)),
        stderr=subprocess.PIPE,
        stdout=subprocess.DEVNULL,
        text=True,
    )
    with contextlib.ExitStack() as at_the_end:
        session = SessionProcess(process)
        at_the_end.callback(session.kill)
        yield process, at_the_end.enter_context(session.caller("instructor", patience=ANSWER))


def interrupt(process: "subprocess.Popen[str]") -> int:
    """Press Ctrl-C; return the exit code."""
    process.send_signal(signal.SIGINT)
    return process.wait(END)


@pytest.mark.alone
@pytest.mark.clock
@pytest.mark.process
@pytest.mark.parametrize(
    "policy",
    ["catch-up", *(pytest.param(each, marks=pytest.mark.slow) for each in ("slip", "freeze"))],
)
def test_an_overloaded_session_hears_every_order_and_ctrl_c(tmp_path: Path, policy: str) -> None:
    with interpreted(tmp_path, "--overrun", policy) as (process, caller):
        assert caller.ask("subscribe events")[0]
        assert caller.ask("time x100")[0]
        for _ in range(20):  # two seconds, in which the first answer of old never came
            assert caller.ask("rudder left 5")[0]
            stay_for(process, 0.1)  # as somebody types
        assert caller.ask("time x100")[0]
        assert caller.ask("run")[0]
        assert caller.ask("freeze") == (True, "frozen")
        assert interrupt(process) == 0

    told = [(news.fields[2], news.fields[3]) for news in caller.news]
    assert sum("slipped" in text for _, text in told) <= 1
    fallen = [text for kind, text in told if kind == "time" and "machine holds" in text]
    assert len(fallen) <= (policy != "freeze")


@pytest.mark.alone
@pytest.mark.clock
@pytest.mark.process
def test_as_fast_as_it_goes_hears_orders_too(tmp_path: Path) -> None:
    with interpreted(tmp_path) as (process, caller):
        assert caller.ask("time max")[0]
        for _ in range(20):
            assert caller.ask("rudder right 5")[0]
        assert interrupt(process) == 0


@pytest.mark.alone
@pytest.mark.clock
@pytest.mark.process
def test_a_thousand_slow_steps_are_cut_short_by_an_order(tmp_path: Path) -> None:
    with interpreted(tmp_path, "--integrator", "rk4") as (process, caller):
        assert caller.ask("subscribe events")[0]
        assert caller.ask("freeze")[0]
        assert caller.ask("step 1000")[0]
        assert caller.ask("rudder left 5")[0]
        assert caller.ask("subscribe time")[0]
        assert caller.ask("run")[0]
        assert caller.ask("freeze")[0]
        stay_for(process, 0.2)  # in which it would make all of the steps
        assert caller.ask("status")[0]
        assert 0 < caller.tick < 1000
        assert interrupt(process) == 0


def lose_an_interrupt() -> None:
    """Press Ctrl-C where its exception is lost, as in a call back from C."""
    with contextlib.suppress(KeyboardInterrupt):
        signal.raise_signal(signal.SIGINT)
    raise RuntimeError("no compiled object yet")


def test_ctrl_c_that_a_compiler_loses_ends_what_it_compiles() -> None:
    with pytest.raises(KeyboardInterrupt), compilation.interruptible():
        lose_an_interrupt()


def test_a_compiler_s_own_error_stays_one() -> None:
    with pytest.raises(RuntimeError), compilation.interruptible():
        raise RuntimeError("no compiled object yet")
