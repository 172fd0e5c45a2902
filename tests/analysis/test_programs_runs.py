"""The engineer's programs that ask recorded runs: change of change, and fits of responses."""

import csv
import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner, Result
from helpers.places import DATA

from trainer.analysis.programs import fit as ec310
from trainer.analysis.programs.characteristic import horizontal_system, vertical_system
from trainer.analysis.programs.compare import (
    RunComparison,
    compare_runs,
    event_apart,
    render,
)
from trainer.boat.boat import Boat
from trainer.cli.main import cli
from trainer.config.boat.vessel import load_vessel
from trainer.config.files import ConfigError
from trainer.config.ship.series import Series, load_series
from trainer.debrief.passage.recording_export import panel_of, recorded_series
from trainer.units import KNOT

TOOLS = json.loads((DATA / "vectors" / "tools.json").read_text())
TIME = np.arange(0.0, 200.5, 0.5)


def run_of(**columns: np.ndarray) -> Series:
    return Series(Path("run.csv"), {"t": TIME, **columns})


def swing(size: float, damping: float = 0.03, start: float = 0.0, rate: float = 0.1) -> np.ndarray:
    """Return a swing that starts at ``start`` with no change."""
    return start + size * np.exp(-damping * TIME) * np.sin(rate * TIME)


# --- compare: ZC590, ZC691


@pytest.mark.parametrize("case", TOOLS["change_of_change"], ids=lambda case: str(case["percent"]))
def test_percent_change_of_change_is_that_of_the_reference(
    case: dict[str, list[float]], tmp_path: Path
) -> None:
    runs = []
    for name in ("full", "mod"):
        path = tmp_path / f"{name}.csv"
        path.write_text(f"t,q\n0,{case[name][0]}\n60,{case[name][1]}\n")
        runs.append(load_series(path))

    (point,) = compare_runs(*runs, ["q"]).points  # type: ignore[arg-type, call-arg]

    assert point.percent == pytest.approx(case["percent"], rel=1e-10)


def verdicts(report: RunComparison) -> dict[str, tuple[str, bool]]:
    """Return by variable the point that is judged, and the verdict."""
    return {point.variable: (point.point, point.passed) for point in report.points if point.judged}


def test_a_peak_is_judged_by_its_height_and_not_by_its_time() -> None:
    full = run_of(theta=swing(0.1, start=0.02))
    later, higher = run_of(theta=swing(0.1, 0.027, rate=0.09)), run_of(theta=swing(0.107))

    assert verdicts(compare_runs(full, later, ["theta"])) == {"theta": ("extreme", True)}
    assert verdicts(compare_runs(full, higher, ["theta"])) == {"theta": ("extreme", False)}
    peak = compare_runs(full, higher, ["theta"]).points[0]
    assert peak.percent == pytest.approx(-7.0, abs=1e-9)
    assert peak.t_full == pytest.approx(math.atan2(0.1, 0.03) / 0.1, abs=0.5)


def test_a_dip_is_compared_with_a_dip() -> None:
    full, other = run_of(theta=swing(-0.1)), run_of(theta=swing(-0.1) + 0.05 * TIME)

    peak = compare_runs(full, other, ["theta"]).points[0]

    assert peak.change_full < 0.0
    assert peak.change_reduced <= 0.0


def test_a_change_that_goes_on_is_judged_at_the_end_of_two_minutes() -> None:
    report = compare_runs(run_of(z=0.5 * TIME), run_of(z=0.52 * TIME), ["z"])

    (point,) = report.points
    assert (point.point, point.t_full, point.judged) == ("at the end", 120.0, True)
    assert point.percent == pytest.approx(-4.0)
    assert report.passed
    assert not compare_runs(run_of(z=0.5 * TIME), run_of(z=0.53 * TIME), ["z"]).passed


def test_a_value_that_settles_is_judged_as_well_as_its_overshoot() -> None:
    def roll(steady: float, overshoot: float) -> np.ndarray:
        return steady * (1.0 - np.exp(-0.1 * TIME)) + overshoot * np.exp(-0.1 * TIME) * np.sin(
            0.4 * TIME
        )

    good, bad = roll(0.1, 0.2), roll(0.12, 0.2)

    judged = [
        (point.point, point.passed)
        for point in compare_runs(run_of(phi=good), run_of(phi=bad), ["phi"], until=200.0).points
        if point.judged
    ]

    assert judged == [("extreme", True), ("steady", False)]


@pytest.mark.parametrize("damping", [0.01, 0.03])  # a lot and a little is left after two minutes
def test_what_is_left_of_a_swing_is_shown_and_not_judged(damping: float) -> None:
    run, other = run_of(theta=swing(0.1, damping)), run_of(theta=swing(0.1, damping, rate=0.102))

    report = compare_runs(run, other, ["theta"])

    ending = report.points[-1]
    assert (ending.point, ending.judged, ending.passed) == ("at the end", False, True)
    assert ending.percent is not None
    assert abs(ending.percent) > 5.0
    assert report.passed


def test_a_small_value_left_after_a_large_swing_is_not_judged_though_steady() -> None:
    def settling(rest: float) -> np.ndarray:
        return swing(0.1, 0.08) + rest * (1.0 - np.exp(-0.1 * TIME))

    report = compare_runs(
        run_of(phi=settling(1e-3)), run_of(phi=settling(2e-3)), ["phi"], until=200.0
    )

    ending = report.points[-1]
    assert (ending.point, ending.judged) == ("steady", False)


def test_a_run_is_the_same_as_itself_and_unchanged_variables_are_named() -> None:
    run = run_of(u=5.0 + 0.0 * TIME, z=swing(1.0, start=60.0), theta=swing(0.1))

    report = compare_runs(run, run, [])

    assert report.passed
    assert {point.percent for point in report.points} == {0.0}
    assert report.unchanged == ("u",)


def thrown(at: float, lost: float = 1.5) -> Series:
    """Return a run that loses ``lost`` m/s from 8 s on, its planes thrown over at ``at`` [s]."""
    planes = np.clip(0.05 * (TIME - at), 0.0, 0.3)
    return run_of(u=10.0 - lost * np.clip((TIME - 8.0) / 15.0, 0.0, 1.0), delta_s=planes)


def judged_with_events(full: Series, other: Series) -> RunComparison:
    return compare_runs(full, other, ["u"], event=event_apart(full, other))


def test_half_a_second_of_event_time_is_no_failure() -> None:
    report = judged_with_events(thrown(8.0), thrown(7.5, 1.4))

    assert (report.passed, report.event_s) == (True, 0.5)
    for point in report.points:
        assert point.by_event
        assert point.percent == pytest.approx(6.67, abs=0.01)
        assert point.event_worth == pytest.approx(0.05)  # 0.1 m/s2 for half a second
    page = render(report)
    assert "an event is 0.5 s apart" in page
    assert "All of 2 within 5 %, 2 of them but for a step." in page


@pytest.mark.parametrize(
    ("at", "lost"),
    [
        (8.0, 1.4),  # the events are at the same time
        (6.5, 1.4),  # they are further apart than a step
        (7.5, 1.3),  # the difference is more than the event is worth
    ],
)
def test_what_an_event_a_step_apart_does_not_explain_is_a_failure(at: float, lost: float) -> None:
    report = judged_with_events(thrown(8.0), thrown(at, lost))

    assert not report.passed
    assert "2 of 2 beyond 5 %." in render(report)


def test_a_surface_that_an_autopilot_moves_has_no_events() -> None:
    full, other = (
        run_of(u=10.0 + 0.0 * TIME, delta_s=0.1 * np.sin(0.3 * (TIME - late)))
        for late in (0.0, 0.5)
    )

    assert event_apart(full, other) == 0.0
    assert event_apart(thrown(8.0), thrown(7.5)) == 0.5


def test_runs_of_other_steps_and_lengths_are_compared_over_the_shorter() -> None:
    short = Series(Path("short.csv"), {"t": TIME[:40:2], "z": 0.5 * TIME[:40:2]})

    (point,) = compare_runs(run_of(z=0.5 * TIME), short, ["z"]).points

    assert point.t_full == point.t_reduced == 19.0
    assert point.percent == pytest.approx(0.0, abs=1e-9)


def test_a_column_that_a_run_lacks_is_named_with_the_nearest() -> None:
    with pytest.raises(ConfigError, match=r'run\.csv: no column "thet"; nearest is theta'):
        compare_runs(run_of(theta=TIME), run_of(theta=TIME), ["thet"])
    with pytest.raises(ConfigError, match="share no column of u, z"):
        compare_runs(run_of(a=TIME), run_of(b=TIME), [])


# --- files


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("time,u\n0,1\n1,2\n", "first line must name the columns, t"),
        ("t,u\n0,1\n1\n", "row 3: has 1 fields, the heading 2"),
        ("t,u\n0,1\n1,fast\n", 'row 3: u = "fast": must be a number'),
        ("t,u\n0,1\n1,nan\n", 'row 3: u = "nan": must be a number'),
        ("t,u\n0,1\n", "has 1 rows of numbers; needs 2"),
        ("t,u\n0,1\n1,1\n1,1\n", "row 4: t = 1 does not rise"),
    ],
)
def test_a_csv_file_that_is_wrong_is_told_where(text: str, said: str, tmp_path: Path) -> None:
    path = tmp_path / "run.csv"
    path.write_text(text)

    with pytest.raises(ConfigError, match=said):
        load_series(path)


def test_a_file_that_is_not_there_or_no_text_is_refused(tmp_path: Path) -> None:
    (tmp_path / "binary").write_bytes(b"\xff\xfe\x00")

    for name, said in (("none.csv", "No such file"), ("binary", "not a CSV text")):
        with pytest.raises(ConfigError, match=said):
            load_series(tmp_path / name)


# --- fit: EC310


VERTICAL = (-0.0252 + 0j, -0.0372 + 0.0328j)  # REFSUB at 5 kn
HORIZONTAL = (-0.1078 + 0j, -0.0148 + 0j, -0.0533 + 0.4339j)


def response(roots: tuple[complex, ...], sizes: tuple[float, ...], phase: float) -> np.ndarray:
    return np.asarray(
        sum(
            size * np.exp(s.real * TIME) * np.cos(s.imag * TIME + (phase if s.imag else 0.0))
            for s, size in zip(roots, sizes, strict=True)
        )
    )


@pytest.mark.parametrize(
    ("roots", "sizes", "starts"),
    [
        (VERTICAL, (1.0, -2.0), (-0.05 + 0j, -0.02 + 0.06j)),
        (HORIZONTAL, (0.5, -1.0, 2.0), (-0.2 + 0j, -0.01 + 0j, -0.1 + 0.4j)),
        ((-0.02 + 0j, -0.16 + 0j), (1.0, 2.0), (-0.01 + 0j, -0.3 + 0j)),
        ((0.004 + 0.2j,), (1.0,), (-0.01 + 0.22j,)),  # one that grows
    ],
)
def test_a_sum_of_damped_sinusoids_is_taken_apart_again(
    roots: tuple[complex, ...], sizes: tuple[float, ...], starts: tuple[complex, ...]
) -> None:
    y = response(roots, sizes, 0.7)

    found = ec310.fit_modes(TIME + 30.0, y, starts)

    assert found.converged
    for term, root, size in zip(found.terms, roots, sizes, strict=True):
        assert complex(term.real, term.imaginary) == pytest.approx(root, rel=1e-8)
        assert term.damping_ratio == pytest.approx(-root.real / abs(root))
        if root.imag:
            assert term.amplitude == pytest.approx(abs(size))
            turned = 0.7 if size > 0.0 else 0.7 - math.pi
            assert term.phase_rad == pytest.approx(turned)
        else:
            assert term.amplitude == pytest.approx(size)
    assert ec310.response_of(found.terms, TIME) == pytest.approx(y, abs=1e-9)
    assert found.explained == pytest.approx(1.0, abs=1e-12)


def test_the_response_itself_gives_roots_to_start_from() -> None:
    y = response(HORIZONTAL, (0.5, -1.0, 2.0), 0.7)

    starts = ec310.one_of_each(ec310.pencil_roots(TIME, y, 4))

    assert starts == pytest.approx(sorted(HORIZONTAL, key=lambda s: s.real), rel=1e-6)


def test_noise_moves_the_roots_by_about_their_standard_errors() -> None:
    y = response(HORIZONTAL, (0.5, -1.0, 2.0), 0.7)
    noise = np.random.default_rng(3).standard_normal((40, len(TIME)))
    pulls = []
    for row in noise:
        found = ec310.fit_modes(TIME, y + 0.01 * row, HORIZONTAL)
        assert found.rms == pytest.approx(0.01, rel=0.2)
        for term, root in zip(found.terms, HORIZONTAL, strict=True):
            assert term.real_error is not None
            pulls.append((term.real - root.real) / term.real_error)

    assert np.std(pulls) == pytest.approx(1.0, abs=0.2)


@pytest.mark.parametrize(
    ("t", "y", "said"),
    [
        (TIME[:10], TIME[:10], "10 samples are too few for 6 numbers; give 18"),
        (TIME, 0.0 * TIME, "zero throughout"),
    ],
)
def test_a_response_that_cannot_be_fitted_is_refused(
    t: np.ndarray, y: np.ndarray, said: str
) -> None:
    with pytest.raises(ConfigError, match=said):
        ec310.fit_modes(t, y, VERTICAL)


def test_a_response_of_fewer_modes_than_asked_for_is_refused() -> None:
    with pytest.raises(ConfigError, match="fewer than 3 modes"):
        ec310.pencil_roots(TIME, np.exp(-0.1 * TIME), 3)


def test_the_response_is_the_column_less_its_rest_value_within_the_time_asked_for() -> None:
    run = run_of(theta=0.2 + swing(0.1))

    t, y, level = ec310.response_in(run, "theta", (50.0, 60.0), None)

    assert (t[0], t[-1], level) == (50.0, 60.0, pytest.approx(0.2))  # type: ignore[comparison-overlap]
    assert y == pytest.approx(swing(0.1)[100:121])
    assert ec310.response_in(run, "theta", (50.0, 60.0), 0.5)[2] == 0.5
    with pytest.raises(ConfigError, match="no row from 300 s to 400 s; it has t from 0 to 200 s"):
        ec310.response_in(run, "theta", (300.0, 400.0), None)


@pytest.mark.parametrize(
    ("column", "plane", "group"),
    [("phi", horizontal_system, "roll"), ("theta", vertical_system, "pitch")],
)
def test_a_boat_disturbed_answers_with_the_roots_of_its_characteristic_polynomial(
    make_boat: Callable[..., Boat],
    by_hand: Callable[[Boat], None],
    column: str,
    plane: Any,
    group: str,
) -> None:
    boat = make_boat("bb2", rates="exact", integrator="rk4", step=0.25)
    boat.start(10.0 * KNOT, 100.0, 0.0)
    by_hand(boat)
    rest = float(boat.state[column])
    boat.state[column] += 1e-3
    t, y = [], []
    for _ in range(480):
        t.append(boat.time)
        y.append(float(boat.state[column]) - rest)
        boat.tick()
    wanted = ec310.one_of_each(plane(load_vessel("bb2"), 10.0 * KNOT).eigenvalues)

    found = ec310.fit_modes(np.array(t), np.array(y), wanted)

    assert found.explained > 0.9999
    swung = next(root for root in wanted if root.imag > 0.0)
    term = next(term for term in found.terms if term.imaginary > 0.0)
    # EC140 and EC200 leave out surge and the trim angle
    assert complex(term.real, term.imaginary) == pytest.approx(swung, rel=0.06), group


# --- export --plot: columns of a run


def export_it(*words: str) -> Result:
    """Return what trainer export does."""
    return CliRunner().invoke(cli, ["export", *words])


def write_run(path: Path) -> Series:
    """Write a small run as CSV; return it."""
    columns = {"z": 60.0 + swing(5.0), "delta_s": swing(0.1), "delta_b": swing(0.05)}
    rows = zip(TIME, *columns.values(), strict=True)
    lines = [",".join(["t", *columns]), *(",".join(map(repr, map(float, row))) for row in rows)]
    path.write_text("\n".join(lines))
    return load_series(path)


def test_columns_of_a_run_share_a_panel_in_degrees_as_asked_for(tmp_path: Path) -> None:
    series = write_run(tmp_path / "run.csv")

    panel = panel_of(series, ["delta_s", "delta_b"])

    assert [curve.label for curve in panel.curves] == ["delta_s", "delta_b"]
    assert panel.y == "delta_s, delta_b [deg]"
    assert panel.curves[1].y == pytest.approx(np.degrees(swing(0.05)), abs=1e-12)
    with pytest.raises(ConfigError, match="--column z,delta_s: m and deg do not share an axis"):
        panel_of(series, ["z", "delta_s"])


def test_a_csv_file_of_a_run_is_drawn(tmp_path: Path) -> None:
    run, out = tmp_path / "run.csv", tmp_path / "out.svg"
    write_run(run)

    done = export_it(str(run), "--plot", str(out), "--column", "z", "--column", "delta_s,delta_b")

    assert done.exit_code == 0, done.output
    assert done.stdout == f"{out}\n"
    assert out.read_bytes().startswith(b"<?xml")


def test_a_recording_is_drawn_from_the_states_that_it_holds(tmp_path: Path) -> None:
    drill, table, out = (tmp_path / name for name in ("drill.trainer", "drill.csv", "drill.svg"))
    flown = ["run", "--headless", "--duration", "20", "--speed", "max", "--record", str(drill)]
    assert CliRunner().invoke(cli, flown).exit_code == 0

    done = export_it(str(drill), "--plot", str(out), "--csv", str(table))

    assert done.exit_code == 0, done.output
    assert out.read_bytes().startswith(b"<?xml")
    drawn = recorded_series(drill, ["z", "delta_s"], None)
    written = load_columns(table, ("t", "z", "delta_s"))
    assert len(drawn.t) == 41
    for name, values in written.items():
        assert (drawn.columns[name] == values).all()


def load_columns(path: Path, names: tuple[str, ...]) -> dict[str, np.ndarray]:
    """Return columns of a table in which other columns may be empty."""
    with path.open(newline="") as file:
        rows = list(csv.DictReader(file))
    return {name: np.array([float(row[name]) for row in rows]) for name in names}


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--plot", "x.svg", "--column", "zz"], 'no column "zz"; nearest is z'),
        (["--plot", "x.gif"], "x.gif: must end in .png, .svg or .pdf"),
        (["--csv", "out.csv"], "is a table already; of a CSV file only --plot FILE is made"),
        (["--column", "z"], "--column says what --plot FILE draws"),
    ],
)
def test_a_plot_of_a_run_that_cannot_be_is_told(
    words: list[str], said: str, tmp_path: Path
) -> None:
    run = tmp_path / "run.csv"
    run.write_text("t,z,theta,u\n0,1,0,3\n1,2,0,3\n")

    done = export_it(str(run), *words)

    assert done.exit_code == 2 or isinstance(done.exception, ConfigError)
    assert said in f"{done.output} {done.exception}"


@pytest.mark.long
def test_the_charts_of_an_acceleration_are_drawn_from_its_run(tmp_path: Path) -> None:
    run, out = tmp_path / "a.csv", tmp_path / "a.svg"
    columns = ("delta_s,delta_b", "theta", "u", "q", "z")
    words = [word for names in columns for word in ("--column", names)]
    flown = ["manoeuvre", "acceleration", "bb2", "--csv", str(run)]
    assert CliRunner().invoke(cli, flown).exit_code == 0

    done = export_it(str(run), "--plot", str(out), *words)

    assert done.exit_code == 0, done.output
    assert out.read_bytes().startswith(b"<?xml")
    series = load_series(run)
    (speed,) = panel_of(series, ["u"]).curves
    assert speed.y.max() / KNOT == pytest.approx(20.0, rel=0.05)
    planes = panel_of(series, ["delta_s", "delta_b"])
    assert all(abs(curve.y).max() > 0.1 for curve in planes.curves)
