"""Manoeuvres: schedules and measures, flown by the boats and by a reference boat."""

import ast
import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.places import DATA

from trainer.analysis import manoeuvres
from trainer.analysis.manoeuvres.catalogue import MANOEUVRES, adjust, find_manoeuvre
from trainer.analysis.manoeuvres.flight import Manoeuvre, fly
from trainer.analysis.manoeuvres.speeds import UtmostAcceleration
from trainer.analysis.manoeuvres.spiral import PullOut
from trainer.analysis.manoeuvres.submarine import Rig, Submarine
from trainer.analysis.manoeuvres.turns import Turn
from trainer.analysis.manoeuvres.vehicle import crossings, first_time, peaks, swing_measures
from trainer.analysis.manoeuvres.vertical import Meander, Overshoot
from trainer.boat.assemble import Method
from trainer.config.files import ConfigError
from trainer.config.vessel import VesselFile, load_vessel
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
        "u_end": "steady speed",
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

    flight = fly(boat, manoeuvre, run.get("knots", 0.0) * REFERENCE_KNOT)

    ours = {one.name: one for one in manoeuvre.measures(flight)}
    assert not flight.lost
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
            "trainer.analysis.series",
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
    boat = boat_of("bb2")
    manoeuvre = adjust(name, boat, {})

    flight = fly(boat, manoeuvre, 0.0 if manoeuvre.from_rest else 10.0 * KNOT)
    found = manoeuvre.measures(flight)

    assert not flight.lost
    assert len(found) > 2
    assert len({one.name for one in found}) == len(found)
    numbers = [one.value for one in found if one.value is not None]
    assert np.isfinite(numbers).all()
    assert all(
        flight.has(column)
        for column in (*manoeuvre.compared, *manoeuvre.shows)
        if column != "track"
    )


def test_a_boat_stable_on_course_keeps_no_turn_after_the_rudder_is_amidships() -> None:
    flight = fly(boat_of("bb2"), PullOut(), 10.0 * KNOT)

    found = {one.name: one.value for one in PullOut().measures(flight)}

    assert abs(found["yaw rate left after port"] or 1.0) < 0.01 * abs(
        found["yaw rate, rudder to port"] or 0.0
    )


def test_controls_of_1969_act_at_once_and_the_boats_own_at_their_rate() -> None:
    once = fly(boat_of("bb2", Rig(controls="once")), Turn(20.0, 12.0), 5.0)
    own = fly(boat_of("bb2"), Turn(20.0, 12.0), 5.0)

    angles = [abs(flight.at(6.0, "delta_r") or 0.0) for flight in (once, own)]
    assert math.degrees(angles[0]) == pytest.approx(20.0, abs=0.1)
    assert math.degrees(angles[1]) == pytest.approx(7.1, abs=0.1)


def test_a_speed_that_is_kept_is_kept_in_a_turn() -> None:
    kept = Turn(20.0, 300.0, keep=("depth", "speed"))

    flight = fly(boat_of("bb2"), kept, 10.0 * KNOT)

    assert flight.column("u")[-1] == pytest.approx(10.0 * KNOT, rel=0.01)


def test_a_boat_that_loops_is_lost_and_says_when() -> None:
    flight = fly(boat_of("remus100"), adjust("meander", boat_of("remus100"), {}), 3.0 * KNOT)

    assert flight.lost.startswith("pitch is 8")
    assert flight.t[-1] < 60.0


def test_planes_are_clipped_to_what_the_boat_has_unless_asked_for_more(bb2: VesselFile) -> None:
    boat = Submarine(bb2, Method("full", "exact", "exact", "rk4", 0.5))

    assert adjust("turning-circle", boat, {}).angle_deg == 30.0  # type: ignore[attr-defined]
    with pytest.raises(ConfigError, match=r"--angle 35: the rudder of .* goes to 30 degrees"):
        adjust("turning-circle", boat, {"angle": 35.0})
    with pytest.raises(ConfigError, match="--execute: turn has no such parameter; it has angle"):
        adjust("turn", boat, {"execute": 5.0})
    with pytest.raises(ConfigError, match="nearest is meander"):
        find_manoeuvre("meandr")


# --- reading numbers from flights


def test_a_level_is_passed_between_the_rows_from_either_side() -> None:
    t = np.array([0.0, 1.0, 2.0])

    assert first_time(t, np.array([0.0, 1.0, 3.0]), 2.0) == pytest.approx(1.5)
    assert first_time(t, np.array([3.0, 1.0, 0.0]), 2.0) == pytest.approx(0.5)
    assert first_time(t, np.array([0.0, 1.0, 1.5]), 2.0) is None


def test_a_flat_top_is_one_peak_and_a_hesitation_none() -> None:
    t = np.arange(8.0)
    values = np.array([0.0, 1.0, 2.0, 2.0, 1.0, 1.0, 0.0, -1.0])

    assert peaks(t, values) == [(2.0, 2.0)]
    assert crossings(t, values) == [6.0]


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
