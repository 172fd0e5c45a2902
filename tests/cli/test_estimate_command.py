"""The command trainer boat estimate: what it writes sails; what is wrong is told in one line."""

import io
import json
import math
import re
import sys
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner, Result
from helpers.places import ROOT

from trainer.analysis.check import check_vessel, critical_speed
from trainer.analysis.check_page import examine_boat
from trainer.analysis.estimate import survey
from trainer.analysis.estimate.boat_file import (
    MAX_ROLL_STEP_RAD,
    WrittenBoat,
    boat_tables,
    boat_text,
    estimate_of,
    open_hull,
    roll_frequency,
    write_boat,
)
from trainer.analysis.gains import design_gains
from trainer.analysis.reduce.objective import Candidate, Yardstick
from trainer.analysis.reduce.programme import fit_legs
from trainer.analysis.sweep.study import load_study, parse_study
from trainer.boat.assemble import Method
from trainer.boat.boat import Boat
from trainer.cli.workshop.estimate import estimate
from trainer.config.boat.hull import read_hull
from trainer.config.boat.vessel import VesselFile, load_vessel, parse_vessel, read_vessel
from trainer.config.files import ConfigError, parse_toml
from trainer.units import KNOT

HULL = """
name = "A boat"
[hull]
length = 20.0
breadth = 2.4
nose_length = 3.6
tail_length = 7.2
[mass]
cb_above_cg = 0.12
[speed]
design_kn = 8.0
[propeller]
diameter = 1.3
[[surfaces]]
name = "planes"
control = "stern"
angles_deg = [0.0, 180.0]
le_root = 17.3
root_chord = 1.4
tip_chord = 1.0
tip_radius = 1.45
[[surfaces]]
name = "rudders"
control = "rudder"
angles_deg = [90.0, 270.0]
le_root = 17.3
root_chord = 1.4
tip_chord = 1.0
tip_radius = 1.45
"""
STATIONS = "stations = [[0,0,0],[2,2,2],[4,2.4,2.4],[12,2.4,2.4],[17,1.4,1.4],[20,0,0]]"
ROUND = "breadth = 2.4\nnose_length = 3.6\ntail_length = 7.2"


def type_estimate(*words: str) -> Result:
    return CliRunner().invoke(estimate, list(words), catch_exceptions=True)


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with what one call writes."""
    folder = tmp_path_factory.mktemp("estimate")
    paths = [str(folder / name) for name in ("boat.toml", "boat.html", "bands.toml")]
    flags = ("-o", paths[0], "--html", paths[1], "--study", paths[2], "--draws", "4")
    done = type_estimate("small-boat", *flags)
    assert done.exit_code == 0, done.output
    (folder / "said.txt").write_text(done.output, encoding="utf-8")
    return folder


@pytest.fixture(scope="module")
def boat(written: Path) -> VesselFile:
    return load_vessel(str(written / "boat.toml"))


@pytest.mark.slow
def test_the_boat_passes_check_at_its_own_step(boat: VesselFile) -> None:
    report = check_vessel(boat)

    assert report.own_step_stable
    ready = examine_boat(boat)
    assert ready.passed
    assert not ready.compact  # by the full set alone there is no flight to judge
    lacks = {lack.what.partition(":")[0] for lack in ready.lacks}
    assert {"gains", "[wave_strips]"} & lacks == set()
    assert all("K_star_eta" in one for one in report.remarks)
    assert report.absent_but_kept == {}


def test_the_gains_written_are_those_of_trainer_gains(boat: VesselFile) -> None:
    assert boat.autopilot
    told = design_gains(boat)
    assert list(boat.autopilot.rudder_course) == told["rudder_course"]
    assert list(boat.autopilot.stern_pitch) == told["stern_pitch"]


@pytest.mark.parametrize("name", ["suboff", "small-boat"])
def test_the_gains_keep_depth_and_course(name: str) -> None:
    """A new depth and a new course at once, at the design speed; SUBOFF is unstable by itself."""
    boat = write_boat(open_hull(name), Path("boat.toml")).file
    length, step = boat.hull.length, boat.run.step_s
    sailing = Boat(boat, Method("full", "lagged", "exact", "adams2", boat.run.step_s))
    sailing.start(boat.run.start_speed_kn * KNOT, boat.run.start_depth_m, 0.0)
    s = sailing.state
    s.ordered_depth, s.ordered_psi = s.z + 0.5 * length, 0.5
    for _ in range(int(70.0 * length / (boat.run.start_speed_kn * KNOT) / step)):
        assert sailing.tick() == 0

    assert s.z == pytest.approx(boat.run.start_depth_m + 0.5 * length, abs=0.005 * length)
    assert s.psi == pytest.approx(0.5, abs=0.01)
    assert abs(s.theta) < 0.02


def test_every_coefficient_stands_with_its_deviation(written: Path) -> None:
    text = (written / "boat.toml").read_text(encoding="utf-8")
    rows = re.findall(r"^([XYZKMN]_\w+) = \S+   # L\^\d, sd (\S+); (.+)$", text, re.MULTILINE)
    deviations = tomllib.loads(text)["estimate"]["sd"]

    assert len(rows) == 122
    written_sd = {key: float(sd) for key, sd, _ in rows}
    assert written_sd == pytest.approx({key: deviations[key] for key in written_sd}, rel=0.06)
    assert written_sd["Y_v"] > 0.0


def test_the_page_has_the_hull_to_scale_and_every_coefficient(written: Path) -> None:
    html = (written / "boat.html").read_text(encoding="utf-8")
    outlines = re.findall(r'class="hull" d="M([^"]+)Z"', html)
    points = [[float(x) for x in pair.split()] for pair in outlines[0].split("L")]
    wide = max(x for x, _ in points) - min(x for x, _ in points)
    high = max(y for _, y in points) - min(y for _, y in points)

    assert len(outlines) == 2
    assert wide / high == pytest.approx(20.0 / 2.4, rel=0.01)
    assert html.count('class="panel') == 2 * 7
    assert len(re.findall(r"<tr><td>[XYZKMNabc]\w*</td>", html)) == 131
    found = json.loads(re.search(r'id="estimate">(.*?)</script>', html, re.DOTALL)[1])  # type: ignore[index]
    assert found["vessel"] == "Small boat, generic, 20 m"
    assert len(found["influences"]) == 10


def test_the_terminal_tells_bands_and_what_moves_them(written: Path) -> None:
    said = (written / "said.txt").read_text(encoding="utf-8")

    assert re.search(r"Gh +0\.513 +\S+ to \S+ +\S+ to \S+", said)
    assert re.search(r"steady diameter \[m\] +95\.\d", said)
    assert "4 OF 4 DRAWS FLEW IT: FEW, THE BANDS ARE ROUGH" in said
    assert "hull.breadth" in said
    assert "controls.rate_deg_s" in said
    assert max(len(line) for line in said.splitlines() if "trainer " not in line) <= 79


def test_a_study_draws_boats_from_the_file(written: Path) -> None:
    study = load_study(str(written / "bands.toml"))
    own = study.tables["vessel"]
    numbers = [study.draws.middle()["draw"], *study.draws.drawn(0, 3)["draw"]]
    boats = [study.varied({"draw": number})["vessel"] for number in numbers]
    sway = [boat["coefficients"]["N_v"] for boat in boats]
    drag = [boat["propulsion"]["sets"][0]["a"] for boat in boats]

    assert sway[0] == own["coefficients"]["N_v"]
    assert drag[0] == own["propulsion"]["sets"][0]["a"]
    assert len(set(sway)) == len(set(drag)) == 4
    assert {boat["vessel"]["mass"] for boat in boats} == {own["vessel"]["mass"]}


def test_a_study_of_a_boat_that_was_not_estimated_is_refused(written: Path) -> None:
    text = (written / "bands.toml").read_text(encoding="utf-8")
    for change, told in (
        (('"./boat.toml"', '"bb2"'), "lacks the table [estimate]"),
        (('key = "vessel"', 'key = "vessel.fluid.rho"'), "must be vessel"),
    ):
        with pytest.raises(ConfigError, match=re.escape(told)):
            parse_study(text.replace(*change), written / "bands.toml")


def test_a_new_hull_is_that_of_the_small_boat(tmp_path: Path) -> None:
    made = tmp_path / "hull.toml"

    assert type_estimate("new", str(made)).exit_code == 0
    with pytest.raises(ConfigError, match="is there already"):
        CliRunner().invoke(estimate, ["new", str(made)], catch_exceptions=False)

    new = estimate_of(open_hull(str(made))).values
    assert new["N_v"] == pytest.approx(estimate_of(open_hull("small-boat")).values["N_v"], rel=0.02)


def test_every_usual_value_of_the_skeleton_is_the_one_taken() -> None:
    """Keys behind a # that have a usual number: the same boat, if they are uncommented."""
    text = (ROOT / "configs/hull-skeleton.toml").read_text(encoding="utf-8")
    usual = r"^# ((?:nose_exponent|tail_exponent|base_diameter|roughness|wake|KT|KQ|nu|axis_up) =)"
    told = read_hull(parse_toml(re.sub(usual, r"\1", text, flags=re.MULTILINE), "a"), Path("a"))
    left = read_hull(parse_toml(text, "a"), Path("a"))

    assert told.form == left.form
    assert (told.speed, told.propeller, told.water) == (left.speed, left.propeller, left.water)
    assert told.surfaces == left.surfaces


BAD = [  # a part of the file, what takes its place, and what is told
    (
        "length = 20.0",
        "length = 20.0\nlenght = 3",
        r"\[hull\] lenght = 3: no such key; nearest is length",
    ),
    (
        "[mass]",
        "[vessel]\n[mass]",
        r"hull\.toml: is a vessel; wanted is a hull, as `trainer boat e",
    ),
    ("[propeller]", "[screw]", r"screw = .*: no such key; there are name, .*propeller"),
    ("length = 20.0\n", "", r"\[hull\] lacks length"),
    ("[speed]\ndesign_kn = 8.0\n", "", "lacks speed"),
    ("length = 20.0", 'length = "long"', r"length = \"long\": must be a number, 0.3 to 400 m"),
    ("length = 20.0", "length = nan", r"length = nan: must be finite, 0.3 to 400 m"),
    ("length = 20.0", "length = 8.0", r"length = 8.0: nose 3.6 m and tail 7.2 m .* 10.8 m"),
    (
        "length = 20.0",
        "length = 65.6",
        r"length = 65.6: 27 breadths, .*: is it in feet",
    ),
    (ROUND, STATIONS.replace("[4,", "[1,"), r"stations\[2\] = .*: x must rise: .* above 2 m"),
    (ROUND, STATIONS.replace("[2,2,2]", "[2,-2,2]"), r"stations\[1\] = .*must not be negative"),
    (ROUND, "stations = [[0,0,0],[10,2,2],[20,0,0]]", r"stations = .*must be 5 to 200 rows"),
    (ROUND, STATIONS.replace("[20,", "[24,"), r"stations: 0 to 24 m: .* 0 to length = 20 m"),
    (ROUND, STATIONS.replace("[20,0,0]", "[20,2,2]"), r"stations: the last is 2 m wide: .* 0.48 m"),
    (ROUND, re.sub(r"[\d.]+,[\d.]+\]", "0,0]", STATIONS), r"the area is nowhere above 0 m2"),
    (ROUND, f"{ROUND}\n{STATIONS}", "give one of stations, breadth"),
    ("tip_radius = 1.45", "tip_radius = 0.2", r"tip_radius = 0.2: .* hull's radius there, 0.\d+ m"),
    ("tip_radius = 1.45", "tip_radius = 1.45\nroot_radius = 1.5", r"above root_radius, 1.5 m"),
    ("tip_radius = 1.45", "tip_radius = 1.45\nmoving_area = 9.0", r"area, 1.\d+ m2"),
    ("le_root = 17.3", "le_root = -1.0", r"le_root = -1.0: must not be ahead of the nose"),
    ("le_root = 17.3", "le_root = 23.0", r"trailing edge at 24.4 m, must be at most 22 m"),
    ("angles_deg = [0.0, 180.0]", "angles_deg = [90.0]", r"no stern can act there.*0 or 180 deg"),
    ('control = "stern"', 'control = "sterm"', r"must be none or stern or rudder or bow or x"),
    ("cb_above_cg = 0.12", "cg_from_nose = 2.0", r"cg_from_nose = 2.0: .* middle 60 %, 4 to 16 m"),
    (
        "cb_above_cg = 0.12",
        "mass = 20000.0",
        r"mass = 20000.0: must be rho V = 71\d+ kg within 30%",
    ),
    ("diameter = 1.3", "diameter = 1.3\nKT = [-0.1, 0.0, 0.0]", r"KT = .*no revolutions"),
    ("diameter = 1.3", "diameter = 3.0", r"diameter = 3.0: .*greatest breadth, 2.4 m"),
]


@pytest.mark.parametrize(("part", "instead", "told"), BAD, ids=[row[2][:40] for row in BAD])
def test_a_bad_hull_is_refused_in_one_line(
    tmp_path: Path, part: str, instead: str, told: str
) -> None:
    hull, boat = tmp_path / "hull.toml", tmp_path / "boat.toml"
    assert part in HULL
    hull.write_text(HULL.replace(part, instead, 1), encoding="utf-8")

    wrong = type_estimate(str(hull), "-o", str(boat)).exception

    assert isinstance(wrong, ConfigError)
    lines = str(wrong).splitlines()  # one for each thing that is wrong
    assert [line for line in lines if re.search(told, line)], lines
    assert all(line.startswith("hull.toml: ") for line in lines)
    assert len(lines) == (3 if instead == "length = 8.0" else 1)
    assert not boat.exists()


def test_a_hull_of_more_than_a_megabyte_is_not_read(tmp_path: Path) -> None:
    path = tmp_path / "hull.toml"
    path.write_text(HULL + "#" * 1_000_001, encoding="utf-8")

    assert "larger than the limit" in str(type_estimate(str(path)).exception)


WARNED = [
    (
        "cb_above_cg = 0.12",
        "mass = 80000.0\ncb_above_cg = 0.1",
        "mass = 80000 kg, the hull displaces 71",
    ),
    ("cb_above_cg = 0.12\n", "", "cb_above_cg is taken as 0.12 m"),
    ("breadth = 2.4", "breadth = 2.4\nheight = 1.6", "breadth/height is 1.5"),
    ("design_kn = 8.0", "design_kn = 45.0", "is it in knots"),
    ("tip_radius = 1.45", "tip_radius = 0.8", "Gv = "),
    ("cb_above_cg = 0.12", "cb_above_cg = 2.3", "the stern planes reverse at"),
]


@pytest.mark.parametrize(("part", "instead", "told"), WARNED, ids=[row[2][:30] for row in WARNED])
def test_what_is_unusual_is_told_and_the_boat_is_made(
    tmp_path: Path, part: str, instead: str, told: str, lightly: Callable[[Path], Any]
) -> None:
    hull = tmp_path / "hull.toml"
    assert part in HULL
    hull.write_text(HULL.replace(part, instead, 1), encoding="utf-8")

    assert any(told in each for each in lightly(hull))


def test_no_turn_is_advised_to_a_boat_without_a_rudder(tmp_path: Path) -> None:
    hull = tmp_path / "hull.toml"
    hull.write_text(HULL.replace('control = "rudder"', ""), encoding="utf-8")

    said = type_estimate(str(hull), "-o", str(tmp_path / "boat.toml"), "--draws", "0").output

    assert "(NO DRAWS, NO BANDS)" in said
    assert "next: trainer boat check" in said
    assert "turning-circle" not in said


@pytest.fixture
def lightly() -> Callable[[Path], Any]:
    """Return what gives the warnings about a hull, without gains and flights."""

    def warn(path: Path) -> list[str]:
        made = estimate_of(open_hull(str(path)))
        text = boat_text(made, boat_tables(made))
        file = parse_vessel(text, path)
        speeds = {plane: critical_speed(file, plane) for plane in ("stern", "bow")}
        own = {name: None if x is None else x / KNOT for name, x in speeds.items()}
        return list(survey.warnings(WrittenBoat(made, text, file, ()), own))

    return warn


XTAIL = HULL.partition("[[surfaces]]")[0] + (
    '[[surfaces]]\nname = "tail"\ncontrol = "x"\nangles_deg = [45.0, 135.0, 225.0, 315.0]\n'
    "le_root = 17.3\nroot_chord = 1.4\ntip_chord = 1.0\ntip_radius = 1.45\n"
)
SORTS = {
    "X-tail": (XTAIL, ""),
    "no propeller": (HULL.replace("[propeller]\ndiameter = 1.3\n", ""), ""),
    "box": (HULL.replace(ROUND, f'{STATIONS}\nsection = "box"'), ""),
    "no rudder": (HULL.replace('"rudder"', '"none"'), "no panel has control = rudder"),
    "no gains": (HULL.replace("design_kn = 8.0", "design_kn = 0.05"), "depth_acceleration_m_s2"),
}


@pytest.mark.long
@pytest.mark.parametrize("sort", SORTS)
def test_a_boat_of_each_sort_is_written(tmp_path: Path, sort: str) -> None:
    text, lack = SORTS[sort]
    hull = tmp_path / "hull.toml"
    hull.write_text(text, encoding="utf-8")

    made = write_boat(open_hull(str(hull)), tmp_path / "boat.toml")

    assert (made.file.autopilot is None) == bool(lack)
    assert made.file.run.step_s == 0.1  # at 0.2 s the formula feeds its roll, at 0.5 s it grows
    assert lack in "".join(made.lacks)
    assert made.file.surfaces.tail == ("x" if sort == "X-tail" else "cruciform")
    ahead, astern = made.file.thrust.ahead[0], made.file.propulsion.sets[-1]
    assert ahead.a + ahead.b + ahead.c == pytest.approx(0.0, abs=1e-12)
    assert astern.c / ahead.c == pytest.approx(-1.0 if sort == "no propeller" else -0.7, rel=1e-5)


def test_the_step_lets_a_free_roll_die_out_by_the_compact_set_too() -> None:
    file = write_boat(open_hull("suboff"), Path("boat.toml")).file
    leg = next(leg for leg in fit_legs(file) if leg.name == "roll-decay")
    candidate, yardstick = Candidate(file, "modified"), Yardstick(file, [leg])
    (judged,) = (judgements for _, judgements in yardstick.judged(candidate))
    period = next(one.full for one in judged if one.quantity == "period")

    assert period is not None
    assert roll_frequency(file) == pytest.approx(2.0 * math.pi / period, rel=0.05)
    assert roll_frequency(file) * file.run.step_s <= MAX_ROLL_STEP_RAD
    assert abs(yardstick.differences(candidate)).max() < 0.5  # of what is allowed


@pytest.mark.slow
def test_a_compact_set_is_searched_for_quickly_in_the_file_that_is_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[list[str]] = []
    monkeypatch.setattr(
        "trainer.cli.workshop.vessel.reduce.main", lambda words, **_: asked.append(list(words))
    )
    boat = tmp_path / "boat.toml"

    done = type_estimate("small-boat", "-o", str(boat), "--draws", "0", "--reduce")

    assert done.exit_code == 0, done.output
    assert asked == [[str(boat), "--write", "--quick"]]
    assert boat.exists()


# How far it is


@pytest.mark.long
def test_the_bar_moves_with_each_boat_that_is_made(monkeypatch: pytest.MonkeyPatch) -> None:
    """A hull of 36 surfaces took four times as long to make its boats as to fly them all."""
    written = write_boat(open_hull("small-boat"), Path("boat.toml"))
    boats, moves = [0], []

    def note_boat(*given: Any) -> VesselFile:
        boats[-1] += 1
        return read_vessel(*given)

    def hear(turns: int) -> None:
        moves.append(turns)
        boats.append(0)

    monkeypatch.setattr(survey, "read_vessel", note_boat)
    survey.survey_boat(written, 3, hear)

    assert sum(moves) == survey.turns_of(written, 3)
    assert sum(boats) > 60
    assert max(boats) == 1


class Terminal(io.StringIO):
    """A terminal that keeps what is written to it."""

    def isatty(self) -> bool:
        return True


@pytest.mark.long
@pytest.mark.parametrize("stderr", [Terminal, io.StringIO])
def test_how_far_it_is_is_shown_on_a_terminal_alone(
    stderr: type[io.StringIO], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    screen = stderr()
    monkeypatch.setattr(sys, "stderr", screen)
    estimate.main(["small-boat", "--draws", "1"], standalone_mode=False)
    shown = screen.getvalue()

    if stderr is Terminal:
        assert "turning" in shown
        assert "50%" in shown
        assert "100%" in shown
    else:
        assert shown == ""
