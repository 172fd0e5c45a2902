"""What is subscribed is sent: the latest only, at its rate, and never in the way of the tick."""

import sys
import threading
from collections.abc import Iterator

import pytest
from helpers.boats import start_bb2

from trainer.boat.boat import Boat
from trainer.session.stations.subscriptions import Publisher, Roster, Subscription
from trainer.session.stations.view import Frame, Pace, Picture, StateReader
from trainer.session.time.ledger import Ledger

PATIENCE = 60.0  # [s] far beyond what any wait here needs
RUNNING, FROZEN = Pace(), Pace(frozen=True)


class Receiver:
    """A line that keeps what it is sent."""

    def __init__(self) -> None:
        self.lines: list[str] = []
        self.came = threading.Condition()

    def send(self, line: str) -> None:
        with self.came:
            self.lines.append(line)
            self.came.notify_all()

    def await_lines(self, count: int) -> list[str]:
        with self.came:
            assert self.came.wait_for(lambda: len(self.lines) >= count, PATIENCE)
            return list(self.lines)


class Hung:
    """A line whose send never returns until it is let go."""

    def __init__(self) -> None:
        self.reached = threading.Event()
        self.let_go = threading.Event()

    def send(self, line: str) -> None:
        self.reached.set()
        assert self.let_go.wait(PATIENCE), line


class TickOnly:
    """A display of the tick, and of nothing else."""

    def lines(self, frame: Frame) -> list[str]:
        return [str(frame.tick)]


class Broken:
    """A display that fails."""

    def lines(self, frame: Frame) -> list[str]:
        raise KeyError(frame.tick)


@pytest.fixture(scope="module")
def boat() -> Boat:
    return start_bb2()


@pytest.fixture
def roster(boat: Boat) -> Roster:
    return Roster(StateReader(boat, Ledger(0.5).summary))


@pytest.fixture
def publisher(roster: Roster) -> Iterator[Publisher]:
    publisher = Publisher(roster)
    yield publisher
    publisher.close(PATIENCE)
    assert "publisher" not in {thread.name for thread in threading.enumerate()}


def state_at(boat: Boat, tick: int) -> bytes:
    state = boat.records.state.copy()
    state["tick"] = tick
    return bytes(state.tobytes())


def picture(boat: Boat, tick: int, pace: Pace = RUNNING) -> Picture:
    return Picture(tick, state_at(boat, tick), pace)


def ticks(rate: float = 0.0) -> tuple[Receiver, Subscription]:
    """Return a subscription to the tick alone, and where it goes."""
    to = Receiver()
    return to, Subscription(to, "ticks", rate, TickOnly())


def test_a_subscriber_that_comes_late_gets_its_first_line_at_once(
    publisher: Publisher, boat: Boat
) -> None:
    first, early = ticks()
    publisher.add(early)
    publisher.offer(7, state_at(boat, 7), FROZEN)
    assert first.await_lines(1) == ["7"]
    to, subscription = ticks(0.1)

    publisher.add(subscription)

    assert to.await_lines(1) == ["7"]


def test_with_nobody_there_a_tick_wakes_no_thread_and_the_first_to_come_is_served_in_one_round(
    publisher: Publisher, roster: Roster, boat: Boat, monkeypatch: pytest.MonkeyPatch
) -> None:
    rounds: list[int] = []
    serve = roster.serve

    def counted(shown: Picture, now: float) -> float:
        rounds.append(shown.tick)
        return serve(shown, now)

    monkeypatch.setattr(roster, "serve", counted)
    for tick in range(5):
        publisher.offer(tick, state_at(boat, tick), FROZEN)
        threading.Event().wait(0.02)  # two rounds would have had time
    to, subscription = ticks()

    publisher.add(subscription)

    assert to.await_lines(1) == ["4"]
    assert rounds == [4]


def test_a_sender_that_hangs_does_not_hold_up_the_tick(publisher: Publisher, boat: Boat) -> None:
    hung = Hung()
    publisher.add(Subscription(hung, "ticks", 0.0, TickOnly()))
    publisher.offer(0, state_at(boat, 0), RUNNING)
    assert hung.reached.wait(PATIENCE)

    # returns though nothing can be sent; were it to wait, the letting go would never come
    for tick in range(1, 10_000):
        publisher.offer(tick, b"", RUNNING)
    publisher.offer(10_000, state_at(boat, 10_000), RUNNING)
    to, subscription = ticks()
    publisher.add(subscription)
    hung.let_go.set()

    assert to.await_lines(1) == ["10000"]


def test_an_error_in_one_display_ends_that_subscription_and_no_other(
    publisher: Publisher, roster: Roster, boat: Boat
) -> None:
    to, subscription = ticks()
    publisher.add(Subscription(Receiver(), "cursed", 0.0, Broken()))
    publisher.add(subscription)

    publisher.offer(3, state_at(boat, 3), RUNNING)
    assert to.await_lines(1) == ["3"]
    publisher.offer(4, state_at(boat, 4), RUNNING)

    assert to.await_lines(2) == ["3", "4"]
    assert list(roster.troubles) == ["cursed ended on one line: KeyError: 3"]


def test_a_state_that_cannot_be_read_ends_who_was_to_see_it_and_nothing_else(
    roster: Roster, boat: Boat
) -> None:
    to, subscription = ticks()
    roster.add(subscription)
    roster.serve(Picture(1, b"short", RUNNING), 1.0)
    late, again = ticks()
    roster.add(again)

    roster.serve(picture(boat, 2), 2.0)

    assert (to.lines, late.lines) == ([], ["2"])
    assert [trouble.partition(":")[0] for trouble in roster.troubles] == ["ticks ended on one line"]


def test_closing_sends_what_is_due_first(roster: Roster, boat: Boat) -> None:
    publisher = Publisher(roster)
    to, subscription = ticks()
    publisher.add(subscription)
    publisher.offer(9, state_at(boat, 9), FROZEN)

    publisher.close(PATIENCE)

    assert to.lines[-1] == "9"


@pytest.mark.slow
@pytest.mark.parametrize("rate", [0.1, 2.0, 10.0, 50.0])
def test_no_more_lines_are_sent_than_the_rate_allows(
    roster: Roster, boat: Boat, rate: float
) -> None:
    to, subscription = ticks(rate)
    roster.add(subscription)

    # twenty seconds of the clock in steps of 4 ms, with a new tick at each
    for i in range(5000):
        roster.serve(picture(boat, i), 100.0 + 0.004 * i)

    assert 20.0 * rate - 1.0 <= len(to.lines) <= 20.0 * rate + 1.0


def test_a_rate_that_the_ticks_only_just_keep_passes_none_over(roster: Roster, boat: Boat) -> None:
    to, subscription = ticks(2.0)
    roster.add(subscription)

    # ticks at 2 Hz, each up to 60 ms late
    for tick in range(200):
        roster.serve(picture(boat, tick), 50.0 + 0.5 * tick + 0.03 * (tick % 3))

    assert to.lines == [str(tick) for tick in range(200)]


def test_what_has_to_wait_for_its_rate_is_sent_when_its_time_comes(
    roster: Roster, boat: Boat
) -> None:
    to, subscription = ticks(2.0)
    roster.add(subscription)
    roster.serve(picture(boat, 0), 10.0)

    wait = roster.serve(picture(boat, 1), 10.1)

    assert wait == pytest.approx(0.4)
    assert to.lines == ["0"]
    roster.serve(picture(boat, 2), 10.1 + wait)
    assert to.lines == ["0", "2"]


def test_the_same_tick_is_not_sent_twice_unless_time_is_stopped_or_let_go_on(
    roster: Roster, boat: Boat
) -> None:
    to, subscription = ticks()
    roster.add(subscription)

    for now, pace in enumerate((RUNNING, RUNNING, FROZEN, FROZEN, FROZEN, RUNNING)):
        roster.serve(picture(boat, 5, pace), float(now))

    assert to.lines == ["5"] * 3


def test_a_freeze_shows_at_once_whatever_the_rate(roster: Roster, boat: Boat) -> None:
    to, subscription = ticks(0.1)
    roster.add(subscription)
    roster.serve(picture(boat, 5), 1.0)

    roster.serve(picture(boat, 6, FROZEN), 1.001)

    assert to.lines == ["5", "6"]


def test_an_order_given_while_time_stands_shows_though_the_tick_is_the_same(
    roster: Roster, boat: Boat
) -> None:
    to, subscription = ticks()
    roster.add(subscription)
    before = picture(boat, 5, FROZEN)
    ordered = boat.records.state.copy()
    ordered["tick"], ordered["ordered_depth"] = 5, 99.0

    roster.serve(before, 1.0)
    roster.serve(before._replace(state=ordered.tobytes()), 2.0)

    assert to.lines == ["5", "5"]


def test_subscriptions_that_come_and_go_leave_nothing_in_memory(roster: Roster) -> None:
    for _ in range(15):
        roster.add(ticks()[1])

    def come_and_go(times: int) -> None:
        for _ in range(times):
            _, subscription = ticks()
            roster.add(subscription)
            roster.strike(subscription)

    come_and_go(50)
    before = sys.getallocatedblocks()
    come_and_go(500)

    assert sys.getallocatedblocks() - before < 100


def test_what_is_shown_at_once_puts_off_nothing_that_comes_after(
    roster: Roster, boat: Boat
) -> None:
    to, subscription = ticks(0.5)
    roster.add(subscription)
    for i in range(8):  # frozen and let go on, within a second
        roster.serve(picture(boat, i, (RUNNING, FROZEN)[i % 2]), 10.0 + 0.1 * i)

    wait = roster.serve(picture(boat, 9, FROZEN), 11.0)

    assert to.lines[-1] == "7"
    assert wait == pytest.approx(1.7)
