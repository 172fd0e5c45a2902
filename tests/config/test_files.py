"""What a configuration file may say, and what its author is told when it is wrong."""

import json
import math
import tomllib
from collections.abc import Callable
from dataclasses import fields
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from trainer.config.boat.vessel import VesselFile, load_vessel, parse_vessel
from trainer.config.boat.vessel_records import Autopilot
from trainer.config.files import (
    ConfigError,
    Position,
    collecting,
    json_text,
    parse_toml,
    read_text,
    shipped_names,
    shipped_path,
)
from trainer.config.schema import Quantities, kind_of
from trainer.core.terms import COEFFICIENTS, TERM_TABLE

PLACE = Path("boat.toml")

# BB2's size and mass, nothing else: enough to evaluate.
SMALL = """
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
a = -0.001
b = -0.002
c = 0.003

[coefficients.X]
X_udot = -1.2e-3

[coefficients.N]
N_dr = -7.0e-3
"""

AUTOPILOT_LISTS = [
    item.name
    for item in fields(Autopilot)
    if isinstance(kind_of(item), Quantities) and item.name != "speed_kn"
]
RISING, RUDDER = "[0.3, 0.2, 0.1]", "[-0.3, -0.2, -0.1]"  # the rudder's sense is that of N_dr
AUTOPILOT = "\n".join(
    [
        "\n[autopilot]",
        "speed_kn = [3, 10, 20]",
        *(
            f"{name} = {RUDDER if name.startswith('rudder') else RISING}"
            for name in AUTOPILOT_LISTS
        ),
        "speed_integral = 0.01",
        "turning_rate_deg_s = 0.1",
    ],
)


def small(*replacements: tuple[str, str]) -> VesselFile:
    """Return the vessel of SMALL after replacing pieces of its text that are there once."""
    text = SMALL
    for old, new in replacements:
        assert text.count(old) == 1, old
        text = text.replace(old, new)
    return parse_vessel(text, PLACE)


def complaint(load: Callable[[], object]) -> str:
    """Return the whole message of the ConfigError that ``load`` raises."""
    with pytest.raises(ConfigError) as caught:
        load()
    assert all(text.isprintable() for text in caught.value.problems), "each on one line"
    return str(caught.value)


def small_complaint(*replacements: tuple[str, str]) -> str:
    """Return what is said of SMALL after the replacements."""
    return complaint(lambda: small(*replacements))


# What is shipped


def test_the_shipped_boats_load_and_say_everything_a_run_needs() -> None:
    assert shipped_names("vessels") == ("bb2", "remus100", "sdv-mk9")
    for name in shipped_names("vessels"):
        boat = load_vessel(name)
        used = [item for item in boat.defaulted if not item.startswith(("compact", "comp"))]

        assert boat.remarks == ()
        assert [item for item in used if not item.startswith("vessel.I")] == []


def test_bb2_has_the_numbers_of_its_source() -> None:
    boat = load_vessel("bb2")

    assert boat.hull.length == 70.2
    assert boat.coefficients["N_dr"] == -7.22e-3
    assert boat.surfaces.tail == "x"
    assert boat.propulsion.bells_kn["astern_full"] == -8.0
    assert (boat.run.start_speed_kn, boat.run.start_depth_m) == (10.0, 60.0)
    assert "Z_vr" not in boat.absent  # given as zero, so not absent


def test_sdv_takes_its_cross_flow_from_the_equivalent_table() -> None:
    boat = load_vessel("sdv-mk9")
    table = tomllib.loads(boat.text)["equivalent_2510_nonlinear"]

    assert set(table) == {"Y_vav", "Z_waw", "N_rar", "M_qaq"}
    assert {key: boat.coefficients[key] for key in table} == table


def test_there_are_131_terms_of_which_the_compact_set_keeps_60() -> None:
    # 68-C-0050-1, Tables 2 to 4 and 18: 131 less the 71 dropped. Nine of both are thrust rows.
    assert len(TERM_TABLE) == len({term.key for term in TERM_TABLE}) == 131
    assert sum(term.kept for term in TERM_TABLE) == 60
    assert len(COEFFICIENTS) == 122
    assert sum(term.kept for term in COEFFICIENTS) == 51


def test_a_path_and_a_name_load_the_same_boat() -> None:
    path = shipped_path("vessels", "bb2")

    assert load_vessel(str(path)).coefficients == load_vessel("bb2").coefficients
    assert load_vessel("bb2").text == path.read_text(encoding="utf-8")


def test_an_unknown_boat_is_told_the_nearest_and_all_names() -> None:
    text = complaint(lambda: load_vessel("remus"))

    assert "nearest is remus100" in text
    assert "bb2, remus100, sdv-mk9" in text


# What may be left out


def test_four_tables_are_enough_and_the_rest_is_named_as_defaulted() -> None:
    boat = small()

    assert boat.name == "boat"
    assert boat.coefficients["N_dr"] == -7.0e-3
    assert len(boat.coefficients) == 122
    assert len(boat.absent) == 120
    assert boat.coefficients["Z_w"] == 0.0
    assert {"run", "control_surfaces", "propulsion.bells_kn", "vessel.Ixy"} <= set(boat.defaulted)
    assert boat.compensation == {"modified": {}, "basic": {"Z_w": 1.75, "M_w": 0.89}}
    assert boat.compact.extra_terms == ()
    assert boat.autopilot is None


def test_a_table_given_in_part_is_completed() -> None:
    boat = small(("[propulsion]\n", "[control_surfaces]\nrate_deg_s = 3\n\n[propulsion]\n"))

    assert boat.surfaces.rate_deg_s == 3.0
    assert "control_surfaces.rudder_limit_deg" in boat.defaulted
    assert "control_surfaces.rate_deg_s" not in boat.defaulted


def test_coefficients_may_stand_in_one_table() -> None:
    boat = small(("[coefficients.X]", "[coefficients]"), ("[coefficients.N]", ""))

    assert boat.coefficients == small().coefficients


def test_thrust_rows_are_sorted_by_falling_eta() -> None:
    row = "[[propulsion.sets]]\neta_min = 0.5\na = -0.0005\nb = -0.0035\nc = 0.004\n\n"
    boat = small(("[coefficients.X]", f"{row}[coefficients.X]"))

    assert [row.eta_min for row in boat.thrust.ahead] == [0.5, 0.0, -100.0]
    assert boat.remarks == ()


def test_thrust_that_does_not_balance_at_self_propulsion_is_remarked() -> None:
    (remark,) = small(("c = 0.003", "c = 0.0031")).remarks

    assert remark.startswith("boat.toml: [propulsion] sets: a + b + c = 0.0001")


def test_what_a_file_leaves_out_about_going_astern_follows_from_the_rows_ahead() -> None:
    ahead, (back, check) = small().thrust

    assert [(row.eta_min, row.a, row.b) for row in ahead] == [
        (0.0, -0.001, -0.002),
        (-100.0, -0.001, 0.0),
    ]
    assert ahead[1].c == pytest.approx(-0.77 * 0.003)
    assert (back.a, back.c, check.c) == pytest.approx((0.0012, ahead[1].c, 0.003))
    assert (
        small(("[propulsion]", "[envelope]\ndrag_astern = 2\n[propulsion]")).thrust.astern[0].a
        == 0.002
    )


ASTERN = """c = 0.003
[[propulsion.sets]]
eta_min = -99.0
a = -0.001
b = 0.0
c = -0.002
[[propulsion.sets]]
going = "astern"
eta_min = 0.0
a = 0.0012
b = 0.0
c = -0.002
[[propulsion.sets]]
going = "astern"
eta_min = -99.0
a = 0.0012
b = 0.0
c = 0.003
"""


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        (
            "eta_min = 0.0\na = 0.0012",
            "eta_min = 0.0\na = 0.0014",
            "do not join at eta = 0, going astern: the thrust jumps by",
        ),
        (
            "a = -0.001\nb = 0.0\nc = -0.002",
            "a = -0.001\nb = 0.0\nc = -0.0022",
            "do not join at u = 0, turning astern",
        ),
        (
            "a = 0.0012\nb = 0.0\nc = 0.003",
            "a = 0.0012\nb = 0.0\nc = 0.0032",
            "do not join at u = 0, turning ahead",
        ),
        (
            "eta_min = -99.0\na = -0.001",
            "eta_min = -99.0\na = -0.0012",
            "6.7% of the bollard thrust: must be below 5%",
        ),
        ("eta_min = -99.0\na = 0.0012", "eta_min = 0.5\na = 0.0012", "takes two rows, or none"),
        (
            "a = -0.001\nb = 0.0\nc = -0.002",
            "a = -0.001\nb = 0.0\nc = 0.002",
            "drives the boat ahead on an astern bell: must be below 0, such as -0.77 of c ahead",
        ),
    ],
)
def test_thrust_rows_that_do_not_join_or_drive_the_wrong_way_are_refused(
    old: str, new: str, said: str
) -> None:
    assert small(("c = 0.003\n", ASTERN)).thrust.astern[1].c == 0.003
    assert ASTERN.count(old) == 1
    told = small_complaint(("c = 0.003\n", ASTERN.replace(old, new)))
    assert "boat.toml: [propulsion] sets: " in told
    assert said in told


@pytest.mark.parametrize(
    ("keys", "said"),
    [
        ("torque_limit_n_m = 1e5", "torque_limit_n_m = 100000: needs KQ as well"),
        ("shaft_power_w = 5e6\nKQ = [0.06, -0.03, -0.02]", "needs propeller_diameter as well"),
        (
            "torque_limit_n_m = 1e5\nKQ = [0, 0, 0]\npropeller_diameter = 5",
            "KQ[0] = 0: must be above 0",
        ),
    ],
)
def test_a_limit_of_torque_lacks_nothing(keys: str, said: str) -> None:
    assert said in small_complaint(("[propulsion]\n", f"[propulsion]\n{keys}\n"))


def broken_rows(eta: float, below: str) -> VesselFile:
    """Return the small boat with a second row ahead, below a break at ``eta``."""
    rows = f"[[propulsion.sets]]\neta_min = {eta}\na = -0.001\nb = -0.002\nc = 0.003\n"
    return small(
        ("[[propulsion.sets]]\neta_min = 0.0\na = -0.001\nb = -0.002\nc = 0.003\n", rows + below)
    )


def test_rows_may_break_anywhere_where_they_join() -> None:
    """At eta = 0.5 the row above makes -0.00125; the rows below are to make that as well."""
    row = "[[propulsion.sets]]\neta_min = 0.0\na = {}\nb = {}\nc = 0.0\n"
    assert broken_rows(0.5, row.format(-0.001, -0.0005)).remarks == ()
    to_three_digits = broken_rows(0.5, row.format(-0.001, -0.000501))
    assert to_three_digits.remarks == ()
    (seen,) = broken_rows(0.5, row.format(-0.001, -0.0006)).remarks
    assert "do not join at eta = 0.5, going ahead: the thrust jumps by " in seen
    assert "kN, 1.7% of the bollard thrust" in seen
    with pytest.raises(ConfigError, match=r"eta = 0.5, going ahead.* kN, 10.0% .* below 5%"):
        broken_rows(0.5, row.format(-0.0013, -0.0005))


def test_documentary_tables_and_keys_may_say_anything() -> None:
    free = 'note = "x"\n[[propulsion.sets]]\nstatus = "y"'
    boat = small(
        ("[[propulsion.sets]]", free),
        ("[fluid]", "[source]\nany = [1, {b = 2}]\n\n[fluid]"),
    )

    assert boat.coefficients == small().coefficients


def test_autopilot_lists_are_read() -> None:
    autopilot = parse_vessel(SMALL + AUTOPILOT, PLACE).autopilot

    assert autopilot is not None
    assert autopilot.speed_kn == (3.0, 10.0, 20.0)
    assert autopilot.bow_integral == (0.3, 0.2, 0.1)
    assert autopilot.turning_rate_deg_s == 0.1


@pytest.mark.parametrize("gain", ["rudder_course", "rudder_yaw_rate"])
def test_a_gain_of_the_wrong_sign_is_named(gain: str) -> None:
    text = SMALL + AUTOPILOT.replace(f"{gain} = {RUDDER}", f"{gain} = {RISING}")
    told = complaint(lambda: parse_vessel(text, PLACE))

    assert f"[autopilot] {gain} = 0.3: has the wrong sign; with N_dr = -0.007" in told
    assert "must be below 0" in told


def test_compensation_and_extra_terms_are_read() -> None:
    text = (
        "\n[compact]\nextra_terms = ['N_rar']\n"
        "[compensation.modified]\nN_dr = 0.8\n[compensation.basic]\nZ_w = 1.75\nN_rar = 2\n"
    )
    boat = parse_vessel(SMALL + text, PLACE)

    assert boat.compact.extra_terms == ("N_rar",)
    assert boat.compensation == {"modified": {"N_dr": 0.8}, "basic": {"Z_w": 1.75, "N_rar": 2.0}}


def test_an_empty_compensation_table_is_not_filled_from_the_defaults() -> None:
    boat = parse_vessel(SMALL + "\n[compensation.basic]\n", PLACE)

    assert boat.compensation == {"modified": {}, "basic": {}}


# What is refused: (old text, new text, the whole message)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            "X_udot = -1.2e-3",
            "X_udto = -0.0012",
            "[coefficients.X] X_udto = -0.0012: no such coefficient; nearest is X_udot",
        ),
        (
            "X_udot = -1.2e-3",
            "Y_vdot = -0.01",
            "[coefficients.X] Y_vdot = -0.01: belongs under [coefficients.Y]",
        ),
        ("X_udot = -1.2e-3", "X_uu = 11", "[coefficients.X] X_uu = 11: must be -10 to 10"),
        ("length =", "lenth = 1\nlength =", "[vessel] lenth = 1: no such key; nearest is length"),
        ("X_udot = -1.2e-3", "a1 = 0.1", "[coefficients.X] a1 = 0.1: no such coefficient"),
        ("[fluid]", "[flud]\n[fluid]", "[flud]: no such table; nearest is fluid"),
        ("rho = 1025.0", "rho = true", "[fluid] rho = true: must be a number, 900 to 1100 kg/m3"),
        ("rho = 1025.0", "rho = nan", "[fluid] rho = nan: must be finite, 900 to 1100 kg/m3"),
        ("Ix = 5.23e7", "Ix = 0", "[vessel] Ix = 0: must be 1e-09 to 1e+13 kg m2"),
        (
            "cg = [0, 0, 0]",
            "cg = [71, 0, 0]",
            "[vessel] cg = [71.0, 0.0, 0.0]: lies further than L = 70.2 m from the origin",
        ),
        ("a = -0.001", "", "[propulsion.sets[0]] lacks a"),
        (
            "[[propulsion.sets]]",
            "[propulsion.sets]",
            '[propulsion] sets = {"eta_min": 0.0, "a": -0.001, "b": -0.002, "c": 0.003}: must',
        ),
        (
            "X_udot = -1.2e-3",
            "X_udot = 0.03",
            "[coefficients] X_udot = 0.03: must be below the boat's own 0.02492; an added",
        ),
        (
            "Ix = 5.23e7",
            "Ix = 5.23e7\nIxz = 3e8",
            "[vessel] Ixz = 3e+08 kg m2: must be below 2.674e+08 kg m2 either way, the root",
        ),
        ("[fluid]", "fluid = 3\n[notes]", "[fluid] must be a table, not 3"),
        ("[fluid]", 'kind = ""\n[fluid]', 'kind = "": must have 1 to 200 characters'),
        ("[fluid]", 'name = "a\\nb"\n[fluid]', 'name = "a\\nb": must be one line of text'),
        (
            "[fluid]",
            'schema = "abkowitz-3dof/1"\n[X]\n[fluid]',
            'schema = "abkowitz-3dof/1": must be gertler-hagen-2510/1',
        ),
        ("[fluid]", 'schema = "nomoto/1"\n[fluid]', 'schema = "nomoto/1": is a ship, not a boat'),
        ("length = 70.2", "length = 70.2\nlength = 71", "line 8: length is given twice"),
        ("[coefficients.X]", "[fluid]", "line 24: [fluid] is given twice"),
        ("g = 9.81", "g = ", "line 4: is not valid TOML: Invalid value"),
    ],
)
def test_one_wrong_thing_gets_one_line(old: str, new: str, message: str) -> None:
    text = small_complaint((old, new))

    assert text.startswith(f"boat.toml: {message}")
    assert "\n" not in text


@pytest.mark.parametrize(
    ("line", "ending"),
    [
        ("name = Lost in the fog  # of mine", '; a text has quotes: "Lost in the fog"'),
        ("name = True", "; write true"),
        ("name = no  # never", "; write false"),
        ("name = 66 ft", "; a number has no unit behind it: 66"),
        ("name = ", "Invalid value"),
    ],
)
def test_a_value_that_is_none_of_tomls_is_told_as_toml_writes_it(line: str, ending: str) -> None:
    assert small_complaint(("g = 9.81", line)).endswith(ending)


def test_a_decimal_comma_is_told_with_the_number_as_it_must_be_written() -> None:
    text = small_complaint(("g = 9.81", "g = 9,81"))

    assert text.startswith("boat.toml: line 4: is not valid TOML: ")
    assert text.endswith("; a number has a decimal point: 9.81")


@pytest.mark.parametrize(
    ("added", "message"),
    [
        ("[control_surfaces]\ntail = 'y'", 'tail = "y": must be x or cruciform'),
        (
            "[run]\nstart_speed_kn = 2",
            "start_speed_kn = 2 kn: must be within speed_range_kn, 3 to 20",
        ),
        ("[run]\nspeed_range_kn = [9, 4]", "speed_range_kn = [9.0, 4.0]: must ascend"),
        ("[compact]\nextra_terms = ['Z_vv']", 'extra_terms = ["Z_vv"]: must list some of X_vr'),
        ("[compact]\nextra_terms = ['X_vr', 'X_vr']", "must not name one twice"),
        (
            "[compensation.basic]\nN_rar = 2",
            "[compensation.basic] N_rar = 2: the compact set keeps no",
        ),
        ("[compensation.modfied]\nN_dr = 1", "no such equation set; nearest is modified"),
        ("[coefficients]\nX_udot = 0.1", "[coefficients] X_udot is given twice"),
        ("[coefficients.Q]\nX_uu = 0", "must be one of the tables X, Y, Z, K, M, N"),
        ("[envelope]\nhandover_deg = [55, 35]", "handover_deg = [55.0, 35.0]: must ascend"),
        ("[envelope]\ntail_y = 0.01", "[envelope] tail_y, tail_z: need tail_place as well"),
        ("[envelope]\nsail_lift = 0.01", "sail_lift: needs sail_lift_place as well"),
        ("[envelope]\nsail_y = 0.01", "sail_y, sail_added_mass: need sail_place as well"),
        (
            "[envelope]\nstrip_width = [0, 0, 0, 0, 0]",
            "strip_width = [0.0, 0.0, 0.0, 0.0, 0.0]: one",
        ),
        ("[envelope]\nstall_dge = [30, 30, 30]", "no such key; nearest is stall_deg"),
        (
            "[propulsion.bells_kn]\nahead_flank = 21",
            "ahead_flank = 21 kn: must be within max_ordered_speed_kn = 20 kn",
        ),
        (
            "[propulsion.bells_kn]\nahead_full = 9",
            "ahead_full = 9 kn: must be further ahead than ahead_standard",
        ),
        (
            "[propulsion.bells_kn]\nastern_full = 8",
            "astern_full = 8 kn: must be further astern than astern_two_thirds",
        ),
    ],
)
def test_one_wrong_addition_gets_one_line(added: str, message: str) -> None:
    text = complaint(lambda: parse_vessel(f"{SMALL}\n{added}\n", PLACE))

    assert text.startswith("boat.toml: ")
    assert message in text
    assert "\n" not in text


@pytest.mark.parametrize(
    ("added", "message"),
    [
        ("Z_w = [8e-4, 0.0, 0.0]", "Z_w = [0.0008, 0.0, 0.0]: has 3 entries, depth_m has 2"),
        ("M_w = [0.0, -8e-4]", "M_w = [0.0, -0.0008]: must end with 0, the effect ends at the"),
        ("M_W = [8e-4, 0.0]", "M_W = [0.0008, 0.0]: no such key; nearest is M_w"),
    ],
)
def test_the_slopes_of_a_surface_must_fit_its_depths(added: str, message: str) -> None:
    row = "\n[[free_surface.rows]]\nspeed_kn = {}\nZ_star = [-1e-3, 0.0]\nM_star = [0.0, 0.0]"
    tables = "[free_surface]\ndepth_m = [15.0, 35.0]\n{}" + row.format(3) + row.format(6)

    given = small_complaint(("[coefficients.X]", f"{tables.format(added)}\n[coefficients.X]"))

    assert message in given


def test_two_thrust_rows_must_not_start_at_the_same_eta() -> None:
    row = "[[propulsion.sets]]\neta_min = 0\na = 0\nb = 0\nc = 0\n\n[coefficients.X]"

    assert "eta_min = 0 is given twice" in small_complaint(("[coefficients.X]", row))


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("[3, 10, 20]", "[3, 10, 10]", "speed_kn = [3.0, 10.0, 10.0]: must ascend, none twice"),
        ("[3, 10, 20]", "[3, 10]", "stern_depth = [0.3, 0.2, 0.1]: has 3 entries, speed_kn has 2"),
        ("[3, 10, 20]", "[3]", "speed_kn = [3]: must be a list of 2 to 12 numbers"),
        ("bow_pitch = [0.3", "bow_pitch = ['a'", 'bow_pitch[0] = "a": must be a number'),
        (
            "bow_pitch = ",
            "bow_pich = ",
            "bow_pich = [0.3, 0.2, 0.1]: no such key; nearest is bow_pitch",
        ),
        (
            "course_rate_deg_s = [0.3",
            "course_rate_deg_s = [0",
            "course_rate_deg_s[0] = 0: must be 1e-06 to 10000",
        ),
        ("speed_integral = 0.01\n", "", "[autopilot] lacks speed_integral"),
    ],
)
def test_wrong_gain_lists_are_refused(old: str, new: str, message: str) -> None:
    assert old in AUTOPILOT
    text = SMALL + AUTOPILOT.replace(old, new)

    assert message in complaint(lambda: parse_vessel(text, PLACE))


def test_a_misspelt_necessary_key_is_both_unknown_and_missing() -> None:
    assert small_complaint(("length =", "lenght =")).splitlines() == [
        "boat.toml: [vessel] lenght = 70.2: no such key; nearest is length",
        "boat.toml: [vessel] lacks length",
    ]


def test_all_that_is_missing_is_told_at_once() -> None:
    text = complaint(lambda: parse_vessel("[vessel]\nlength = 5.0\n[propulsion]\n", PLACE))

    assert text.splitlines() == [
        "boat.toml: [fluid] lacks rho, g",
        "boat.toml: [vessel] lacks mass, weight, buoyancy, cg, cb, Ix, Iy, Iz",
        "boat.toml: [propulsion] lacks sets",
        "boat.toml: lacks the table [coefficients]",
    ]


# Whether the numbers fit together


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        # 70.2 m is 230.3 ft
        ("70.2", "230.3", "are these feet?"),
        ("mass = 4418825.0", "mass = 9741741.0", "is the mass in pounds?"),
        ("weight = 43348676.0", "weight = 9745217.0", "is the weight in pounds?"),
        ("weight = 43348676.0", "weight = 4418825.0", "is the weight in kilograms?"),
        ("weight = 43348676.0", "weight = 43348.0", "is the weight in kilonewtons?"),
        ("mass = 4418825.0", "mass = 4418.0", "is the mass in tonnes?"),
        (
            "buoyancy = 43348676.0",
            "buoyancy = 20e6",
            "must be weight = 4.33487e+07 N within a factor",
        ),
        # sqrt(1e8/4418825)/70.2 = 0.0678
        ("Iz = 1.367e9", "Iz = 1e8", "sqrt(Iz/mass)/L is 0.0678, must be 0.1 to 0.5"),
        ("= 70.2", "= 70.2\nmax_depth_m = 50", "60 m: must be at most max_depth_m = 50 m"),
        ("= 70.2", "= 70.2\ntest_depth_m = 50", "60 m: must be at most test_depth_m = 50 m of"),
        ("= 70.2", "= 70.2\ncollapse_depth_m = 50", "must be at most collapse_depth_m = 50 m of"),
    ],
)
def test_numbers_that_do_not_fit_together_are_told(old: str, new: str, told: str) -> None:
    assert told in small_complaint((old, new))


def test_weight_may_differ_from_mass_by_5_percent_and_not_by_6() -> None:
    assert small(("weight = 43348676.0", "weight = 45.4e6")).hull.weight == 45.4e6
    assert "within 5%" in small_complaint(("weight = 43348676.0", "weight = 45.95e6"))


def test_no_inertia_exceeds_the_sum_of_the_others() -> None:
    # Ix + Iz = 1.4193e9; 5 % more is 1.4903e9
    assert small(("Iy = 1.375e9", "Iy = 1.49e9")).hull.Iy == 1.49e9
    assert "Iy = 1.491e+09 kg m2: must not exceed" in small_complaint(("1.375e9", "1.491e9"))


def with_depths(keys: str) -> tuple[str, str]:
    """Return the replacement that gives SMALL these depths."""
    return "length = 70.2", f"length = 70.2\n{keys}"


def test_test_depth_is_the_deepest_that_may_be_ordered_where_the_file_gives_no_other() -> None:
    assert small(with_depths("test_depth_m = 250")).hull.max_depth_m == 250.0
    both = small(with_depths("test_depth_m = 250\nmax_depth_m = 200"))
    assert (both.hull.max_depth_m, both.hull.test_depth_m) == (200.0, 250.0)
    none = small().hull
    assert (none.max_depth_m, none.test_depth_m, none.collapse_depth_m) == (None, None, None)


def test_the_shipped_boats_have_test_depths_and_all_but_the_flooded_one_collapse() -> None:
    hulls = {name: load_vessel(name).hull for name in shipped_names("vessels")}
    assert {
        name: (hull.max_depth_m, hull.test_depth_m, hull.collapse_depth_m)
        for name, hull in hulls.items()
    } == {
        "bb2": (250.0, 250.0, 450.0),
        "remus100": (100.0, 100.0, 150.0),
        "sdv-mk9": (60.0, 60.0, None),
    }


@pytest.mark.parametrize(
    ("keys", "told"),
    [
        (
            "test_depth_m = 250\ncollapse_depth_m = 250",
            "collapse_depth_m = 250 m: must be deeper than test_depth_m = 250 m",
        ),
        (
            "test_depth_m = 250\nmax_depth_m = 251",
            "test_depth_m = 250 m: must be at least max_depth_m = 251 m",
        ),
        (
            "max_depth_m = 300\ncollapse_depth_m = 299",
            "collapse_depth_m = 299 m: must be deeper than max_depth_m = 300 m",
        ),
    ],
)
def test_depths_of_the_hull_that_do_not_fit_are_told_with_their_limit(keys: str, told: str) -> None:
    assert f"boat.toml: [vessel] {told}" in small_complaint(with_depths(keys)).splitlines()


# Files that are no configuration at all


def test_a_file_over_the_limit_is_refused_unread(tmp_path: Path) -> None:
    path = tmp_path / "large.toml"
    path.write_bytes(b"# " + b"x" * 10_000_000)

    assert "larger than the limit of 1000000 bytes" in complaint(lambda: load_vessel(str(path)))


def test_a_file_at_the_limit_is_read(tmp_path: Path) -> None:
    path = tmp_path / "full.toml"
    path.write_bytes(b"#" * 1_000_000)

    assert len(read_text(path)) == 1_000_000


def test_a_binary_file_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "binary.toml"
    path.write_bytes(b"\x7fELF\xff\xfe\x00")

    assert "is not UTF-8 text (byte 4 is wrong)" in complaint(lambda: load_vessel(str(path)))


def test_a_byte_order_mark_is_no_harm(tmp_path: Path) -> None:
    path = tmp_path / "windows.toml"
    path.write_bytes(b"\xef\xbb\xbf" + SMALL.replace("\n", "\r\n").encode())

    assert load_vessel(str(path)).coefficients == small().coefficients


def test_what_is_no_file_is_refused(tmp_path: Path) -> None:
    assert "is a directory" in complaint(lambda: load_vessel(f"{tmp_path}/"))
    assert "there is no such file" in complaint(lambda: load_vessel(str(tmp_path / "no.toml")))
    assert "cannot be read" in complaint(lambda: load_vessel("./a\0.toml"))
    assert "cannot be read" in complaint(lambda: load_vessel(f"./{'a' * 5000}.toml"))


def test_a_line_too_long_for_the_parser_is_refused_unparsed() -> None:
    text = f"{SMALL}\na{'.a' * 100_000} = 1"

    assert "line 30: is longer than 10000 characters" in complaint(
        lambda: parse_vessel(text, PLACE)
    )


def test_of_very_many_faults_only_the_first_are_told() -> None:
    text = "".join(f"k{i} = 1\n" for i in range(1000)) + SMALL
    lines = complaint(lambda: parse_vessel(text, PLACE)).splitlines()

    assert lines[0] == "boat.toml: k0 = 1: no such key"
    assert lines[-1] == "... and 980 more"
    assert len(lines) == 21


@pytest.mark.parametrize(
    "text",
    [
        "a = " + "[\n" * 50_000,
        "a = " + "1" * 5000,
        "[fluid]\nrho = 0x" + "f" * 9_000,
        "[vessel]\ncg = [0x" + "f" * 9_000 + "]",
        '"\\u0007\\n" = 1',
        "kind = 'a",
        "\r",
        "\0",
    ],
    ids=["deep", "long", "hexadecimal", "in a list", "control", "open", "return", "nul"],
)
def test_odd_text_is_refused_in_readable_lines(text: str) -> None:
    for line in complaint(lambda: parse_vessel(text, PLACE)).splitlines():
        assert line.startswith("boat.toml: ")
        assert len(line) < 250


@pytest.mark.parametrize(
    ("text", "what"),
    [
        (f"x{'.a' * 1000} = 1", "x.a.a"),
        (f"[x{'.a' * 1000}]\nb = 1", "x.a.a"),
        (f"[[x{'.a' * 21}]]\nb = 1", "x.a.a"),
        (f"x{'.a' * 10} = {'[' * 15}{']' * 15}", "x.a.a"),
        ("a = 1\nx = " + "9" * 5000, "line 2: a whole number has 19 digits"),
        ("x = 0x" + "f" * 5000, "x: a whole number has 19 digits"),
        ("x = [[1, -9223372036854775809]]", "x.0.1: a whole number has 19 digits"),
    ],
)
def test_what_no_reader_of_a_file_can_use_is_refused_before_it_by_file_and_key(
    text: str, what: str
) -> None:
    told = complaint(lambda: parse_toml(text, "any.toml"))

    assert told.startswith("any.toml: ")
    assert what in told
    assert len(told) < 200


def test_keys_tables_and_values_are_quoted_short_whatever_they_are() -> None:
    deep: list[object] = []
    for _ in range(5000):
        deep = [deep]
    told = Position("any.toml", "t" * 5000).wrong("k" * 5000, deep, "is wrong")

    assert len(told) < 250
    assert parse_toml(f"{'k' * 50}{'.a' * 18} = [9223372036854775807]", "any.toml")


@settings(max_examples=100)
@given(st.text(alphabet="[]{}=.,'\"#\n\\ abX_1e+-", max_size=60), st.integers(0, len(SMALL)))
def test_a_file_with_noise_in_it_loads_or_is_refused(noise: str, at: int) -> None:
    problems: list[str] = []
    with collecting(problems):
        assert len(parse_vessel(SMALL[:at] + noise + SMALL[at:], PLACE).coefficients) == 122

    assert all(text.startswith("boat.toml: ") and text.isprintable() for text in problems)


def test_json_has_null_for_what_is_no_number() -> None:
    found = {"a": [math.inf, (1.5, math.nan)], "b": {"c": -math.inf, "d": True, "e": "inf"}}

    assert json.loads(json_text(found)) == {
        "a": [None, [1.5, None]],
        "b": {"c": None, "d": True, "e": "inf"},
    }
