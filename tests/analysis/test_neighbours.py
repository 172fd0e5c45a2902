"""A number that 1 % of a hull's own coefficients moves too far is told, and not judged."""

from collections.abc import Sequence
from dataclasses import replace
from functools import cache

import pytest

from trainer.analysis.guide import verdicts
from trainer.analysis.guide.contents import assemble_guide, tally_set
from trainer.analysis.guide.programme import Leg, fly_all
from trainer.analysis.guide.verdicts import (
    BEYOND_TOLERANCE,
    NOT_DETERMINED,
    WITHIN_TOLERANCE,
    Judgement,
    judge,
    neighbour_moves,
    set_apart,
)
from trainer.analysis.manoeuvres.flight import Flight, fly_manoeuvre
from trainer.analysis.manoeuvres.submarine import Submarine
from trainer.analysis.reduce import objective, page, reduction
from trainer.analysis.reduce.objective import Candidate, CandidatePool, Yardstick
from trainer.analysis.reduce.programme import turn_legs
from trainer.analysis.reduce.reduction import PART_TOLERANCES, LegVerdict, Reduction, judge_legs
from trainer.config.boat.vessel import VesselFile, load_vessel
from trainer.units import KNOT

# BB2 turns so hard at 10 kn that her planes barely keep the depth
HARD_TURN = "turn, rudder 30 deg, starboard, 10 kn"
DOUBTFUL, SURE = "last depth change", "steady yaw rate"


@cache
def hard_turn() -> tuple[VesselFile, Leg, Flight]:
    """Return BB2, her hard turn and the full set's flight of it."""
    file = load_vessel("bb2")
    leg = next(leg for leg in turn_legs(file) if leg.title == HARD_TURN)
    boat = Submarine(file, leg.method(file, "full"), leg.rig)
    return file, leg, fly_manoeuvre(boat, leg.manoeuvre, leg.speed_kn * KNOT)


def off_by(multiples: dict[str, float]) -> tuple[Judgement, ...]:
    """Return the hard turn judged beside itself, some numbers off by multiples of the allowed."""
    _, leg, full = hard_turn()

    def moved(one: Judgement) -> Judgement:
        multiple = multiples.get(one.quantity, 0.0)
        assert not multiple or (one.allowed and one.full is not None)
        other = None if one.full is None else one.full + multiple * (one.allowed or 0.0)
        verdict = BEYOND_TOLERANCE if multiple > 1.0 else one.verdict
        return replace(one, other=other, verdict=verdict)

    return tuple(moved(one) for one in judge(leg.manoeuvre, full, full))


def verdicts_of(found: Sequence[Judgement]) -> dict[str, str]:
    """Return the verdicts by quantity."""
    return {one.quantity: one.verdict for one in found}


def test_moves_are_those_of_the_full_set_with_a_row_one_percent_off() -> None:
    file, leg, full = hard_turn()

    moves = neighbour_moves(file, leg, full)

    alone = []
    for change in (1.01, 0.99):
        moved = {
            name: value * (change if name[0] == "Y" else 1.0)
            for name, value in file.coefficients.items()
        }
        boat = Submarine(replace(file, coefficients=moved), leg.method(file, "full"), leg.rig)
        other = fly_manoeuvre(boat, leg.manoeuvre, leg.speed_kn * KNOT)
        (one,) = (one for one in judge(leg.manoeuvre, full, other) if one.quantity == DOUBTFUL)
        assert one.difference is not None
        assert one.allowed is not None
        alone.append(abs(one.difference) / one.allowed)
    assert moves[DOUBTFUL] == pytest.approx(max(alone))  # no other row moves it further
    assert moves[DOUBTFUL] > 1.0
    assert moves[SURE] < 1.0


def test_what_neighbours_move_too_is_told_and_all_else_judged() -> None:
    file, leg, full = hard_turn()

    found = verdicts_of(set_apart(file, leg, full, off_by({DOUBTFUL: 1.5, SURE: 1.5})))

    assert found[DOUBTFUL] == NOT_DETERMINED
    assert found[SURE] == BEYOND_TOLERANCE
    assert found["steady speed"] == WITHIN_TOLERANCE


def test_neighbours_count_by_the_share_that_is_allowed() -> None:
    file, leg, full = hard_turn()
    move = neighbour_moves(file, leg, full)[DOUBTFUL]
    far = off_by({DOUBTFUL: 5.0})

    assert verdicts_of(set_apart(file, leg, full, far, 0.9 * move))[DOUBTFUL] == NOT_DETERMINED
    assert verdicts_of(set_apart(file, leg, full, far, 1.1 * move))[DOUBTFUL] == BEYOND_TOLERANCE


def test_nothing_flies_where_nothing_is_beyond(monkeypatch: pytest.MonkeyPatch) -> None:
    def fly(*_: object) -> None:
        raise AssertionError("it flies")

    monkeypatch.setattr(verdicts, "fly_boat", fly)
    within = off_by({DOUBTFUL: 0.9})

    assert set_apart(*hard_turn(), within) == within
    with pytest.raises(AssertionError, match="it flies"):
        set_apart(*hard_turn(), off_by({DOUBTFUL: 1.1}))


def test_a_search_does_not_see_what_the_hull_does_not_determine() -> None:
    file, leg, _ = hard_turn()
    candidate = Candidate(file, "modified")
    factors = [0.9 if name == "N_r" else 1.0 for name in candidate.terms]
    candidate.take(factors)

    yardstick = Yardstick(file, (leg,))
    with CandidatePool(file.path, "modified", (leg,), 1) as pool:
        (seen,) = pool.differences([factors])  # type: ignore[list-item]

    left_out = {
        row.quantity for row, sure in zip(pool.rows, yardstick.determined, strict=True) if not sure
    }
    assert left_out == {"largest depth change", DOUBTFUL}
    for row, flown, one in zip(pool.rows, yardstick.differences(candidate), seen, strict=True):
        assert flown != 0.0
        assert one == (0.0 if row.quantity in left_out else flown), row


def test_the_guide_counts_it_among_what_is_not_judged() -> None:
    """Of the modified set, on which the guide's verdict rests."""
    file, leg, full = hard_turn()
    tasks = [leg.task(file, equations) for equations in ("full", "modified", "basic")]
    flown = fly_all(file.path, tasks, 1, lambda: None)
    z = full.column("z")
    deeper = full.series.columns | {"z": z[0] + 1.075 * (z - z[0])}  # 1.5 of the 5 % allowed
    wrong = replace(full, series=replace(full.series, columns=deeper))
    leg = replace(leg, checks=(DOUBTFUL, SURE))

    guide = assemble_guide(file, (leg,), "now", {**flown, leg.task(file, "modified"): wrong}).guide

    assert verdicts_of(guide.sheets[0].judgements["modified"])[DOUBTFUL] == NOT_DETERMINED
    counts = tally_set(guide, "modified")
    assert counts["beyond"] == 0
    assert counts["shown"] == len(guide.sheets[0].judgements["modified"]) - counts["within"]


def test_each_part_of_a_verdict_asks_by_what_it_allows(monkeypatch: pytest.MonkeyPatch) -> None:
    file, leg, _ = hard_turn()
    shares = []

    def note(*given: object) -> tuple[Judgement, ...]:
        shares.append(given[-1])
        return ()

    monkeypatch.setattr(reduction, "verdict_legs", lambda *_: (leg,))
    monkeypatch.setattr(objective, "set_apart", note)
    judge_legs(file, Candidate(file, "modified"))

    assert shares == [percent / 5.0 for percent in PART_TOLERANCES.values()]


def test_the_page_of_a_reduction_names_it() -> None:
    doubtful = LegVerdict("held out", "climbing turn, port, 3 kn", 4, 0, 0.5, SURE, (DOUBTFUL,))

    report = Reduction("a boat", 3, 3, (), (), (), (), (doubtful,), None, passed=True)

    text = " ".join(page.render(report).split())

    assert "climbing turn, port, 3 kn: not judged, not determined (below): last depth" in text
    assert "numbers that are not determined: 1. One row of" in text
