"""The reduction as a computation: its flights, its fit, its search, its file, its command."""

import json
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from click.testing import CliRunner
from helpers.lanes import sample_cases

from trainer.analysis.guide import verdicts
from trainer.analysis.guide.programme import Leg, guide_legs, own_method
from trainer.analysis.guide.verdicts import (
    BEYOND_TOLERANCE,
    MAX_DIFFERENCE,
    NOT_JUDGED,
    Judgement,
    allowed_multiple,
    judge,
)
from trainer.analysis.manoeuvres.casualties import OutOfBalance, PlaneJam
from trainer.analysis.manoeuvres.catalogue import find_manoeuvre
from trainer.analysis.manoeuvres.flight import Conn, fly_manoeuvre
from trainer.analysis.manoeuvres.submarine import Submarine
from trainer.analysis.manoeuvres.turns import Turn
from trainer.analysis.manoeuvres.vehicle import Watch
from trainer.analysis.reduce import page, reduction
from trainer.analysis.reduce.objective import (
    ADDED_MASSES,
    CONTROL_COEFFICIENTS,
    Candidate,
    CandidatePool,
    Yardstick,
    fixed_terms,
)
from trainer.analysis.reduce.programme import (
    fastest_legs,
    fit_legs,
    holdout_legs,
    leg_speeds,
    legs_of_guide,
    turn_legs,
)
from trainer.analysis.reduce.reduction import (
    PART_TOLERANCES,
    LegVerdict,
    effect_table,
    judge_legs,
    passes_legs,
)
from trainer.analysis.reduce.search import (
    SLACKEST_LEASH,
    FactorPoint,
    Search,
    SearchAim,
    SearchState,
    Slopes,
    TermNeed,
    cost_rises,
    descend_slopes,
    without_terms,
)
from trainer.boat.assemble import Method, compact_coefficients
from trainer.cli.workshop.vessel import reduce
from trainer.config.boat.vessel import VesselFile, load_vessel, parse_vessel
from trainer.config.files import ConfigError
from trainer.core.kernel import Numbers
from trainer.core.terms import COMPACT_TERMS, EXTRA_TERMS
from trainer.units import KNOT

BOATS = ("bb2", "sdv-mk9", "remus100")
SLIM = """
[fluid]
rho = 1025.0
g = 9.81

[vessel]
length = 70.2
mass = 4418825.0
weight = 43348676.0
buoyancy = 43348676.0
cg = [0, 0, 0]
cb = [0.0, 0.0, -0.44]
Ix = 5.23e7
Iy = 1.375e9
Iz = 1.367e9

[propulsion]
[[propulsion.sets]]
eta_min = 0.0
a = -0.0016
b = -0.0032
c = 0.0048

[control_surfaces]
rudder_limit_deg = 30.0

[run]
speed_range_kn = [5.0, 15.0]

# the hull's data begin here
[coefficients]
X_vr = 2.99e-2
X_qq = -4.5e-4
Y_vdot = -3.0e-2
Y_v = -6.2e-2
Y_dr = 1.7e-2
Z_wdot = -2.1e-2
Z_w = -2.8e-2
K_p = -2.2e-4
K_pap = -1.3e-4
K_pdot = -4.1e-5
M_qdot = -1.2e-3
M_q = -5.9e-3
N_rdot = -1.4e-3
N_v = -9.4e-3
N_r = -6.0e-3
N_dr = -7.2e-3
N_rar = -1.8e-3
"""


@pytest.fixture
def slim(tmp_path: Path) -> VesselFile:
    """Return a boat of few terms, without planes: its search takes seconds."""
    path = tmp_path / "slim.toml"
    path.write_text(SLIM, encoding="utf-8")
    return load_vessel(str(path))


# --- many cycles in one call


class Plodding(Submarine):
    """A submarine that takes every cycle by itself."""

    @property
    def swift(self) -> bool:
        return False


@pytest.mark.parametrize(
    ("name", "speed"),
    [("meander", 10.0), ("zigzag-20", 10.0), ("vertical-zigzag", 15.0), ("crash-stop", 10.0)],
)
def test_many_cycles_in_one_call_are_those_of_cycle_by_cycle(name: str, speed: float) -> None:
    file = load_vessel("bb2")
    method = own_method(file, "modified")

    swift = fly_manoeuvre(Submarine(file, method), find_manoeuvre(name), speed * KNOT)
    plodding = fly_manoeuvre(Plodding(file, method), find_manoeuvre(name), speed * KNOT)

    assert swift.marks == plodding.marks
    for column in Submarine.columns:
        assert np.array_equal(swift.column(column), plodding.column(column)), column


def test_a_boat_lost_in_many_cycles_is_lost_where_it_was_cycle_by_cycle() -> None:
    file = load_vessel("remus100")
    method = own_method(file, "full")

    swift, plodding = (
        fly_manoeuvre(kind(file, method), find_manoeuvre("meander"), 4.0 * KNOT)
        for kind in (Submarine, Plodding)
    )

    assert "pitch is 80 degrees" in swift.lost
    assert swift.lost == plodding.lost
    assert len(swift.t) == len(plodding.t)


# --- events beside another's


class Climber:
    """A vehicle that does nothing but pitch up at a steady rate."""

    name, length, step = "climber", 1.0, 0.5
    columns = ("t", "theta")

    def __init__(self, rate: float) -> None:
        self.rate, self.cycles = rate, 0

    def observe(self) -> tuple[float, ...]:
        return self.cycles * self.step, self.cycles * self.step * self.rate

    def advance(self) -> None:
        self.cycles += 1


def event(rate: float, others: Sequence[float | None] = ()) -> float | None:
    """Return when a climber's pitch passes 1 rad, beside another's event."""
    vehicle = Climber(rate)
    conn = Conn(vehicle, others)  # type: ignore[arg-type]
    for _ in conn.until(Watch("theta", 1.0), 100.0):
        vehicle.advance()
        conn.look()
    return conn.events[0]


def test_an_event_within_a_cycle_of_the_others_is_taken_when_the_other_has_it() -> None:
    assert event(0.1) == 10.0
    assert event(0.102) == 10.0
    assert event(0.098) == 10.5

    assert event(0.098, [10.0]) == 10.0  # to come within the cycle
    assert event(0.107, [10.0]) == 10.0  # 9.35 s, seen at 9.5 s


def test_an_event_more_than_a_cycle_from_the_others_is_ones_own() -> None:
    assert event(0.12, [10.0]) == event(0.12) == 8.5
    assert event(0.09, [10.0]) == event(0.09) == 11.5
    assert event(0.1, [None]) == 10.0
    assert event(0.1, [0.5]) == 10.0


# --- what is flown


def test_turns_are_to_both_sides_at_four_speeds_by_six_rudders_and_both_engines() -> None:
    bb2, sdv = load_vessel("bb2"), load_vessel("sdv-mk9")

    assert leg_speeds(bb2) == (5.0, 10.0, 15.0, 20.0)
    assert {leg.manoeuvre.angle_deg for leg in turn_legs(bb2)} == {*range(5, 35, 5)}  # type: ignore[attr-defined]
    assert len(turn_legs(bb2)) == 96
    assert len(turn_legs(sdv)) == 48  # its engine has no limit
    assert sum(leg.manoeuvre.side == "port" for leg in turn_legs(bb2)) == 48  # type: ignore[attr-defined]
    limited = [leg for leg in turn_legs(bb2) if leg.rig.engine == "limited"]
    assert len(limited) == 48
    assert {leg.title for leg in limited if leg.title.endswith("engine limited")} == {
        leg.title for leg in limited
    }
    fitted = [leg for leg in fit_legs(bb2) if leg.name == "turn"]
    by_speed = {speed: set[float]() for speed in leg_speeds(bb2)}
    for leg in fitted:
        by_speed[leg.speed_kn].add(leg.manoeuvre.angle_deg)  # type: ignore[attr-defined]
    assert by_speed.pop(5.0) == {*range(5, 35, 5)}, "the guide's low speed"
    assert all(angles == {10.0, 20.0, 30.0} for angles in by_speed.values())
    assert {leg.speed_kn for leg in fitted if leg.rig.engine == "limited"} == {15.0, 20.0}
    guided = [leg for leg in guide_legs(bb2) if leg.rig.engine == "limited"]
    assert len(guided) == 4
    assert max(leg.manoeuvre.angle_deg for leg in turn_legs(sdv)) == 20.0  # type: ignore[attr-defined]
    assert leg_speeds(sdv) == (1.5, 3.0, 4.5, 6.0)


def test_turns_of_bb2_are_within_by_held_revolutions_and_by_its_engine() -> None:
    """Yaw rate, speed, heel and snap roll; without its torque some are beyond."""
    file = load_vessel("bb2")
    legs = [leg for leg in turn_legs(file) if leg.manoeuvre.angle_deg in (5.0, 20.0, 30.0)]  # type: ignore[attr-defined]
    yardstick, candidate = Yardstick(file, legs), Candidate(file, "modified")
    judged = ("steady yaw rate", "steady speed", "snap roll", "largest roll", "steady roll")
    places = [i for i, row in enumerate(yardstick.rows) if row.quantity in judged]
    worst = []
    for factor in (1.0, 0.0):
        filed = reduction.as_filed(file)
        filed["K_star_eta"] *= factor
        candidate.take([filed[name] for name in candidate.terms])
        worst.append(abs(yardstick.differences(candidate)[places]).max())
    assert len(places) >= 4 * len(legs)
    assert worst[0] < 0.7
    assert worst[1] > 1.0


def test_heel_is_judged_as_it_stands_with_a_tenth_of_a_degree_at_least() -> None:
    file = load_vessel("bb2")
    flight = fly_manoeuvre(Submarine(file, own_method(file, "full")), Turn(10.0), 20.0 * KNOT)
    measures = {one.name: one for one in Turn(10.0).measures(flight)}
    start, last = (float(flight.column("phi")[i]) for i in (0, -1))
    assert abs(start) > np.radians(0.5)
    assert measures["steady roll"].value == last
    assert measures["steady roll"].allowed == pytest.approx(max(0.05 * abs(last), np.radians(0.1)))
    slow = fly_manoeuvre(Submarine(file, own_method(file, "full")), Turn(5.0), 5.0 * KNOT)
    small = {one.name: one for one in Turn(5.0).measures(slow)}["steady roll"]
    assert small.value is not None
    assert abs(small.value) < np.radians(2.0)
    assert small.allowed == pytest.approx(np.radians(0.1))


@pytest.mark.slow
def test_what_is_held_out_is_neither_fitted_nor_tried() -> None:
    for name in BOATS:
        file = load_vessel(name)
        before = (*fit_legs(file), *fastest_legs(file), *legs_of_guide(file))
        known = {(leg.manoeuvre, leg.speed_kn) for leg in before}
        kinds = {leg.name for leg in holdout_legs(file)}

        assert not known & {(leg.manoeuvre, leg.speed_kn) for leg in holdout_legs(file)}
        assert kinds == {"zigzag-15", "climbing turn", "stern-plane jam", "out of balance"}
        seen = {leg.name.split()[0] for leg in (*fit_legs(file), *fastest_legs(file))}
        assert not {"zigzag", "climbing"} & seen


@pytest.mark.long
def test_no_two_flights_of_a_fit_have_one_name() -> None:
    for name in BOATS:
        file = load_vessel(name)
        for flights in (
            (*fit_legs(file), *fastest_legs(file)),
            legs_of_guide(file),
            holdout_legs(file),
        ):
            assert len({leg.title for leg in flights}) == len(flights), name


def test_a_boat_out_of_balance_sinks_or_is_held_by_planes_at_an_angle() -> None:
    file = load_vessel("bb2")
    boat = Submarine(file, own_method(file, "full"))

    heavy = fly_manoeuvre(boat, OutOfBalance(share=0.002, keep=()), 5.0 * KNOT)
    held = fly_manoeuvre(boat, OutOfBalance(share=-0.002), 10.0 * KNOT)
    again = fly_manoeuvre(boat, Turn(), 10.0 * KNOT)

    assert heavy.change("z")[-1] > 20.0
    assert abs(held.change("z")).max() < 1.0
    assert abs(held.change("delta_s")[-1]) > np.radians(0.5)
    assert abs(again.change("z")).max() < 15.0  # in balance once more


def test_planes_are_eased_until_the_full_set_is_not_lost_and_a_jam_until_it_is_recovered() -> None:
    file = load_vessel("remus100")
    boat = Submarine(file, own_method(file, "full"))

    flown = [
        (leg, fly_manoeuvre(boat, leg.manoeuvre, leg.speed_kn * KNOT)) for leg in fit_legs(file)
    ]
    jams = [leg for leg in holdout_legs(file) if isinstance(leg.manoeuvre, PlaneJam)]

    assert not [leg.title for leg, flight in flown if flight.lost]
    assert jams
    for leg in jams:
        assert fly_manoeuvre(boat, leg.manoeuvre, leg.speed_kn * KNOT).time_of("level") is not None


@pytest.mark.slow
@pytest.mark.parametrize("name", BOATS)
def test_the_kernel_has_room_for_all_that_the_shipped_hulls_have(name: str) -> None:
    file = load_vessel(name)
    candidate = Candidate(file, "modified")
    candidate.take([1.0] * len(candidate.terms))
    absent = {key for key, value in file.coefficients.items() if value} - set(candidate.terms)

    some = {leg.name: leg for leg in fit_legs(file) if leg.name != "roll-decay"}
    yardstick = Yardstick(file, list(some.values()))

    assert absent == set()
    # lagged accelerations and Adams' formula are what is left, not terms
    assert abs(yardstick.differences(candidate)).max() < 1.25


def test_what_a_candidate_cannot_start_counts_as_furthest() -> None:
    file = load_vessel("bb2")
    yardstick = Yardstick(file, turn_legs(file)[:1])
    candidate = Candidate(file, "modified")
    without_planes = {"M_ds": 0.0, "M_db": 0.0, "Z_ds": 0.0, "Z_db": 0.0}

    candidate.take([without_planes.get(term, 1.0) for term in candidate.terms])

    assert [judgements for _, judgements in yardstick.judged(candidate)] == [()]
    assert set(yardstick.differences(candidate)) == {MAX_DIFFERENCE}


def test_a_number_that_is_lacking_is_as_far_off_as_nothing_would_be() -> None:
    there = Judgement("snap roll", "rad", 0.04, None, 0.01, BEYOND_TOLERANCE)

    assert allowed_multiple(there) == -4.0
    assert allowed_multiple(replace(there, other=0.045)) == pytest.approx(0.5)
    assert allowed_multiple(replace(there, other=9.0)) == MAX_DIFFERENCE


# --- the fit


def linear(size: int) -> tuple[Slopes, Numbers]:
    """Return slopes and differences, at factors of 1, of a problem without curves."""
    generator = np.random.default_rng(5)
    table = generator.normal(size=(40, size))
    return Slopes(table, list(range(size)), 0.05), 0.1 * generator.normal(size=40)


def test_a_dropped_term_is_made_up_for_as_a_fit_without_it_would() -> None:
    slopes, differences = linear(5)
    here = FactorPoint(np.ones(5), differences)
    gone = without_terms(slopes, here, [3])

    # least squares of the weighted rows and the leash, by another way
    weights = np.maximum(abs(differences), 0.2) ** 2
    weights /= weights.max()
    rows = np.vstack([np.sqrt(weights)[:, None] * slopes.table, np.sqrt(0.05) * np.eye(5)])
    left = -rows @ np.array([0.0, 0.0, 0.0, -1.0, 0.0])
    rest = [0, 1, 2, 4]
    expected = 1.0 + np.linalg.lstsq(rows[:, rest], left, rcond=None)[0]

    assert gone[3] == 0.0
    assert gone[rest] == pytest.approx(np.clip(expected, 0.5, 2.0), abs=1e-9)


def test_the_term_that_does_least_costs_least() -> None:
    slopes, differences = linear(4)
    slopes.table[:, 2] *= 1e-3

    costs = cost_rises(slopes, FactorPoint(np.ones(4), differences))

    assert int(np.argmin(costs)) == 2


def test_a_fit_ends_in_its_goal_with_the_least_departure() -> None:
    slopes = Slopes(np.eye(3) * 2.0, [0, 1, 2], 0.05)

    def fly_all(several: Sequence[Numbers]) -> list[Numbers]:
        return [slopes.table @ (factors - 1.0) - np.array([0.0, 0.0, 1.0]) for factors in several]

    start = FactorPoint(np.ones(3), fly_all([np.ones(3)])[0])
    found = descend_slopes(fly_all, slopes, start, 3, 0.8)

    assert found.worst <= 0.8
    assert found.factors[:2] == pytest.approx(np.ones(2))
    assert 1.0 < found.factors[2] < 1.45  # the optimum is 1.5
    assert descend_slopes(fly_all, slopes, start, 3, 0.01).worst < 0.05


# --- the search


def searched(
    file: VesselFile, standing: SearchState | None = None, *, quick: bool = False
) -> Iterator[SearchState]:
    """Yield the standings of a search, round by round."""
    with CandidatePool(file.path, "modified", fit_legs(file), 1) as crew:
        stays = frozenset(CONTROL_COEFFICIENTS) | fixed_terms(file)
        search = Search(file, "modified", crew, SearchAim(crew.legs, SLACKEST_LEASH, stays, quick))
        standing = standing or search.begin()
        while not standing.done:
            standing = search.round(standing, lambda: None)
            yield standing


class Ended(NamedTuple):
    """The end of a search, and how many candidates it has flown."""

    standing: SearchState
    flown: int


@pytest.fixture(scope="module")
def ended(tmp_path_factory: pytest.TempPathFactory) -> tuple[Ended, Ended]:
    """Return how the usual and the quick search of the boat of few terms end."""
    path = tmp_path_factory.mktemp("searched") / "slim.toml"
    path.write_text(SLIM, encoding="utf-8")
    file, own, flown = load_vessel(str(path)), CandidatePool.differences, [0]

    def counted(self: CandidatePool, several: Sequence[Numbers]) -> list[Numbers]:
        flown[0] += len(several)
        return own(self, several)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(CandidatePool, "differences", counted)
        *_, usual = searched(file)
        before = flown[0]
        *_, fast = searched(file, quick=True)
    return Ended(usual, before), Ended(fast, flown[0] - before)


@pytest.mark.slow
def test_a_search_drops_what_nothing_needs_and_says_why_the_rest_stays(
    slim: VesselFile, ended: tuple[Ended, Ended]
) -> None:
    last = ended[0].standing
    terms = Candidate(slim, "modified").terms
    kept = {terms[i] for i in last.kept}

    held = {"N_dr", "Y_dr", *ADDED_MASSES} & set(terms)  # what the crew commands, and waves push

    assert not {"X_qq", "Z_w", "M_q"} & kept  # nothing of it happens without planes
    assert held <= kept
    assert {"N_r", "Y_v", "N_rar"} <= kept
    assert {need.term for need in last.needed} == kept - held
    assert all(need.worst > last.limit for need in last.needed)
    assert all(last.factors[i] == 0.0 for i in range(len(terms)) if i not in last.kept)


@pytest.mark.slow
def test_a_quick_search_flies_less_and_ends_in_the_same_limit(
    slim: VesselFile, ended: tuple[Ended, Ended]
) -> None:
    usual, fast = ended

    assert fast.flown < 0.5 * usual.flown
    assert fast.standing.limit == usual.standing.limit
    assert len(usual.standing.kept) <= len(fast.standing.kept) < 1.3 * len(usual.standing.kept)
    assert len(fast.standing.kept) < len(Candidate(slim, "modified").terms)


@pytest.mark.slow
def test_the_limit_follows_down_what_fewer_terms_reach(slim: VesselFile) -> None:
    loose = replace(next(searched(slim)), limit=5.0, proof=5.0)

    after = next(searched(slim, loose))

    assert len(after.kept) < len(loose.kept)
    assert 0.9 <= after.limit < 5.0
    assert 0.97 <= after.proof < 5.0


@pytest.mark.slow
def test_a_search_broken_off_ends_in_the_same_bits(slim: VesselFile, tmp_path: Path) -> None:
    path = tmp_path / "kept.json"
    through = list(searched(slim))

    for one in through[:-1]:
        reduction.save_standings(path, slim, {"modified": one})
        assert reduction.load_standings(path, slim)["modified"] == one
    middle = len(through) // 2
    assert list(searched(slim, through[middle])) == through[middle + 1 :]

    other = replace(slim, text=slim.text + "\n# changed")
    assert reduction.load_standings(path, other) == {}
    path.write_text("{broken", encoding="utf-8")
    assert reduction.load_standings(path, slim) == {}


@pytest.fixture
def narrow(slim: VesselFile, monkeypatch: pytest.MonkeyPatch) -> Leg:
    """Let searches fit to three turns and a weave; return the weave at top speed."""
    slow, *_, fast = (leg for leg in fit_legs(slim) if leg.name == "weave")
    monkeypatch.setattr(reduction, "fit_legs", lambda file: (*turn_legs(file)[3:6], slow))
    monkeypatch.setattr(reduction, "fastest_legs", lambda _: (fast,))
    return fast


def searches(partial: Path) -> list[str]:
    """Return the names of the searches that a file has."""
    return [name for name in json.loads(partial.read_text()) if name != "of"]


@pytest.mark.slow
def test_a_set_astray_at_the_top_speed_is_searched_for_anew_with_flights_there(
    slim: VesselFile, narrow: Leg, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    partial = tmp_path / "kept.json"

    once = reduction.search(slim, 1, partial, lambda _: None)
    astray = reduction.largest_difference(slim, [narrow], once.factors["modified"])
    assert searches(partial) == ["4 flights"]

    monkeypatch.setattr(reduction, "ASTRAY_RATIO", 0.9 * astray)
    twice = reduction.search(slim, 1, partial, lambda _: None)

    assert searches(partial) == ["4 flights", "5 flights"]
    assert reduction.largest_difference(slim, [narrow], twice.factors["modified"]) < 0.9 * astray


def test_added_masses_and_what_the_file_holds_are_left_as_the_hull_has_them(
    slim: VesselFile,
) -> None:
    held = parse_vessel(SLIM + '[reduce]\nheld_terms = ["K_pap"]\n', slim.path)

    assert "K_pap" not in fixed_terms(slim)
    assert {"Y_vdot", "Z_wdot", "K_pdot", "M_qdot", "N_rdot", "K_pap"} <= fixed_terms(held)
    with pytest.raises(ConfigError, match=r"held_terms.*K_papa.*K_pap"):
        parse_vessel(SLIM + '[reduce]\nheld_terms = ["K_papa"]\n', slim.path)


@pytest.mark.usefixtures("narrow")
@pytest.mark.slow
def test_a_search_leaves_added_masses_and_held_terms_alone(
    slim: VesselFile, tmp_path: Path
) -> None:
    slim.path.write_text(SLIM + '[reduce]\nheld_terms = ["K_pap"]\n', encoding="utf-8")
    file = load_vessel(str(slim.path))

    found = reduction.search(file, 1, tmp_path / "kept.json", lambda _: None)

    for factors in found.factors.values():
        assert all(factors[term] == 1.0 for term in fixed_terms(file) if term in factors)


@pytest.mark.usefixtures("narrow")
@pytest.mark.slow
def test_a_second_search_broken_off_ends_in_the_same_bits(
    slim: VesselFile, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    partial = tmp_path / "kept.json"
    monkeypatch.setattr(reduction, "ASTRAY_RATIO", 0.0)

    def break_off(_: int) -> None:
        if partial.exists() and len(searches(partial)) == reduction.MAX_SEARCHES:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        reduction.search(slim, 1, partial, break_off)
    after = reduction.search(slim, 1, partial, lambda _: None)

    assert after == reduction.search(slim, 1, None, lambda _: None)


@pytest.mark.process
@pytest.mark.slow
def test_two_processes_find_the_bits_of_one(slim: VesselFile) -> None:
    factors = np.ones(len(Candidate(slim, "modified").terms))
    several = [factors * (1.0 + 0.01 * i) for i in range(3)]

    one, two = (CandidatePool(slim.path, "modified", fit_legs(slim), cores) for cores in (1, 2))
    with one, two:
        alone, together = one.differences(several), two.differences(several)

    assert all(np.array_equal(a, b) for a, b in zip(alone, together, strict=True))


# --- the file


def test_the_tables_read_back_as_the_factors_found_and_nothing_else_moves() -> None:
    file = parse_vessel(SLIM + "[compensation.modified]   # old\nN_r = 3.0\n", Path("boat.toml"))
    names = Candidate(file, "modified").terms
    modified = {name: 0.0 if name in {"X_qq", "Z_w"} else 1.25 for name in names}
    needs = (TermNeed("X_vr", 7.5, "turn, rudder 10 deg, 5 kn", "steady speed"),)
    tables = page.factor_tables({"modified": modified, "basic": modified}, needs, {"kept": 14})

    text = page.rewrite_vessel(file.text, tables)
    back = parse_vessel(text, Path("boat.toml"))

    assert back.compact.extra_terms == ("X_vr", "K_pap", "N_rar")
    found = compact_coefficients(back, "modified")
    for name, factor in modified.items():
        assert found.get(name, 0.0) == pytest.approx(factor * file.coefficients[name])
    assert back.coefficients == file.coefficients
    assert "steady speed in turn, rudder 10 deg, 5 kn: 7.5 of the allowed" in text
    assert "# the hull's data begin here\n[coefficients]" in text
    assert "N_r = 3.0" not in text
    assert page.rewrite_vessel(text, tables) == text


# --- the verdict and the command


@pytest.mark.long
@pytest.mark.parametrize("name", sample_cases(BOATS, "bb2"))
def test_the_compact_set_of_a_shipped_boat_passes_guide_turns_and_what_it_has_not_seen(
    name: str,
) -> None:
    file = load_vessel(name)
    candidate = Candidate(file, "modified")
    factors = reduction.as_filed(file)
    candidate.take([factors[term] for term in candidate.terms])

    checked = judge_legs(file, candidate)

    assert {one.part for one in checked} == set(PART_TOLERANCES)
    assert [(one.leg, one.quantity) for one in checked if one.beyond] == []
    assert sum(factor != 0.0 for factor in factors.values()) < len(factors)


def test_a_boat_runs_by_the_factors_of_its_file() -> None:
    file = load_vessel("bb2")
    candidate = Candidate(file, "modified")
    factors = reduction.as_filed(file)
    candidate.take([factors[term] for term in candidate.terms])
    leg = turn_legs(file)[0]
    own = fly_manoeuvre(
        Submarine(file, own_method(file, "modified")), leg.manoeuvre, leg.speed_kn * KNOT
    )

    found = candidate.fly(leg, own)

    for column in Submarine.columns:
        assert np.array_equal(found.column(column), own.column(column)), column


@pytest.mark.slow
def test_a_set_that_is_out_is_told_by_leg_and_quantity(monkeypatch: pytest.MonkeyPatch) -> None:
    # neighbours of each leg that is out take half a minute, and are tried in test_neighbours
    monkeypatch.setattr(verdicts, "neighbour_moves", lambda *_: {})
    file = load_vessel("bb2")
    candidate = Candidate(file, "modified")
    factors = reduction.as_filed(file) | {"N_r": 0.0}
    candidate.take([factors[term] for term in candidate.terms])

    checked = judge_legs(file, candidate)

    assert not passes_legs(checked)
    turn = next(one for one in checked if one.leg == "turn, rudder 20 deg, port, 10 kn")
    assert turn.beyond > 0
    assert turn.worst > 1.0
    assert turn.quantity


def test_nothing_is_judged_where_the_full_set_is_lost() -> None:
    file = load_vessel("remus100")
    manoeuvre = find_manoeuvre("meander")
    lost = fly_manoeuvre(Submarine(file, own_method(file, "full")), manoeuvre, 4.0 * KNOT)
    other = fly_manoeuvre(Submarine(file, own_method(file, "modified")), manoeuvre, 4.0 * KNOT)

    assert lost.lost
    assert {one.verdict for one in judge(manoeuvre, lost, other)} == {NOT_JUDGED}


@pytest.mark.slow
def test_a_check_tells_how_many_manoeuvres_were_judged() -> None:
    code, out, _ = run("remus100", "--check")

    words = " ".join(out.split())
    assert code == 0
    assert "guide, 5 %: manoeuvres within, 65 of 65 judged, 7 not judged;" in words
    assert "steady turns, 5 %: manoeuvres within, 36 of 36 judged;" in words
    left = words.split("not judged, the full set is lost or cannot start: ")[1]
    assert left.startswith(
        "meander, rise, 2 kn; meander, dive, 2 kn; trim, rise, 2 kn; "
    )  # no level flight so slow
    assert "meander, rise, 4.5 kn" in left
    assert "climbing-turn, starboard, rise, 3 kn: not judged, not determined (below): " in words
    assert "numbers that are not determined: " in words


def test_a_set_of_which_nothing_is_judged_does_not_pass() -> None:
    blank = LegVerdict("guide", "meander, 2 kn", 0, 0, 0.0, "")

    assert blank.passed is None
    assert not passes_legs([blank])
    assert passes_legs([blank, replace(blank, judged=3)])
    assert not passes_legs([blank, replace(blank, judged=3, beyond=1)])


def test_a_heel_that_still_swings_is_not_judged_as_steady() -> None:
    file = load_vessel("bb2")
    flight = fly_manoeuvre(Submarine(file, own_method(file, "full")), Turn(), 10.0 * KNOT)
    t = flight.t

    def steady(rolls: Numbers) -> float | None:
        columns = flight.series.columns | {"phi": rolls}
        swinging = replace(flight, series=replace(flight.series, columns=columns))
        measures = {one.name: one for one in Turn().measures(swinging)}
        return measures["steady roll"].allowed

    assert steady(0.1 * (1.0 - np.exp(-t / 20.0))) == pytest.approx(0.005, rel=1e-3)
    assert steady(0.1 * (1.0 - np.exp(-t / 20.0)) + 0.02 * np.sin(t)) is None


def test_sensitivities_are_those_of_the_full_set_without_the_coefficient(slim: VesselFile) -> None:
    drops = {drop.coefficient: drop for drop in effect_table(slim, 1, lambda: None)}
    method = Method("full", "exact", "exact", "rk4", slim.run.step_s)
    less = replace(slim, coefficients={**slim.coefficients, "N_r": 0.0})

    def diameter(file: VesselFile) -> float:
        flight = fly_manoeuvre(Submarine(file, method), Turn(), file.run.start_speed_kn * KNOT)
        return {one.name: one.value for one in Turn().measures(flight)}["steady diameter"] or 0.0

    expected = 100.0 * (diameter(less) / diameter(slim) - 1.0)
    assert drops["N_r"].percent["turn: steady diameter"] == pytest.approx(expected)
    assert "X_qq" not in drops  # does nothing here


def run(*arguments: str) -> tuple[int, str, str]:
    """Return exit code, stdout and stderr or the error of a run of the command."""
    done = CliRunner().invoke(reduce, arguments)
    return done.exit_code, done.stdout, done.stderr or str(done.exception or "")


@pytest.mark.slow
def test_the_command_finds_writes_and_then_checks_a_set(slim: VesselFile, tmp_path: Path) -> None:
    result = tmp_path / "found.toml"

    code, out, _ = run(str(slim.path), "-o", str(result), "--cores", "1")
    assert code == 0, out
    assert "Within tolerance." in out
    assert "Why terms stay" in out
    assert max(map(len, out.splitlines())) <= 79
    assert not reduction.checkpoint_of(result).exists()

    code, out, _ = run(str(result), "--check", "--json")
    told = json.loads(out)
    assert code == 0
    assert told["passed"] is True
    kept = {one["term"] for one in told["kept"]}
    assert len(kept) < told["hull_terms"]
    assert kept & set(EXTRA_TERMS) == set(load_vessel(str(result)).compact.extra_terms)
    assert kept <= {*COMPACT_TERMS, *EXTRA_TERMS}


@pytest.mark.slow
def test_a_set_out_of_tolerance_is_exit_code_1_and_a_table_is_0(slim: VesselFile) -> None:
    text = SLIM + "[compensation.modified]\nN_r = 0.3\n"
    slim.path.write_text(text, encoding="utf-8")

    code, out, _ = run(str(slim.path), "--check")
    assert code == 1
    assert "Out of tolerance." in out

    code, out, _ = run(str(slim.path), "--table", "--cores", "1")
    assert code == 0
    assert "N_r" in out
    code, out, _ = run(str(slim.path), "--table", "--json", "--cores", "1")
    assert {"N_r", "Y_v"} <= {one["coefficient"] for one in json.loads(out)}


def test_options_that_exclude_one_another_are_refused() -> None:
    code, _, told = run("bb2", "--check", "--table")

    assert code == 2
    assert "--check and --table exclude one another" in told
