"""The proofs in short: what is kept of fuzzing, soaks and faults of seconds, and that they see."""

import contextlib
import dataclasses
import os
import random
import re
import threading
from collections.abc import Iterator
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, cast

import pytest
from helpers.places import TESTS
from hypothesis import given, settings
from hypothesis import strategies as st

from trainer.config.files import ConfigError
from trainer.io.orders.grammar import Order, parse
from trainer.io.recording.recording import Recording
from trainer.session.stations.roles import ROLES, refusal
from trainer.verify.faults import faults, recordings
from trainer.verify.faults.rig import Bench, ForkServer, Tried
from trainer.verify.fuzz.catalogue import TARGETS, choose_targets, corpus
from trainer.verify.fuzz.fuzz import Target, dictionary
from trainer.verify.soak.audit import Answered, check_journal, complete
from trainer.verify.soak.operators import Orders, Watchbill, instruct
from trainer.verify.soak.session_process import Caller, GoneError, WatchedClock
from trainer.verify.soak.soak import Plan, Sample, flat, page, soak

if TYPE_CHECKING:
    from trainer.verify.soak.session_process import SessionProcess

CORPUS = TESTS / "corpus"
posix = pytest.mark.skipif(os.name != "posix", reason="signals and forks of POSIX")
each_target = pytest.mark.parametrize("target", [pytest.param(t, id=n) for n, t in TARGETS.items()])

# What a fuzzer puts into a good input.
TOKENS = [
    b'"',
    b"[",
    b"]",
    b"{}",
    b"1e999",
    b"-",
    b"\n",
    b",",
    b"=",
    b"9" * 20,
    b"nan",
    b"\0",
    b"\xff",
]


# Bad input


@each_target
def test_every_input_that_was_worth_keeping_is_taken_or_refused_as_declared(target: Target) -> None:
    for data in corpus(CORPUS, target):
        target.take(data)


@st.composite
def spoilt(draw: st.DrawFn, target: Target) -> bytes:
    """Return one of a target's examples with a few places changed."""
    data = bytearray(draw(st.sampled_from(target.seeds())))
    for _ in range(draw(st.integers(0, 4))):
        at = draw(st.integers(0, len(data)))
        gone = draw(st.integers(0, 8))
        data[at : at + gone] = draw(st.sampled_from(TOKENS) | st.binary(max_size=4))
    return bytes(data)


@each_target
@settings(max_examples=15)
@given(data=st.data())
def test_a_spoilt_example_is_taken_or_refused_as_declared(
    target: Target, data: st.DataObject
) -> None:
    target.take(data.draw(spoilt(target)))


def test_a_target_that_is_none_is_told_with_the_nearest() -> None:
    with pytest.raises(ConfigError, match="no target vesel; nearest is vessel; there are: orders"):
        choose_targets(("vesel",))


def test_a_fuzzer_s_dictionary_has_the_words_of_the_seeds() -> None:
    assert dictionary([b"rudder left 15", b"\xffstep_s = 0.5"]) == '"left"\n"rudder"\n"step_s"\n'


# Soaks


@pytest.mark.parametrize("role", ROLES)
def test_random_orders_are_the_role_s_to_give_and_of_the_grammar(role: str) -> None:
    orders = Orders(ROLES[role], random.Random(1))  # noqa: S311  choices, not secrets
    said = {orders.next() for _ in range(300)} if orders else set()

    assert len(said) > 40 or role == "observer"
    for words in said:
        order = parse(words)
        assert isinstance(order, Order)
        assert refusal(ROLES[role], order) is None


class Ticking:
    """A clock that is always there already."""

    def now(self) -> int:
        return 0

    def cpu(self) -> int:
        return 0

    def wait_until(self, _deadline: int, _wake: threading.Event) -> int:
        return 1


def test_a_witness_sees_a_deadline_that_is_a_nanosecond_off() -> None:
    witness, wake = WatchedClock(Ticking(), Fraction(500_000_000)), threading.Event()
    for deadline in (7, 7, 500_000_007, 1_500_000_007, 1_500_000_007):
        witness.wait_until(deadline, wake)
    assert (witness.deadlines.seen, witness.deadlines.adrift) == (3, 0)
    witness.wait_until(2_000_000_008, wake)
    assert (witness.deadlines.adrift, witness.deadlines.furthest_ns) == (1, 1)


@pytest.fixture
def recording(tmp_path: Path) -> Path:
    """Return a recording of three ticks and two orders of one line."""
    path = tmp_path / "it.trainer"
    with contextlib.closing(Recording.create(path, {}, b"0")) as recorded:
        for tick in (1, 2, 3):
            recorded.state(tick, b"%d" % tick)
            if tick != 2:
                recorded.timing(tick, 1, 1)
        recorded.order(3, "helm at x", "rudder left 5")
        recorded.order(3, "helm at x", "rudder left 6")
    return path


@pytest.mark.parametrize(
    ("texts", "lost"),
    [
        (["rudder left 5", "rudder left 6"], 0),
        (["rudder left 5"], 0),
        (["rudder left 6"], 1),
        (["rudder left 5", "rudder left 6", "rudder left 7"], 1),
    ],
)
def test_an_audit_misses_an_order_that_was_answered_and_is_not_there(
    recording: Path, texts: list[str], lost: int
) -> None:
    with contextlib.closing(Recording.look(recording)) as looked:
        found = check_journal(looked, [Answered("helm at x", text) for text in texts])
    assert found.kept is not bool(lost)
    assert f"; {lost} lines lack any" in found.seen


def test_an_audit_misses_a_mark_that_was_answered_and_is_not_there(recording: Path) -> None:
    with contextlib.closing(Recording.look(recording)) as looked:
        found = check_journal(looked, [Answered("observer at tcp", "here", mark=True)])
    assert not found.kept
    assert found.seen.endswith("1 marks, 1 lost")


def test_an_audit_misses_a_tick_that_the_ledger_lacks(recording: Path) -> None:
    with contextlib.closing(Recording.look(recording)) as looked:
        found = complete(looked)
    assert (found.kept, found.seen) == (False, "3 ticks; 1 missing")


def test_memory_that_grows_after_the_warm_up_is_seen() -> None:
    level = [Sample(float(at), 100_000 + 2_000 * (at < 60)) for at in range(200)]
    growing = [Sample(float(at), 100_000 + 20 * at) for at in range(200)]
    assert flat(level).kept
    assert not flat(growing).kept
    assert "not judged: 2 looks" in flat(growing[:3]).seen


class Ended:
    """A session that has ended before anyone could join."""

    def caller(self, role: str) -> Caller:
        """Find nobody there."""
        raise GoneError(f"no session for a {role}")


def test_an_instructor_who_comes_too_late_leaves_without_a_word() -> None:
    bill = Watchbill(cast("SessionProcess", Ended()), pause=lambda _: 0.0)
    instruct(bill, 5, goes_back=True)
    assert not bill.answered


@posix
@pytest.mark.long
def test_a_soak_at_full_speed_keeps_every_promise() -> None:
    found = soak(Plan(900.0, real_time=False, seed=5), None, lambda *_: None)
    assert found.kept, page(found)
    assert found.orders > 0  # how many, the machine decides
    assert found.visits > 0


@posix
@pytest.mark.long
def test_a_soak_in_real_time_keeps_every_promise_and_does_not_drift() -> None:
    found = soak(Plan(6.0, real_time=True, seed=6), None, lambda *_: None)
    assert found.kept, page(found)
    drift = re.search(r"(\d+) deadlines; 0 not at start", page(found))
    assert drift
    assert int(drift[1]) == 12


# Faults


@pytest.fixture(scope="module")
def bench(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Bench]:
    with ForkServer() as nursery:
        dice = random.Random(1969)  # noqa: S311  instants, not secrets
        yield Bench(nursery, tmp_path_factory.mktemp("f"), dice)


@posix
@pytest.mark.long
@pytest.mark.parametrize(
    ("fault", "times"),
    [
        (faults.kill_sessions, 3),  # type: ignore[attr-defined]
        (faults.damage_last_page, 10),  # type: ignore[attr-defined]
        (faults.stop_session, 2),  # type: ignore[attr-defined]
        (faults.unplug, 2),
        (faults.full, 2),  # type: ignore[attr-defined]
        (faults.full_disk, 1),  # type: ignore[attr-defined]
        (faults.lock_recording, 1),  # type: ignore[attr-defined]
        (faults.relieve_disk, 1),  # type: ignore[attr-defined]
        (faults.take_disk_away, 1),  # type: ignore[attr-defined]
        (faults.clock_set, 2),  # type: ignore[attr-defined]
        (faults.console_killed, 1),  # type: ignore[attr-defined]
    ],
)
def test_a_fault_loses_nothing_that_is_journalled(
    bench: Bench, fault: faults.Fault, times: int
) -> None:
    tried = fault(bench, times)
    assert not tried.wrong, tried
    assert tried.times == times or "not tried" in str(tried.seen)


DAMAGED = 3  # recordings of each way; `trainer soak --damaged 2000` opens more


@pytest.fixture(scope="module")
def good_recording(bench: Bench) -> bytes:
    return recordings.make_recording(bench)


@posix
@pytest.mark.long
@pytest.mark.parametrize("way", recordings.DAMAGES, ids=lambda way: way.__name__)
def test_a_damaged_recording_is_told_in_a_line_or_read_as_it_is(
    bench: Bench, good_recording: bytes, way: recordings.Damage
) -> None:
    own = dataclasses.replace(bench, dice=random.Random(1969))  # noqa: S311  the same every time
    tried = recordings.open_damaged(own, good_recording, way, DAMAGED)
    assert not tried.wrong, tried
    assert sum(tried.seen.values()) == DAMAGED * len(recordings.COMMANDS)


@posix
@pytest.mark.long
def test_a_command_that_ends_with_a_traceback_or_without_end_is_seen(bench: Bench) -> None:
    tried = Tried("recording", "told in a line")
    recordings.judge(bench, tried, ("list", "--no-such"))
    assert tried.wrong == []
    assert tried.seen == {"told as damaged": 1}
    loop = ("run", "--headless", "--speed", "max", "--duration", "90000h")
    recordings.judge(bench, tried, loop, seconds=1)
    assert "run ended with -24" in tried.wrong[0]


def test_what_is_wrong_is_on_the_page() -> None:
    tried = Tried("kill -9", "no order is lost", times=3)
    tried.must(held=False, otherwise="2 written, 3 answered")
    told = faults.fault_row(tried)
    assert "1 WRONG" in told
    assert "3: 2 written, 3 answered" in told
