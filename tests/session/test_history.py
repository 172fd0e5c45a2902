"""The moments kept in memory, against a plain list of them."""

import tracemalloc

from hypothesis import given
from hypothesis import strategies as st

from trainer.io.recording.recording import Moment
from trainer.session.past.journal import Moments

MOST = 4
acts = st.lists(
    st.one_of(
        st.tuples(st.just("later by"), st.integers(1, 3)),
        st.tuples(st.just("forget after"), st.integers(0, 30)),
        st.tuples(st.just("clear"), st.just(0)),
    ),
    max_size=30,
)


def moment(tick: int) -> Moment:
    return Moment(2, tick, bytes([tick % 256] * 8), 3 * tick, 1)


@given(acts)
def test_moments_are_those_of_a_list_that_keeps_the_latest(acts: list[tuple[str, int]]) -> None:
    moments, plain, tick = Moments(MOST, 8), list[Moment](), 0
    for act, number in acts:
        if act == "later by":
            tick += number
            moments.append(moment(tick))
            plain = [*plain, moment(tick)][-MOST:]
        elif act == "forget after":
            tick = min(tick, number)
            moments.forget_after(tick)
            plain = [each for each in plain if each.tick <= tick]
        else:
            moments.clear()
            plain = []

        assert len(moments) == len(plain)
        for asked in range(tick + 2):
            earlier = [each for each in plain if each.tick <= asked]
            assert moments.before(asked) == (earlier[-1] if earlier else None)


def test_memory_for_moments_is_taken_at_the_start() -> None:
    moments, state = Moments(360, 2000), bytes(2000)
    tracemalloc.start()
    before, _ = tracemalloc.get_traced_memory()
    for tick in range(300):
        moments.append(Moment(1, tick, state[:1999] + b"x", tick, 0))
    after, _ = tracemalloc.get_traced_memory()
    tracemalloc.stop()

    assert len(moments) == 300
    assert after - before < 4000
