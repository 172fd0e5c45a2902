"""Soaks of seconds keep every promise, and the audit sees what is missing."""

import contextlib
import os
import random
import re
import threading
from fractions import Fraction
from pathlib import Path

import pytest
from helpers.givers import giver_at
from helpers.orders import read_order

from soak.audit import Answered, check_journal, complete
from soak.operators import Orders, wishes
from soak.session_process import WatchedClock
from soak.soak import ENDLESS_KWH, Plan, Sample, endless_boat, flat, page, soak
from trainer.config.boat.vessel import load_vessel
from trainer.io.recording.recording import Recording
from trainer.session.stations.roles import ROLES, refusal

posix = pytest.mark.skipif(os.name != "posix", reason="signals and forks of POSIX")


@pytest.mark.parametrize("role", ROLES)
def test_random_orders_are_the_role_s_to_give_and_of_the_grammar(role: str) -> None:
    orders = Orders(ROLES[role], random.Random(1))  # noqa: S311  choices, not secrets
    said = {orders.next() for _ in range(300)} if orders else set()

    assert len(said) > 40 or role in ("observer", "class")
    for words in said:
        order = read_order(words)
        assert refusal(ROLES[role], order) is None


@pytest.mark.parametrize("role", ROLES)
def test_operators_ask_for_channels_of_their_role_even_where_it_has_few(role: str) -> None:
    dice = random.Random(1)  # noqa: S311  choices, not secrets
    asked = {wish.split()[1] for _ in range(200) for wish in wishes(ROLES[role], dice)}
    assert asked == set(ROLES[role].channels)


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
        recorded.order(3, giver_at("helm at x"), "rudder left 5")
        recorded.order(3, giver_at("helm at x"), "rudder left 6")
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
    assert flat(level, 0).kept
    assert not flat(growing, 0).kept
    assert "not judged: 2 looks" in flat(growing[:3], 0).seen


def test_memory_may_grow_by_a_kilobyte_for_each_order() -> None:
    growing = [Sample(float(at), 100_000 + 30 * at) for at in range(200)]  # 2 MB between medians
    assert flat(growing, 6000).kept
    assert not flat(growing, 2000).kept


@pytest.mark.alone
@pytest.mark.clock
@pytest.mark.process
@posix
@pytest.mark.long
def test_a_soak_at_full_speed_keeps_every_promise() -> None:
    found = soak(Plan(900.0, real_time=False, seed=5), None, lambda *_: None)
    assert found.kept, page(found)
    assert found.orders > 0  # how many, the machine decides
    assert found.visits > 0


@pytest.mark.alone
@pytest.mark.clock
@pytest.mark.process
@posix
@pytest.mark.long
def test_a_soak_in_real_time_keeps_every_promise_and_does_not_drift() -> None:
    found = soak(Plan(4.0, real_time=True, seed=6), None, lambda *_: None)
    assert found.kept, page(found)
    drift = re.search(r"(\d+) deadlines; 0 not at start", page(found))
    assert drift
    assert int(drift[1]) == 8


@pytest.mark.process
@posix
def test_an_operator_who_fails_ends_the_soak_by_his_fault(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object) -> None:
        raise ZeroDivisionError

    monkeypatch.setattr("soak.soak.attend", fail)
    with pytest.raises(ZeroDivisionError):
        soak(Plan(900.0, real_time=False, seed=7), None, lambda *_: None)


def test_the_boat_of_a_soak_has_neither_depths_nor_an_end_of_its_battery(tmp_path: Path) -> None:
    (tmp_path / "boat.toml").write_text(endless_boat(), encoding="utf-8")
    vessel = load_vessel(str(tmp_path / "boat.toml"))
    assert vessel.plant
    assert vessel.plant.battery.capacity_kwh == ENDLESS_KWH
    assert vessel.hull.collapse_depth_m is None
