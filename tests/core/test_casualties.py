"""What breaks: how it comes on, what it does, how it is cleared, and what sets it off."""

import contextlib
import json
import math
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from helpers.boats import fly, make_boat, start_bb2, start_boat, take_ticks
from helpers.places import ROOT
from helpers.typed import type_command

from trainer.boat.boat import Boat
from trainer.boat.casualties import (
    InstrumentReadings,
    active_casualties,
    arm_casualty,
    clear_casualty,
    insert_casualty,
    instrument_readings,
)
from trainer.cli.main import cli
from trainer.config.boat.casualties import (
    as_json,
    listing,
    load_casualties,
    parse_casualties,
)
from trainer.config.exercise.condition import STATE_QUANTITIES
from trainer.config.exercise.derived import compile_condition
from trainer.config.files import ConfigError, Position, key_of, reading_recorded, shipped_path
from trainer.core.casualties import KINDS
from trainer.core.state import MAX_CASUALTIES
from trainer.core.surfaces import SURFACES
from trainer.io.orders.grammar import Refused
from trainer.io.recording.recording import Recording
from trainer.session.stations.status import status_lines
from trainer.session.time.ledger import Ledger

KNOT = 1852.0 / 3600.0
DEGREE = math.pi / 180.0
HERE = Position("my.toml", "casualties[0]")
FIELD = {"rudder": "r", "stern": "s", "bow": "b"}


@pytest.fixture
def boat() -> Boat:
    """Return a BB2 at 10 knots and 60 m."""
    return start_bb2()


def at_sea(knots: float = 10.0, depth: float = 60.0) -> Boat:
    """Return a BB2 at a speed and depth."""
    return start_boat(knots * KNOT, depth)


def begun(boat: Boat, name: str, *numbers: float | None) -> None:
    """Insert a casualty that must not be refused."""
    answer = insert_casualty(boat, name, *numbers)
    assert not isinstance(answer, Refused), answer.reason


def reason(answer: str | Refused) -> str:
    """Return why an order was refused."""
    assert isinstance(answer, Refused), answer
    return answer.reason


# How a casualty comes and goes


def kinds(boat: Boat) -> list[str]:
    return [each.kind for each in active_casualties(boat)]


def test_several_of_one_cause_come_and_go_by_one_order(boat: Boat) -> None:
    apart = start_bb2()
    for name, *numbers in (
        ("flooding-forward", 0.5, 0.0),
        ("bow-servo-stuck",),
        ("oil-leak-bow", 1.2),
        ("log-stuck",),
    ):
        begun(apart, name, *numbers)

    answer = insert_casualty(boat, "grounding forward")

    assert answer == (
        "casualty grounding-forward: breaks flooding-forward 0.5, bow-servo-stuck -0.33, "
        "oil-leak-bow 1.2, log-stuck"
    )
    for each in (boat, apart):
        take_ticks(each, 60)
    assert boat.plain.tobytes() == apart.plain.tobytes()
    assert clear_casualty(boat, "grounding-forward") == "clearing grounding-forward within 30 s"
    take_ticks(boat, 61)
    assert kinds(boat) == []
    assert "there is no grounding-forward" in reason(clear_casualty(boat, "grounding-forward"))


def test_several_of_one_cause_come_whole_or_not_at_all(boat: Boat) -> None:
    for name in ("rudder-slow", "stern-slow", "depth-gauge-noisy", "gyro-noisy", "log-stuck"):
        begun(boat, name)
    before = boat.snapshot().tobytes()
    for numbers, told in (
        ((2.0,), "grounding-forward: each part has its own degree and ramp"),
        ((None, 5.0), "order a part alone with another"),
    ):
        assert told in reason(insert_casualty(boat, "grounding-forward", *numbers))
    bare = make_boat("remus100")
    assert "grounding-forward: " in reason(insert_casualty(bare, "grounding-forward"))
    assert boat.snapshot().tobytes() == before

    begun(boat, "grounding-forward")  # the log is one of its own already

    assert len(kinds(boat)) == MAX_CASUALTIES
    before = boat.snapshot().tobytes()
    answer = insert_casualty(boat, "collision-amidships")
    assert "collision-amidships: 3 more, and 8 casualties at most: clear some of" in reason(answer)
    assert boat.snapshot().tobytes() == before
    clear_casualty(boat, "oil-leak-bow")  # one part alone
    assert kinds(boat)[0] == "rudder-slow"


def test_a_condition_breaks_all_parts_at_once(boat: Boat) -> None:
    condition = compile_condition("depth > 60.5", HERE)
    arm_casualty(boat, condition, boat.casualties["grounding-forward"])
    assert kinds(boat) == []

    boat.state.z = 61.0
    take_ticks(boat, 1)

    assert kinds(boat) == ["flooding-forward", "bow-servo-stuck", "oil-leak-bow", "log-stuck"]
    arm_casualty(boat, condition, boat.casualties["grounding-aft"])
    with pytest.raises(ConfigError, match="more than 8 triggers"):
        arm_casualty(boat, condition, boat.casualties["grounding-aft"])


def test_a_recording_of_before_knows_single_casualties_alone() -> None:
    standard = shipped_path("casualties", "standard")
    with reading_recorded({key_of(standard): standard.read_text("utf-8")}):
        assert sorted(load_casualties()) == sorted(KINDS)
    assert {*load_casualties()} - {*KINDS} == {
        *("grounding-forward", "grounding-aft", "collision-amidships"),
    }


def test_a_run_with_several_of_one_cause_replays_to_the_bit(tmp_path: Path) -> None:
    record, orders = tmp_path / "r.trainer", tmp_path / "o.txt"
    orders.write_text("5 casualty grounding-forward\n20 clear grounding-forward\n")
    words = ["run", "--vessel", "bb2", "--orders", orders, "--record", record, "--duration", 40]
    type_command(cli, *words, "--headless", "--speed", "max")

    assert "the same to the last bit" in type_command(cli, "replay", record).output
    with contextlib.closing(Recording.reopen(record)) as recording:
        texts = [each.text for each in recording.orders(1)]
    assert texts == ["casualty grounding-forward", "clear grounding-forward"]


@pytest.mark.parametrize(
    ("parts", "told"),
    [
        ('[{ kind = "log-stuck" }]', "must be 2 to 8 tables"),
        ('[{ kind = "log-stuck" }, { kind = "log-stuck" }]', "is a part above too"),
        ('[{ kind = "log-stuck" }, { kind = "log-stock" }]', "nearest is log-stuck"),
        ('[{ kind = "log-stuck", severity = 2 }, { kind = "gyro-stuck" }]', "its severity is 1"),
        ('[{ kind = "log-stuck", hole_m2 = 2 }, { kind = "gyro-stuck" }]', "hole_m2 means nothing"),
        ('[{ kind = "log-stuck" }, { parts = [{}, {}] }]', "has parts of its own; name a kind"),
        ('[{ kind = "log-stuck" }, { kind = "gyro-stuck" }]\nramp_s = 5', "ramp_s"),
    ],
)
def test_wrong_parts_are_refused_with_their_place(parts: str, told: str) -> None:
    text = f'[casualty.own]\ndescription = "x"\nparts = {parts}\n'
    with pytest.raises(ConfigError, match=told) as refused:
        parse_casualties(text, Path("own.toml"), load_casualties())
    assert "own.toml: [casualty.own" in str(refused.value)


@pytest.mark.laws
@pytest.mark.core
def test_severity_ramps_on_whole_ticks_and_arrives_exactly(boat: Boat) -> None:
    begun(boat, "flooding-aft", 2.0, 2.0)
    holes = []
    for _ in range(6):
        boat.tick()
        holes.append(float(boat.state.breach_aft))

    assert holes == pytest.approx([0.0025, 0.005, 0.0075, 0.01, 0.01, 0.01], rel=1e-12)
    assert holes[3] == holes[5] == 0.01


@pytest.mark.core
def test_a_cleared_casualty_ramps_back_and_leaves_its_slot(boat: Boat) -> None:
    begun(boat, "propulsion-lost", 1.0, 0.0)
    boat.tick()
    clear_casualty(boat, "propulsion-lost")  # in 30 s
    left = []
    for _ in range(61):
        boat.tick()
        left.append([each.amount for each in active_casualties(boat)])

    assert left[29] == pytest.approx([0.5])
    assert left[58] == pytest.approx([1 / 60])
    assert left[59] == []
    assert not boat.state.casualty.any()


def test_a_casualty_in_half_its_ramp_is_cleared_from_there(boat: Boat) -> None:
    begun(boat, "flooding-aft", 1.0, 10.0)
    fly(boat, 5.0)
    clear_casualty(boat, "flooding-aft")  # in 30 s
    fly(boat, 15.0)

    assert boat.state.breach_aft == pytest.approx(0.00125)


def test_the_same_casualty_again_gets_a_new_severity(boat: Boat) -> None:
    begun(boat, "flooding-aft", 1.0, 0.0)
    fly(boat, 1.0)
    begun(boat, "flooding-aft", 3.0, 1.0)
    boat.tick()
    half_way = float(boat.state.breach_aft)
    boat.tick()

    assert half_way == pytest.approx(0.01)
    assert boat.state.breach_aft == pytest.approx(0.015)
    assert len(active_casualties(boat)) == 1


def test_a_ninth_casualty_is_refused_and_changes_nothing(boat: Boat) -> None:
    for name in KINDS[:MAX_CASUALTIES]:
        begun(boat, name)
    before = boat.snapshot().tobytes()

    told = reason(insert_casualty(boat, KINDS[MAX_CASUALTIES]))

    assert told.startswith("8 casualties at most: clear one of rudder-slow, ")
    assert boat.snapshot().tobytes() == before
    begun(boat, KINDS[0], 0.5)  # one that is there has its slot


def test_clearing_one_casualty_leaves_the_others_on_their_way(boat: Boat) -> None:
    begun(boat, "flooding-forward", 1.0, 10.0)
    begun(boat, "rudder-stuck")
    begun(boat, "flooding-aft", 1.0, 10.0)
    boat.tick()
    clear_casualty(boat, "rudder-stuck")
    fly(boat, 4.5)

    assert [each.kind for each in active_casualties(boat)] == ["flooding-forward", "flooding-aft"]
    assert boat.state.breach_forward == pytest.approx(0.0025)
    assert boat.state.breach_aft == pytest.approx(0.0025)


def test_all_casualties_are_cleared_by_one_order(boat: Boat) -> None:
    for name in ("rudder-stuck", "flooding-aft", "gyro-stuck"):
        begun(boat, name)
    fly(boat, 1.0)

    assert clear_casualty(boat, "all") == "clearing rudder-stuck, flooding-aft, gyro-stuck"
    fly(boat, 31.0)
    assert active_casualties(boat) == []


def test_a_sound_boat_has_nothing_to_clear(boat: Boat) -> None:
    assert clear_casualty(boat, "all") == "there is nothing to clear"


@pytest.mark.core
@pytest.mark.parametrize("name", KINDS)
def test_a_casualty_goes_on_from_a_snapshot_to_the_bit(name: str) -> None:
    boat = at_sea()
    s = boat.state
    s.ordered_psi, s.ordered_depth, s.blow[:], s.negative_flood = 0.5, 80.0, 1.0, 1.0
    s.bottom[0] = 100.0  # the sounder needs a ground
    begun(boat, name, None, None if boat.casualties[name].measure.sudden else 4.0)
    fly(boat, 2.0)
    snapshot = boat.snapshot()
    fly(boat, 4.0)
    read, end = instrument_readings(boat), boat.snapshot().tobytes()

    if name == KINDS[0]:
        boat = make_boat("bb2")  # nothing hides elsewhere
    boat.restore(snapshot)
    fly(boat, 4.0)

    assert boat.snapshot().tobytes() == end
    assert instrument_readings(boat) == read


# Control surfaces, rudder and planes each ordered to 10 degrees by hand


def steered(boat: Boat, surface: str) -> Callable[[], float]:
    """Order a surface to 10 degrees right or rise; return what tells its angle [deg] that way."""
    letter, sign = FIELD[surface], boat.toward[surface]
    boat.state[f"{surface}_by_hand"] = 1.0
    boat.state[f"ordered_{letter}"] = sign * 10.0 * DEGREE
    return lambda: float(boat.state[f"delta_{letter}"]) * sign / DEGREE


@pytest.mark.parametrize("surface", SURFACES)
def test_a_stuck_surface_stays_until_it_is_cleared(boat: Boat, surface: str) -> None:
    angle = steered(boat, surface)
    stands = angle()
    begun(boat, f"{surface}-stuck")
    fly(boat, 20.0)
    stuck = angle()
    clear_casualty(boat, f"{surface}-stuck")
    fly(boat, 10.0)

    assert stuck == pytest.approx(stands, abs=1e-9)
    assert angle() == pytest.approx(10.0)


@pytest.mark.parametrize("surface", SURFACES)
@pytest.mark.parametrize("severity", [1.0, -0.5, 0.0])
def test_a_surface_hard_over_runs_to_its_angle_at_its_own_rate(
    boat: Boat, surface: str, severity: float
) -> None:
    angle = steered(boat, surface)
    start = angle()
    limit = float(boat.vessel[f"limit_{FIELD[surface]}"]) / DEGREE
    begun(boat, f"{surface}-hard-over", severity)
    boat.tick()
    first = angle() - start
    fly(boat, 20.0)
    jammed = angle()
    clear_casualty(boat, f"{surface}-hard-over")
    fly(boat, 10.0)

    assert abs(first) <= float(boat.vessel.surface_rate) * 0.5 / DEGREE + 1e-9
    assert jammed == pytest.approx(severity * limit)
    assert angle() == pytest.approx(10.0)


@pytest.mark.parametrize("surface", SURFACES)
def test_a_free_surface_trails_to_zero_slowly(boat: Boat, surface: str) -> None:
    angle = steered(boat, surface)
    fly(boat, 10.0)
    begun(boat, f"{surface}-free")
    boat.tick()
    first = angle()
    fly(boat, 30.0)

    rate = float(boat.vessel.surface_rate) / DEGREE
    assert first == pytest.approx(10.0 - 0.1 * rate * 0.5)
    assert angle() == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("surface", SURFACES)
def test_a_slow_surface_moves_at_what_is_left_of_its_rate(boat: Boat, surface: str) -> None:
    angle = steered(boat, surface)
    start = angle()
    begun(boat, f"{surface}-slow", 0.9, 0.0)
    fly(boat, 2.0)

    assert angle() - start == pytest.approx(0.1 * 2.0 * boat.vessel.surface_rate / DEGREE)
    fly(boat, 40.0)
    assert angle() == pytest.approx(10.0)


@pytest.mark.parametrize("surface", SURFACES)
def test_without_follow_up_a_surface_runs_on_until_zero_is_ordered(
    boat: Boat, surface: str
) -> None:
    angle = steered(boat, surface)
    begun(boat, f"{surface}-follow-up-lost")
    fly(boat, 4.0)
    boat.state[f"ordered_{FIELD[surface]}"] = 0.0
    boat.tick()
    left_at = angle()
    fly(boat, 5.0)
    stays = angle()
    boat.state[f"ordered_{FIELD[surface]}"] = -boat.toward[surface] * DEGREE
    fly(boat, 30.0)

    assert left_at > 11.0
    assert stays == pytest.approx(left_at)
    limit = float(boat.vessel[f"limit_{FIELD[surface]}"]) / DEGREE
    assert angle() == pytest.approx(-limit)


def test_on_an_x_tail_the_sound_pair_has_what_the_jammed_one_leaves(boat: Boat) -> None:
    rudder, stern = steered(boat, "rudder"), steered(boat, "stern")
    limit = float(boat.vessel.limit_s) / DEGREE
    begun(boat, "rudder-hard-over", 0.8)
    fly(boat, 20.0)

    assert rudder() == pytest.approx(0.8 * limit)
    assert stern() == pytest.approx(0.2 * limit)


def test_of_two_casualties_on_a_surface_the_jam_counts(boat: Boat) -> None:
    angle = steered(boat, "bow")
    begun(boat, "bow-stuck")
    begun(boat, "bow-hard-over", 1.0)
    stands = angle()
    fly(boat, 10.0)
    assert angle() == pytest.approx(stands)

    clear_casualty(boat, "bow-stuck")
    fly(boat, 10.0)
    assert angle() > 15.0


@pytest.mark.laws
@pytest.mark.core
@pytest.mark.parametrize("fault", ["hard-over", "free", "slow"])
def test_rudder_casualties_to_port_mirror_those_to_starboard(fault: str) -> None:
    ends = []
    for side in (1.0, -1.0):
        boat = make_boat("bb2")
        boat.vessel.K_star = boat.vessel.K_star_eta = 0.0
        boat.start(10.0 * KNOT, 60.0, 0.0)
        boat.state.rudder_by_hand, boat.state.ordered_r = 1.0, side * 0.2
        fly(boat, 5.0)
        begun(boat, f"rudder-{fault}", side if fault == "hard-over" else 0.5, 0.0)
        boat.state.ordered_r = side * -0.2
        fly(boat, 60.0)
        ends.append(boat.snapshot()[0])

    starboard, port = ends
    assert abs(starboard.psi) > 0.1
    for name in ("y", "psi", "v", "r", "phi", "delta_r"):
        assert port[name] == -starboard[name], name
    for name in ("x", "z", "u", "theta", "delta_s"):
        assert port[name] == starboard[name], name


def test_stern_planes_jammed_hard_to_dive_sink_the_boat_unless_it_is_recovered() -> None:
    deepest = []
    for recovered in (False, True):
        boat = at_sea(knots=15.0, depth=100.0)
        begun(boat, "stern-hard-over", -1.0)
        depths = []
        for tick in range(300):
            if recovered and tick == 20:
                s = boat.state
                s.speed_by_hand, s.ordered_u_c = 1.0, boat.vessel.u_c_astern
                s.blow[:3] = 2.0
            if recovered and tick == 80:
                clear_casualty(boat, "all")
            assert boat.tick() == 0
            depths.append(float(boat.state.z))
        deepest.append(max(depths))

    assert deepest[0] > 500.0
    assert deepest[1] < 150.0


# Propulsion and autopilot


def test_lost_propulsion_stops_the_boat_and_clearing_it_brings_the_way_back(boat: Boat) -> None:
    begun(boat, "propulsion-lost")
    fly(boat, 120.0)
    turns, slow = float(boat.state.u_c), float(boat.state.u)
    clear_casualty(boat, "propulsion-lost")
    fly(boat, 300.0)

    assert abs(turns) < 0.05
    assert slow < 7.0 * KNOT
    assert boat.state.u == pytest.approx(10.0 * KNOT, abs=0.3)


def test_stuck_revolutions_do_not_answer_the_telegraph(boat: Boat) -> None:
    before = float(boat.state.u_c)
    boat.state.speed_by_hand = 1.0
    begun(boat, "propulsion-stuck")
    boat.state.ordered_u_c = 0.0
    fly(boat, 60.0)
    stuck = float(boat.state.u_c)
    begun(boat, "propulsion-lost", 0.5, 0.0)
    fly(boat, 120.0)
    halved = float(boat.state.u_c)
    clear_casualty(boat, "all")
    fly(boat, 200.0)

    assert stuck == before
    assert halved == pytest.approx(0.5 * before, rel=1e-3)
    assert boat.state.u_c == pytest.approx(0.0, abs=0.01)


def test_a_failed_autopilot_leaves_its_commands_and_hands_still_steer(boat: Boat) -> None:
    s = boat.state
    s.ordered_psi, s.ordered_depth = math.radians(30.0), 70.0
    fly(boat, 10.0)
    begun(boat, "autopilot-failed")
    held = s.command.tolist()
    fly(boat, 20.0)
    assert s.command.tolist() == held

    s.rudder_by_hand, s.ordered_r = 1.0, 0.1
    fly(boat, 5.0)
    assert s.delta_r == pytest.approx(0.1)
    assert s.command[1:].tolist() == held[1:]


def test_a_repaired_autopilot_takes_over_without_a_bump_and_holds_its_orders(boat: Boat) -> None:
    s = boat.state
    s.ordered_depth = 70.0
    fly(boat, 10.0)
    begun(boat, "autopilot-failed")
    fly(boat, 15.0)
    clear_casualty(boat, "autopilot-failed")
    held = s.command.copy()
    boat.tick()
    assert np.all(abs(s.command - held) < 0.5 * DEGREE)

    fly(boat, 400.0)
    assert s.z == pytest.approx(70.0, abs=0.5)
    assert s.psi == pytest.approx(0.0, abs=0.5 * DEGREE)


def test_a_failed_autopilot_asks_nothing_of_the_trim_pumps(boat: Boat) -> None:
    boat.state.trim_flood = boat.state.trim_forward = 3.0  # as they were asked in the last tick
    begun(boat, "autopilot-failed")
    aboard = boat.state.water.copy()

    fly(boat, 30.0)

    assert (boat.state.water == aboard).all()


# Tanks and air: each against a sound boat under the same orders, and after clearing


@pytest.mark.parametrize(("hole", "end"), [(2.0, "up"), (4.0, "lost"), (10.0, "lost")])
def test_an_emergency_blow_with_the_stern_flooding_surfaces_the_boat_or_does_not(
    hole: float, end: str
) -> None:
    boat = at_sea(knots=5.0, depth=200.0)
    begun(boat, "flooding-aft", hole, 0.0)
    fly(boat, 60.0)
    boat.state.blow[:3] = 2.0
    depths = []
    for _ in range(900):
        assert boat.tick() == 0
        assert np.all(np.isfinite(boat.state.whole))
        depths.append(float(boat.state.z))
        if depths[-1] > 600.0:
            break

    assert (min(depths) < 8.0) == (end == "up")
    assert (max(depths) > 600.0) == (end == "lost")


# Instruments


@pytest.mark.parametrize(("gauge", "place"), [("depth-gauge", 0), ("gyro", 1), ("log", 2)])
def test_a_stuck_gauge_stays_at_its_reading_while_the_boat_moves_on(
    boat: Boat, gauge: str, place: int
) -> None:
    s = boat.state
    s.ordered_depth, s.ordered_psi, s.ordered_speed = 90.0, 0.6, 4.0
    begun(boat, f"{gauge}-biased", 1.0, 0.0)
    at_onset = instrument_readings(boat)
    begun(boat, f"{gauge}-stuck")
    fly(boat, 60.0)
    truth = (float(s.z), float(s.psi), float(s.u))

    assert instrument_readings(boat)[place] == at_onset[place]
    assert abs(truth[place] - at_onset[place]) > 0.2
    clear_casualty(boat, f"{gauge}-stuck")
    clear_casualty(boat, f"{gauge}-biased")
    fly(boat, 1.0)
    assert instrument_readings(boat) == InstrumentReadings(s.z, s.psi, s.u, 0.0)


def test_a_biased_gauge_reads_too_much_by_severity_times_its_table(boat: Boat) -> None:
    begun(boat, "depth-gauge-biased", -0.5, 0.0)
    begun(boat, "gyro-biased", 1.0, 0.0)
    begun(boat, "log-biased", 2.0, 0.0)
    s = boat.state

    read = (s.z - 5.0, s.psi + 10.0 * DEGREE, s.u + 4.0 * KNOT, 0.0)
    assert instrument_readings(boat) == pytest.approx(read)


def test_a_noisy_gauge_scatters_as_told_and_the_same_each_time() -> None:
    def errors() -> list[float]:
        boat = at_sea()
        begun(boat, "depth-gauge-noisy", 1.5)
        found = []
        for _ in range(2000):
            boat.state.tick += 1.0
            found.append(instrument_readings(boat).depth - float(boat.state.z))
        return found

    once = errors()

    assert once == errors()
    assert np.std(once) == pytest.approx(3.0, rel=0.1)
    assert abs(np.mean(once)) < 0.3


def test_a_failed_sensor_changes_nothing_but_what_stations_read() -> None:
    ends = []
    for broken in (False, True):
        boat = at_sea()
        boat.state.ordered_depth = 80.0
        if broken:
            for gauge in ("depth-gauge", "gyro", "log"):
                begun(boat, f"{gauge}-biased")
                begun(boat, f"{gauge}-noisy")
        fly(boat, 30.0)
        ends.append(boat.state.motion.tolist())

    assert ends[0] == ends[1]


# Triggers


def armed(boat: Boat, text: str, name: str = "rudder-stuck", rule: str = "once") -> None:
    """Arm a trigger of the boat."""
    arm_casualty(boat, compile_condition(text, HERE), boat.casualties[name], rule)


@pytest.mark.core
@pytest.mark.parametrize(("text", "tick"), [("time >= 5", 11), ("time_s > 5", 12)])
def test_a_trigger_fires_on_the_first_tick_whose_last_state_meets_it(
    boat: Boat, text: str, tick: int
) -> None:
    armed(boat, text)
    take_ticks(boat, tick - 1)
    assert active_casualties(boat) == []
    boat.tick()
    assert [each.kind for each in active_casualties(boat)] == ["rudder-stuck"]


@pytest.mark.parametrize(("rule", "times"), [("once", 1), ("again", 2)])
def test_a_trigger_fires_once_or_each_time_its_condition_comes_true(
    boat: Boat, rule: str, times: int
) -> None:
    armed(boat, "depth > 100", "gyro-stuck", rule)
    fired = 0
    for depth in (90.0, 110.0, 120.0, 90.0, 110.0, 110.0):
        boat.state.z = depth
        boat.tick()
        fired += len(active_casualties(boat))
        clear_casualty(boat, "all")
        boat.state.z = depth
        boat.tick()
        assert active_casualties(boat) == []

    assert fired == times


def test_a_trigger_waits_for_a_free_slot(boat: Boat) -> None:
    for name in KINDS[5 : 5 + MAX_CASUALTIES]:
        begun(boat, name)
    armed(boat, "depth > 10")
    boat.tick()
    assert len(active_casualties(boat)) == MAX_CASUALTIES
    clear_casualty(boat, "stern-stuck")
    fly(boat, 1.0)
    assert "rudder-stuck" in [each.kind for each in active_casualties(boat)]


@pytest.mark.core
def test_what_triggers_remember_is_part_of_a_snapshot(boat: Boat) -> None:
    armed(boat, "time >= 3", "flooding-aft")
    fly(boat, 1.0)
    before = boat.snapshot()
    fly(boat, 5.0)
    fired, end = boat.snapshot(), boat.snapshot().tobytes()
    assert boat.state.breach_aft > 0.0

    boat.restore(before)
    assert active_casualties(boat) == []
    fly(boat, 5.0)
    assert boat.snapshot().tobytes() == end

    boat.restore(fired)
    clear_casualty(boat, "all")
    fly(boat, 40.0)
    assert active_casualties(boat) == []  # spent


@pytest.mark.parametrize(
    ("text", "field", "value"),
    [
        ("depth > 100", "z", 100.0),
        ("depth_ft > 328.084", "z", 100.0),
        ("depth > 328.084 ft", "z", 100.0),
        ("depth_rate < -0.5", "zdot", -0.5),
        ("speed_kn < 4", "u", 4 * KNOT),
        ("speed <= 4 m/s", "u", 4.0),
        ("pitch_deg > 10", "theta", 10 * DEGREE),
        ("heel > -3 deg", "phi", -3 * DEGREE),
        ("turn_rate > 1", "r", DEGREE),
        ("rudder > 15", "delta_r", 15 * DEGREE),
        ("stern < -15", "delta_s", 15 * DEGREE),
        ("bow_deg >= 5", "delta_b", 5 * DEGREE),
        ("turns < 20", "u_c", 0.0),
        ("water_aft_t < 50", "water_aft", 50e3),
        ("flood_aft > 5", "flood_aft", 5e3),
        ("bank_main_mpa < 10", "bank_main", 0.0),
        ("bank_main < 100 bar", "bank_main", 0.0),
        ("wave > 2", "eta_wave", 2.0),
        ("time > 2 min", "tick", 240.0),
    ],
)
def test_a_condition_holds_beyond_its_threshold_only(
    boat: Boat, text: str, field: str, value: float
) -> None:
    if field == "u_c":
        value = 20.0 / 60.0 / boat.file.propulsion.rps_per_mps
    if field == "bank_main":
        value = 10e6 * float(boat.vessel.bank_volume[0] / boat.vessel.gas)
    if field in ("delta_r", "delta_s", "delta_b"):
        surface = {"r": "rudder", "s": "stern", "b": "bow"}[field[-1]]
        value = abs(value) * boat.toward[surface] * (-1.0 if "-" in text else 1.0)
    armed(boat, text)
    place = boat.state.dtype.fields[field][1] // 8
    m = boat.records.scheme[0]

    assert m.trigger_place[0] == place
    assert m.trigger_threshold[0] == pytest.approx(value, rel=1e-6)
    assert m.trigger_strict[0] == ("=" not in text)
    mirrored = field.startswith("delta") and boat.toward[surface] < 0.0
    assert m.trigger_sense[0] == (1.0 if (">" in text) is not mirrored else -1.0)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("dept > 100", "no quantity 'dept'; nearest is depth"),
        ("speed_kt < 4", 'speed is in kn or m_s, not "kt"'),
        ("depth > 100 fathoms", 'depth is in m or ft, not "fathoms"'),
        ("depth_m > 100 ft", "has two units"),
        ("depth = 100", "write it as depth > 100"),
        ("depth > deep", "write it as depth > 100"),
        ("depth > 1.2.3", '"1.2.3" is no number'),
        ("", "write it as depth > 100"),
        ("depth > 1 and speed < 2", 'speed_kn <= 4.5, one alone, without "and"'),
        ("water_ftorward > 1", "nearest is water_forward"),
    ],
)
def test_a_wrong_condition_is_refused_at_load_with_its_place(text: str, told: str) -> None:
    with pytest.raises(ConfigError) as caught:
        compile_condition(text, HERE)

    assert str(caught.value).startswith("my.toml: [casualties[0]] condition ")
    assert told in str(caught.value)


def test_a_trigger_about_what_the_boat_lacks_is_refused() -> None:
    remus = start_boat(1.5, 10.0, vessel="remus100")

    with pytest.raises(ConfigError, match=r"remus100.toml has no water_aft"):
        armed(remus, "water_aft > 1")
    with pytest.raises(ConfigError, match="nothing for flooding-aft to act on"):
        armed(remus, "depth > 10", "flooding-aft")
    assert "nothing for leak-trim-aft" in reason(insert_casualty(remus, "leak-trim-aft"))


def test_triggers_have_a_rule_and_are_eight_at_most(boat: Boat) -> None:
    with pytest.raises(ConfigError, match='rule = "twice": must be once or again'):
        armed(boat, "depth > 1", rule="twice")
    for _ in range(8):
        armed(boat, "depth > 500")
    with pytest.raises(ConfigError, match="more than 8 triggers"):
        armed(boat, "depth > 500")
    boat.start(10.0 * KNOT, 60.0, 0.0)
    armed(boat, "depth > 500")  # a new start has none


# Tables


def test_a_table_of_ones_own_adds_names_and_inherits_the_rest(tmp_path: Path, boat: Boat) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(
        '[casualty.torpedo-room]\nkind = "flooding-forward"\nhole_m2 = 0.02\nramp_s = 0\n'
        '[casualty.steering-jam-left]\nkind = "rudder-hard-over"\nseverity = -0.5\n'
    )
    boat.casualties = load_casualties(str(path))
    begun(boat, "Torpedo Room")
    begun(boat, "steering_jam_left")
    fly(boat, 20.0)

    assert boat.state.breach_forward == 0.02
    assert boat.state.delta_r == pytest.approx(
        -0.5 * boat.toward["rudder"] * float(boat.vessel.limit_r)
    )
    assert boat.casualties["torpedo-room"].clear_ramp_s == 30.0
    assert clear_casualty(boat, "torpedo-room") == "clearing torpedo-room within 30 s"
    boat.casualties = load_casualties()


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ('[casualty.x]\nkind = "rudder-stuk"', "no such kind of casualty; nearest is rudder-stuck"),
        ("[casualty.x]\nseverity = 1", "mine.toml: [casualty.x] lacks kind"),
        ('[casualty.x]\nkind = "flooding-aft"\nhole = 1', "no such key; nearest is hole_m2"),
        ('[casualty.x]\nkind = "rudder-slow"\nhole_m2 = 1', "hole_m2 means nothing to rudder-slow"),
        (
            '[casualty.x]\nkind = "rudder-slow"\nseverity = 2',
            "severity = 2.0: must be above 0",
        ),
        (
            '[casualty.x]\nkind = "gyro-stuck"\nramp_s = 5',
            "comes and goes at once",
        ),
        ('[casualty.x]\nkind = "gyro-stuck"\nseverity = 0.5', "has no degrees: its severity is 1"),
        ('[casualty.X_1]\nkind = "rudder-slow"', "a name is 1 to 40 of a to z"),
        ('[casualty.all]\nkind = "rudder-slow"', "and not all"),
        ('[casualty.rudder-slow]\nkind = "rudder-slow"', "is already in another table"),
        ('[casualty.x]\nkind = "flooding-aft"\nramp_s = nan', "ramp_s = nan: must be finite"),
        ("[casualty]\nx = 3", "[casualty.x] must be a table, not 3"),
        ("[casulty.x]", "no such key; nearest is casualty"),
        ("name = 'x'", "has no table [casualty.NAME]"),
    ],
)
def test_a_wrong_table_is_refused_with_the_reason(tmp_path: Path, text: str, told: str) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(text)
    with pytest.raises(ConfigError) as caught:
        load_casualties(str(path))

    assert str(caught.value).startswith("mine.toml: ")
    assert told in str(caught.value)


@pytest.mark.parametrize(
    ("order", "told"),
    [
        (("ruder-stuck",), "no casualty 'ruder-stuck'; nearest is rudder-stuck"),
        (("rudder-slow", 2.0), "severity 2: must be above 0 to 1 for rudder-slow"),
        (("rudder-slow", math.nan), "severity nan: must be"),
        (("rudder-slow", 0.5, -1.0), "ramp -1 s: must be 0 to 3600 s"),
        (("rudder-stuck", None, 5.0), "rudder-stuck comes at once: it has no ramp"),
        (("rudder-stuck", 0.5), "rudder-stuck has no degrees: its severity is 1"),
    ],
)
def test_a_wrong_order_is_refused_and_changes_nothing(
    boat: Boat, order: tuple[str, *tuple[float, ...]], told: str
) -> None:
    before = boat.snapshot().tobytes()

    assert told in reason(insert_casualty(boat, *order))
    assert reason(clear_casualty(boat, "gyro-stuck")) == "there is no gyro-stuck; active: none"
    assert boat.snapshot().tobytes() == before


def test_the_list_is_narrow_and_complete() -> None:
    casualties = load_casualties()
    text = listing(casualties)

    assert max(map(len, text.splitlines())) <= 79
    assert all(name in text for name in KINDS)
    alone = [each for each in json.loads(json.dumps(as_json(casualties))) if not each["parts"]]
    assert sorted(each["name"] for each in alone) == sorted(KINDS)


def test_the_examples_of_the_manual_load() -> None:
    manual = (ROOT / "docs" / "casualties.md").read_text(encoding="utf-8")
    examples = re.findall(r"```toml\n(\[casualty.*?)```", manual, re.DOTALL)
    conditions = re.findall(r"`([a-z_]+ [<>]=? [^`]+)`", manual)

    assert len(examples) >= 1
    for example in examples:
        parse_casualties(example, Path("example.toml"), load_casualties())
    assert len(conditions) >= 3
    for condition in conditions:
        assert compile_condition(condition, HERE).quantity in STATE_QUANTITIES


def test_status_tells_a_failed_instrument_s_reading_beside_the_truth_and_names_the_casualty() -> (
    None
):
    boat = start_bb2()
    insert_casualty(boat, "depth-gauge-biased", 0.7, 0.0)
    boat.tick()
    boat.tick()
    lines = status_lines(boat, Ledger(0.5).summary())

    assert any(line.startswith("depth      60.00 m") for line in lines)
    assert any(line.startswith("instruments: depth 67.0 m, heading 000.0") for line in lines)
    assert "casualties: depth-gauge-biased reads 7 m too much" in lines
    assert max(map(len, lines)) <= 79
