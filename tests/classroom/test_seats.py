"""The seats of a class: who gets which boat, and for how long."""

from contextlib import ExitStack

import pytest

from trainer.classroom.seats import EVERY_BOAT, HELD_S, MAX_SEATS, SEAT_COOKIE, Seats
from trainer.web.bridge import MAX_PAGES_OF_MACHINE, RefusedError

BOATS = (1, 2, 3)


def test_who_comes_gets_the_first_boat_with_nobody_aboard() -> None:
    seats = Seats()
    taken = []
    while (boat := seats.next_free(BOATS)) is not None:
        seats.take(boat, "", {})
        taken.append(boat)

    assert taken == [1, 2, 3]
    assert [len(seats.crew_of(boat)) for boat in BOATS] == [1, 1, 1]


def test_a_boat_is_free_again_a_minute_after_its_last_line() -> None:
    now = [0.0]
    seats = Seats(clock=lambda: now[0])
    seat = seats.seat_of({SEAT_COOKIE: seats.take(1, "", {})})
    assert seat
    with seats.carrying_line(seat):
        now[0] = 10.0 * HELD_S
        assert seats.next_free(BOATS) == 2
    now[0] += HELD_S - 1.0
    assert seats.next_free(BOATS) == 2
    now[0] += 2.0
    assert seats.next_free(BOATS) == 1


def test_a_browser_has_one_seat_and_an_instructor_all() -> None:
    seats = Seats()
    first = {SEAT_COOKIE: seats.take(1, "", {})}
    second = {SEAT_COOKIE: seats.take(2, "", first)}
    all_boats = seats.seat_of({SEAT_COOKIE: seats.take(EVERY_BOAT, "", {})})
    moved = seats.seat_of(second)

    assert seats.seat_of(first) is None
    assert moved
    assert [moved.covers(boat) for boat in BOATS] == [False, True, False]
    assert all_boats
    assert all(all_boats.covers(boat) for boat in BOATS)
    assert seats.seat_of({}) is None


def test_a_flood_of_seats_shuts_out_nobody_who_has_a_line() -> None:
    seats = Seats()
    key = seats.take(1, "", {})
    seat = seats.seat_of({SEAT_COOKIE: key})
    assert seat
    with seats.carrying_line(seat):
        for i in range(2 * MAX_SEATS):
            seats.take(2, "", {}, f"192.0.2.{i}")
        assert seats.seat_of({SEAT_COOKIE: key}) is seat
    assert len(seats.by_key) == MAX_SEATS


def test_a_machine_that_takes_seats_without_end_pushes_out_its_own_alone() -> None:
    seats = Seats()
    other = seats.take(1, "A. Trainee", {}, "192.0.2.1")
    for _ in range(100):
        seats.take(2, "A. Flood", {}, "192.0.2.2")

    assert seats.seat_of({SEAT_COOKIE: other})
    assert len(seats.crew_of(2)) == MAX_PAGES_OF_MACHINE


def test_a_machine_whose_seats_all_have_a_page_gets_no_further_one() -> None:
    seats = Seats()
    with ExitStack() as lines:
        for _ in range(MAX_PAGES_OF_MACHINE):
            seat = seats.seat_of({SEAT_COOKIE: seats.take(1, "", {}, "192.0.2.1")})
            assert seat
            lines.enter_context(seats.carrying_line(seat))
        with pytest.raises(RefusedError, match="8 seats of your machine are taken: close one"):
            seats.take(1, "", {}, "192.0.2.1")
        assert seats.seat_of({SEAT_COOKIE: seats.take(1, "", {}, "192.0.2.2")})
    assert seats.seat_of({SEAT_COOKIE: seats.take(1, "", {}, "192.0.2.1")})
