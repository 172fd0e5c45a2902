"""Manoeuvres: schedules and measures, flown by the boats and by a reference boat."""

import ast
import json
import math
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from helpers.places import DATA

from trainer.analysis import manoeuvres
from trainer.analysis.manoeuvres.catalogue import MANOEUVRES, adjust_manoeuvre, find_manoeuvre
from trainer.analysis.manoeuvres.flight import Flight, Manoeuvre, fly_manoeuvre
from trainer.analysis.manoeuvres.page import ManoeuvreOptions, fly_boat
from trainer.analysis.manoeuvres.speeds import UtmostAcceleration
from trainer.analysis.manoeuvres.submarine import Rig, Submarine
from trainer.analysis.manoeuvres.turns import PullOut, Turn
from trainer.analysis.manoeuvres.vehicle import (
    DIVE,
    first_time,
    peaks_of,
    swing_measures,
    zero_crossings,
)
from trainer.analysis.manoeuvres.vertical import Meander, Overshoot
from trainer.analysis.programs.compare import compare_runs
from trainer.analysis.programs.neutral import trim_at
from trainer.boat.assemble import Method
from trainer.boat.boat import Boat
from trainer.cli.main import main
from trainer.cli.workshop.guide import manoeuvre as command
from trainer.config.boat.vessel import VesselFile, load_vessel
from trainer.config.files import ConfigError
from trainer.config.ship.series import Series
from trainer.debrief.passage.recording_export import panel_of
from trainer.report import plots
from trainer.units import KNOT

FOOT = 0.3048
REFERENCE_KNOT = 1.68780986 * FOOT
AS_IN_1969 = Rig(controls="once", trim="full", law="literal")
# The compensation that the reference used for its basic set, [ASSES] V.
COMPENSATION = {"Z_w": 1.75, "M_w": 0.89, "N_dr": 0.8, "K_vav": 0.5}


# --- an independent implementation's measures: vectors/measures.json, in feet


def reference_boat(model: str) -> Submarine:
    """Return the reference boat by the words of the vectors, such as "basic lagged AB2 h=1"."""
    equations, *words, step = model.split()
    file = load_vessel(str(DATA / "vectors" / "full-refsub.vessel.toml"))
    file = replace(file, compensation={"modified": {}, "basic": COMPENSATION})
    method = Method(
        equations,
        "lagged" if "lagged" in words else "exact",
        "report" if equations == "basic" else "exact",
        "rk4" if "RK4" in words else "adams2",
        float(step.removeprefix("h=")),
    )
    return Submarine(file, method, AS_IN_1969)


def schedule_of(run: dict[str, Any]) -> Manoeuvre:
    """Return the manoeuvre of a reference run."""
    if run["manoeuvre"] == "turn":
        return Turn(-run["rudder_deg"], run["T"])
    if run["manoeuvre"] == "max accel/decel":
        return UtmostAcceleration(run["T"], ahead_kn=25.0 * REFERENCE_KNOT / KNOT)
    kind = {"meander": Meander, "overshoot": Overshoot}[run["manoeuvre"]]
    return kind(-run["plane_deg"], run["execute_deg"], run["T"])


def expected(run: dict[str, Any]) -> dict[str, float | None]:
    """Return the reference's numbers by the names of our measures, in feet and its times."""
    names = {
        "t90": "time to 90 degrees",
        "t180": "time to 180 degrees",
        "tactical_diameter": "tactical diameter",
        "steady_diameter": "steady diameter",
        "phi_end": "steady roll",
        "phi_max": "largest roll",
        "z_max": "largest depth change",
        "z_end": "last depth change",
        "t_exec": "time of execute",
        "t_rev": "time of reversal",
        "theta_max": "largest pitch",
        "t_theta_max": "time of largest pitch",
        "theta_overshoot": "overshoot angle",
        "dz_max": "depth change" if run["manoeuvre"] == "overshoot" else "largest depth change",
        "t_dz_max": "time of depth change",
        "zeta_half_cycle": "damping ratio",
        **{f"u_{t}": f"speed after {t} s" for t in (100, 250, 500, 600, 1000)},
    }
    found = {names[key]: value for key, value in run.items() if key in names}
    for i, (when, value) in enumerate(run.get("peaks", []), start=1):
        found |= {f"time of pitch peak {i}": when, f"pitch peak {i}": value}
    found |= {f"pitch zero {i}": at for i, at in enumerate(run.get("zero_crossings", []), start=1)}
    if "basic" in run["model"]:  # there the reference does not tell the times
        found = {name: value for name, value in found.items() if "time" not in name}
    return found


RUNS = json.loads((DATA / "vectors" / "measures.json").read_text())["runs"]


@pytest.mark.parametrize(
    "run", RUNS, ids=lambda run: f"{run['model']}, {run['manoeuvre']} {run.get('knots', '')}"
)
def test_measures_are_those_of_an_independent_implementation(run: dict[str, Any]) -> None:
    boat, manoeuvre = reference_boat(run["model"]), schedule_of(run)

    flight = fly_manoeuvre(boat, manoeuvre, run.get("knots", 0.0) * REFERENCE_KNOT)

    ours = {one.name: one for one in manoeuvre.measures(flight)}
    assert not flight.lost
    if "u_end" in run:
        assert flight.column("u")[-1] / FOOT == pytest.approx(run["u_end"], rel=2e-4)
    for name, value in expected(run).items():
        if value is None:
            assert ours[name].value is None, name
            continue
        found = ours[name].value
        assert found is not None, name
        if ours[name].unit in ("m", "m/s"):
            found /= FOOT
        if name.startswith("time to"):  # ours count from the rudder, theirs from the start
            found += run["t0"]
        if name == "largest depth change" and run["manoeuvre"] == "max accel/decel":
            found = abs(found)
        assert found == pytest.approx(value, rel=2e-4, abs=1e-6), name


# --- the library


def test_the_library_of_manoeuvres_does_not_know_submarines() -> None:
    folder = Path(manoeuvres.__file__).parent
    for path in folder.glob("*.py"):
        if path.name in {"submarine.py", "page.py"}:  # the page flies the boats
            continue
        imported = {
            node.module or ""
            for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
            if isinstance(node, ast.ImportFrom)
        }
        allowed = (
            "trainer.config.files",
            "trainer.config.ship.nomoto",
            "trainer.boat.world.nomoto",
            "trainer.config.ship.series",
            "trainer.analysis.manoeuvres.",
            "trainer.core.kernel",
            "trainer.units",
        )
        ours = [name for name in imported if name.startswith("trainer")]
        assert all(name.startswith(allowed) for name in ours), path.name
        assert "trainer.analysis.manoeuvres.submarine" not in imported, path.name


# --- the boats


def boat_of(vessel: str, rig: Rig = Rig(), step: float | None = None) -> Submarine:  # noqa: B008
    file = load_vessel(vessel)
    return Submarine(file, Method("full", "exact", "exact", "rk4", step or file.run.step_s), rig)


@pytest.fixture(scope="module")
def bb2() -> VesselFile:
    return load_vessel("bb2")


@pytest.mark.parametrize("name", MANOEUVRES)
def test_every_manoeuvre_is_flown_and_measured(name: str) -> None:
    sea = find_manoeuvre(name).in_waves
    boat = boat_of("bb2", Rig(depth=20.0 if sea else None))
    manoeuvre = adjust_manoeuvre(name, boat, {})

    flight = fly_manoeuvre(boat, manoeuvre, 0.0 if manoeuvre.from_rest else 10.0 * KNOT)
    found = manoeuvre.measures(flight)

    assert not flight.lost
    assert len(found) > 2
    assert len({one.name for one in found}) == len(found)
    numbers = [one.value for one in found if one.value is not None]
    assert np.isfinite(numbers).all()
    assert all(
        flight.has(column)
        for column in (*manoeuvre.compared, *manoeuvre.shows)
        if column not in ("track", "turns")
    )


def test_a_boat_stable_on_course_keeps_no_turn_after_the_rudder_is_amidships() -> None:
    flight = fly_manoeuvre(boat_of("bb2"), PullOut(), 10.0 * KNOT)

    found = {one.name: one.value for one in PullOut().measures(flight)}

    assert abs(found["yaw rate left after port"] or 1.0) < 0.01 * abs(
        found["yaw rate, rudder to port"] or 0.0
    )


def test_a_speed_that_is_kept_is_kept_in_a_turn() -> None:
    kept = Turn(20.0, 300.0, keep=("depth", "speed"))

    flight = fly_manoeuvre(boat_of("bb2"), kept, 10.0 * KNOT)

    assert flight.column("u")[-1] == pytest.approx(10.0 * KNOT, rel=0.01)


def test_planes_are_clipped_to_what_the_boat_has_unless_asked_for_more(bb2: VesselFile) -> None:
    boat = Submarine(bb2, Method("full", "exact", "exact", "rk4", 0.5))

    assert adjust_manoeuvre("turning-circle", boat, {}).angle_deg == 30.0  # type: ignore[attr-defined]
    with pytest.raises(ConfigError, match=r"--angle 35: the rudder of .* goes to 30 degrees"):
        adjust_manoeuvre("turning-circle", boat, {"angle": 35.0})
    with pytest.raises(ConfigError, match="--execute: turn has no such parameter; it has angle"):
        adjust_manoeuvre("turn", boat, {"execute": 5.0})
    with pytest.raises(ConfigError, match="nearest is meander"):
        find_manoeuvre("meandr")


# --- sides, rise and dive


SIDED = [name for name, one in MANOEUVRES.items() if hasattr(one, "side")]
DIRECTED = [name for name, one in MANOEUVRES.items() if hasattr(one, "direction")]
# what makes the sides differ, besides y of centres of weight and buoyancy: the propeller's torque
LEFT_RIGHT = ("Y_star", "K_star", "N_star", "K_star_eta")


def figures(
    boat: Submarine, name: str, given: dict[str, float | str], knots: float = 10.0
) -> dict[str, float | None]:
    """Return the measures by name."""
    manoeuvre = adjust_manoeuvre(name, boat, given)
    flight = fly_manoeuvre(boat, manoeuvre, 0.0 if manoeuvre.from_rest else knots * KNOT)
    assert not flight.lost
    return {one.name: one.value for one in manoeuvre.measures(flight)}


@pytest.fixture(scope="module")
def symmetric(bb2: VesselFile) -> Submarine:
    """Return a boat that is alike on both sides."""
    coefficients = {**bb2.coefficients, **dict.fromkeys(LEFT_RIGHT, 0.0)}
    file = replace(bb2, coefficients=coefficients)
    return Submarine(file, Method("full", "exact", "exact", "rk4", file.run.step_s))


@pytest.mark.parametrize("name", SIDED)
def test_a_symmetric_boat_has_the_same_figures_on_both_sides(
    name: str, symmetric: Submarine
) -> None:
    starboard, port = (figures(symmetric, name, {"side": side}) for side in ("starboard", "port"))

    if name == "pull-out":  # it names the sides, in the order they are turned to
        swap = {"starboard": "port", "port": "starboard"}
        port = {
            " ".join(swap.get(word, word) for word in told.split()): value
            for told, value in port.items()
        }
    assert list(port) == list(starboard)
    for told, value in starboard.items():
        assert port[told] == pytest.approx(value, rel=1e-7, abs=1e-10), told


def test_a_boat_whose_sides_differ_has_other_figures_to_port(bb2: VesselFile) -> None:
    file = replace(bb2, coefficients={**bb2.coefficients, "N_star": 1e-4})
    boat = Submarine(file, Method("full", "exact", "exact", "rk4", file.run.step_s))

    starboard, port = (figures(boat, "turn", {"side": side}) for side in ("starboard", "port"))

    assert port["steady diameter"] != pytest.approx(starboard["steady diameter"], rel=1e-3)
    assert (port["steady yaw rate"] or 0.0) > 0.0


@pytest.mark.parametrize("name", DIRECTED)
def test_planes_to_dive_take_the_boat_down_first(name: str) -> None:
    boat = boat_of("bb2")
    depths = {}
    for direction in ("rise", "dive"):
        flight = fly_manoeuvre(
            boat, adjust_manoeuvre(name, boat, {"direction": direction}), 10.0 * KNOT
        )
        after = flight.change("theta")[flight.t < flight.marks[0].t + 8.0]
        depths[direction] = float(after[-1])

    assert depths["rise"] > math.radians(0.1)
    assert depths["dive"] < -math.radians(0.1)


def test_a_side_that_is_none_is_refused() -> None:
    with pytest.raises(ConfigError, match="side = 'left': must be starboard or port"):
        Turn(side="left")  # type: ignore[arg-type]
    with pytest.raises(ConfigError, match="direction = 'up': must be rise or dive"):
        Overshoot(direction="up")  # type: ignore[arg-type]


def test_what_a_manoeuvre_has_not_is_refused_with_what_it_has() -> None:
    boat = boat_of("bb2")

    with pytest.raises(ConfigError, match=r"--dive: turn has no .* angle, duration, side\. --dive"):
        adjust_manoeuvre("turn", boat, {"direction": "dive"})
    with pytest.raises(ConfigError, match=r"--side: meander has .* rise or dive\. --side is for"):
        adjust_manoeuvre("meander", boat, {"side": "port"})
    with pytest.raises(ConfigError, match=r"--planes 60: the planes of .* goes to 30 degrees"):
        adjust_manoeuvre("climbing-turn", boat, {"planes": 60.0})
    with pytest.raises(ConfigError, match=r"--ahead-speed 50: the engine of .* up to 2"):
        adjust_manoeuvre("acceleration", boat, {"ahead_speed": 50.0})
    with pytest.raises(ConfigError, match=r"--ahead-time 90: must be less than .* 60 s"):
        adjust_manoeuvre("utmost-acceleration", boat, {"ahead_time": 90.0, "duration": 60.0})


# --- accelerations


def test_an_acceleration_goes_up_and_down_in_the_steps_asked_for() -> None:
    boat = boat_of("bb2")
    given: dict[str, float | str] = {"step_speed": 3.5, "step_time": 20.0, "ahead_speed": 12.0}

    flight = fly_manoeuvre(boat, adjust_manoeuvre("acceleration", boat, given), 0.0)

    assert [mark.t for mark in flight.marks] == [20.0 * i for i in range(8)]
    ends = [flight.at(mark.t + 19.5, "u_c") or 0.0 for mark in flight.marks]
    assert np.array(ends) / KNOT == pytest.approx(
        [3.0, 6.0, 9.0, 12.0, 9.0, 6.0, 3.0, 0.0], abs=0.3
    )


def test_an_utmost_acceleration_stops_when_it_is_told_to() -> None:
    boat = boat_of("bb2")
    given: dict[str, float | str] = {"ahead_speed": 8.0, "ahead_time": 30.0, "duration": 200.0}

    flight = fly_manoeuvre(boat, adjust_manoeuvre("utmost-acceleration", boat, given), 0.0)

    assert [tuple(mark) for mark in flight.marks] == [("ahead", 0.0), ("stop", 30.0)]
    assert flight.column("u_c").max() / KNOT == pytest.approx(8.0, rel=0.01)


# --- at a depth, in a sea


@pytest.mark.parametrize(
    ("equations", "trim"),
    [
        ("full", "own"),
        ("modified", "own"),
        ("basic", "own"),
        ("longitudinal", "own"),
        ("full", "full"),
    ],
)
def test_a_boat_near_the_surface_begins_in_the_neutral_flight_of_that_depth(
    equations: str, trim: str
) -> None:
    file = load_vessel("bb2")
    method = Method(equations, "exact", "exact", "rk4", 0.5)
    still = Meander(angle_deg=0.0, duration_s=120.0)
    boat = Submarine(file, method, Rig(depth=18.4, trim=trim))
    deep = float(boat.boat.vessel.Z_star), float(boat.boat.vessel.M_star)
    flight = fly_manoeuvre(boat, still, 6.0 * KNOT)
    under = trim_at(Boat(file, method), 6.0 * KNOT, 18.4)

    assert abs(flight.change("z")).max() < 1e-6
    assert under is not None
    assert flight.column("delta_s")[0] == pytest.approx(math.radians(under.stern_planes_deg))
    # suction is felt once, as a force and not as a coefficient besides
    assert (boat.boat.vessel.Z_star, boat.boat.vessel.M_star) == deep


def test_below_the_tables_of_the_surface_a_depth_changes_no_bit_of_the_start() -> None:
    starts = []
    for depth in (60.0, None):
        boat = boat_of("bb2", Rig(depth=depth))
        boat.start(6.0 * KNOT)
        starts.append([*boat.observe()[:9], *boat.observe()[10:]])

    assert starts[0] == starts[1]


TABLE_12 = {6.0: (-26.5, -2.6, -34.4), 12.0: (3.2, 25.5, 36.2)}  # [%] of u, theta, z at 25 m
TABLE_13 = (2.2, 4.3, 5.4)  # [%] at 12 kn


def compare_with_deep(near: VesselFile, speed: float, figures: tuple[float, ...], row: str) -> None:
    """Check an overshoot at 25 m against a deep one, and its row of the page."""
    names = ("u", "theta", "z")
    flown = [
        fly_boat(near, "overshoot", ManoeuvreOptions(speed=speed, rig=Rig(depth=depth)))
        for depth in (None, 25.0)
    ]
    points = compare_runs(flown[0][1].series, flown[1][1].series, names).points
    found = {point.variable: point.percent for point in reversed(points)}
    cells = " | ".join(f"{figure:.1f}" for figure in figures)

    assert flown[1][0].notices == ()
    assert [found[name] for name in names] == pytest.approx(figures, abs=0.06)
    text = (DATA.parents[1] / "docs" / "engineer.md").read_text(encoding="utf-8")
    assert f"| {row}, BB2, 25 m | {speed:g} | {cells} |" in text


@pytest.mark.parametrize("speed", TABLE_12)
def test_an_overshoot_near_the_surface_differs_from_a_deep_one_by_the_figures_of_the_page(
    speed: float,
) -> None:
    compare_with_deep(load_vessel("bb2"), speed, TABLE_12[speed], "Table 12")


def test_an_overshoot_with_z_star_and_m_star_left_deep_differs_by_the_figures_of_the_page() -> None:
    file = load_vessel("bb2")
    assert file.free_surface is not None
    none = (0.0, 0.0, 0.0, 0.0)
    rows = tuple(replace(row, Z_star=none, M_star=none) for row in file.free_surface.rows)
    Z_w, M_w = (8.4e-4, 8.4e-4, 8.4e-4, 0.0), (-8.7e-4, -8.7e-4, -8.7e-4, 0.0)
    slopes = replace(file.free_surface, rows=rows, Z_w=Z_w, M_w=M_w)

    compare_with_deep(replace(file, free_surface=slopes), 12.0, TABLE_13, "Table 13")


def test_a_boat_beyond_collapse_depth_is_lost_and_one_without_a_depth_is_not() -> None:
    dive = Meander(angle_deg=20.0, execute_deg=20.0, duration_s=400.0, direction=DIVE)

    lost = fly_manoeuvre(boat_of("bb2", Rig(depth=250.0)), dive, 20.0 * KNOT)
    at_once = fly_manoeuvre(boat_of("bb2", Rig(depth=250.0, controls="once")), dive, 20.0 * KNOT)
    free = fly_manoeuvre(boat_of("bb2"), dive, 20.0 * KNOT)

    for flight in (lost, at_once):
        assert flight.lost.startswith("collapse at 45")
        told = float(flight.lost.split()[-2])
        assert told == pytest.approx(flight.t[-1], abs=flight.step)
    assert not free.lost


def test_test_depth_passed_and_the_surface_broken_are_told() -> None:
    boat = boat_of("bb2", Rig(depth=40.0))
    up = fly_manoeuvre(boat, Meander(duration_s=120.0), 10.0 * KNOT)
    (broached,) = boat.notices(up.series.columns)
    boat = boat_of("bb2", Rig(depth=240.0))
    down = fly_manoeuvre(boat, Meander(duration_s=120.0, direction=DIVE), 10.0 * KNOT)
    (passed,) = boat.notices(down.series.columns)

    assert broached.startswith("BROACHED after ")
    assert passed.startswith("test depth, 250 m, is passed after ")
    assert boat_of("bb2").notices(down.series.columns) == ()


def test_a_sea_is_felt_and_another_seed_is_another_sea() -> None:
    def pitch(seed: int, sea: str = "sea-state-4") -> float:
        boat = boat_of("bb2", Rig(depth=20.0, sea=sea, seed=seed))
        return float(fly_manoeuvre(boat, Turn(5.0, 30.0), 10.0 * KNOT).column("theta")[-1])

    assert pitch(1) == pitch(1)
    assert pitch(1) != pitch(2)
    assert pitch(1, "calm") != pitch(1)
    with pytest.raises(ConfigError, match=r"no sea is felt 1000 m down.*give a --depth"):
        boat_of("bb2", Rig(sea="sea-state-4"))
    with pytest.raises(ConfigError, match="sea-state-4"):
        boat_of("bb2", Rig(depth=20.0, sea="sea-stat-4"))


def test_the_command_refuses_what_cannot_be_with_exit_code_2(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["turn", "bb2", "--sea", "sea-state-4"]
    monkeypatch.setattr(sys, "argv", ["trainer", "manoeuvre", *words])

    with pytest.raises(SystemExit) as left:
        main()

    assert left.value.code == 2
    assert "give a --depth" in capsys.readouterr().err


def test_the_command_says_on_which_side_and_where(tmp_path: Path) -> None:
    words = ["climbing-turn", "bb2", "--side", "port", "--dive", "--planes", "5"]
    path = tmp_path / "turn.csv"

    done = CliRunner().invoke(command, [*words, "--depth", "60", "--csv", str(path)])

    assert done.exit_code == 0, done.output
    assert "angle 15, planes 5, duration 300, port, dive" in done.stdout
    assert "from 60 m; sea: calm" in done.stdout
    last = dict(zip(*(path.read_text().splitlines()[i].split(",") for i in (0, -1)), strict=True))
    assert float(last["psi"]) < 0.0
    assert float(last["z"]) > 60.0


# --- reading numbers from flights


def test_a_level_is_passed_between_the_rows_from_either_side() -> None:
    t = np.array([0.0, 1.0, 2.0])

    assert first_time(t, np.array([0.0, 1.0, 3.0]), 2.0) == pytest.approx(1.5)
    assert first_time(t, np.array([3.0, 1.0, 0.0]), 2.0) == pytest.approx(0.5)
    assert first_time(t, np.array([0.0, 1.0, 1.5]), 2.0) is None


def test_a_flat_top_is_one_peak_and_a_hesitation_none() -> None:
    t = np.arange(8.0)
    values = np.array([0.0, 1.0, 2.0, 2.0, 1.0, 1.0, 0.0, -1.0])

    assert peaks_of(t, values) == [(2.0, 2.0)]
    assert zero_crossings(t, values) == [6.0]


def test_swings_are_allowed_a_share_of_the_first_and_faint_ones_no_time() -> None:
    t = np.arange(0.0, 60.0, 0.1)
    strong = np.cos(t) * np.exp(-0.01 * t)
    faint = np.cos(t) * np.exp(-1.2 * t)

    swings = {one.name: one for one in swing_measures("pitch", "rad", t, strong)}
    first = swings["pitch peak 1"].value or 0.0
    assert swings["pitch peak 2"].allowed == pytest.approx(0.05 * abs(first))
    assert swings["pitch zero 1"].allowed == 5.0
    dying = {one.name: one for one in swing_measures("pitch", "rad", t, faint)}
    assert dying["pitch zero 1"].allowed is None


def axes_of(panel: plots.Panel) -> Any:
    """Return the axes that a panel is drawn on."""
    axes = pytest.importorskip("matplotlib.figure").Figure().add_subplot()
    plots._draw_panel(panel, axes)  # noqa: SLF001
    return axes


@pytest.mark.parametrize(
    ("names", "down"),
    [(("z",), True), (("ordered_depth",), True), (("u",), False), (("theta",), False)],
)
def test_depth_is_plotted_downwards(names: tuple[str, ...], *, down: bool) -> None:
    columns = {name: np.array([60.0, 80.0]) for name in names}
    series = Series(Path("run.csv"), {"t": np.array([0.0, 1.0]), **columns})
    assert axes_of(panel_of(series, names)).yaxis_inverted() == down


def test_a_track_is_plotted_with_one_scale() -> None:
    curve = plots.Curve("way", np.array([0.0, 1.0]), np.array([60.0, 80.0]))
    assert axes_of(plots.Panel(plots.TRACK_TITLE, "x", "y", (curve,))).get_aspect() == 1.0
    assert axes_of(plots.Panel("roll", "x", "y", (curve,))).get_aspect() != 1.0


# --- what a heading at the order other than 0 changes


def turned_about(flight: Flight, angle: float) -> Flight:
    """Return the same motion seen with north an angle [rad] further round."""
    cosine, sine = math.cos(angle), math.sin(angle)
    x, y, psi = (flight.column(name) for name in ("x", "y", "psi"))
    turned = {"x": cosine * x - sine * y, "y": sine * x + cosine * y, "psi": psi + angle}
    return replace(flight, series=Series(flight.series.path, {**flight.series.columns, **turned}))


@pytest.mark.parametrize("name", ["zigzag-20", "turn", "climbing-turn", "turning-circle"])
def test_a_track_counts_from_the_heading_at_the_order(name: str) -> None:
    file, wanted = load_vessel("bb2"), find_manoeuvre(name)
    flight = fly_manoeuvre(Submarine(file, Method("full", "exact", "exact", "rk4", 0.5)), wanted, 5)
    other = wanted.measures(turned_about(flight, math.radians(1.1)))
    for one, seen in zip(wanted.measures(flight), other, strict=True):
        assert seen.value == pytest.approx(one.value, rel=1e-6, abs=1e-9), one.name


def test_the_speed_of_a_turn_is_the_ship_s_and_not_its_part_ahead() -> None:
    file = load_vessel("bb2")
    flight = fly_manoeuvre(Submarine(file, Method("full", "exact", "exact", "rk4", 0.5)), Turn(), 5)
    u, v, w = (float(flight.column(name)[-1]) for name in ("u", "v", "w"))
    found = {one.name: one.value for one in Turn().measures(flight)}
    assert abs(v) > 0.1 * u
    assert found["steady speed"] == pytest.approx(math.sqrt(u * u + v * v + w * w))
    assert found["steady speed, of the first"] == pytest.approx(math.hypot(u, v, w) / 5.0)
