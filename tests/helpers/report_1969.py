"""The page docs/report-1969.md: what of the 1969 report is here, as a command and as a test.

    python -m helpers.report_1969 > docs/report-1969.md

in the folder of the tests' helpers writes it; a test compares page, commands and tests.
"""

from collections.abc import Mapping
from typing import Final, NamedTuple

from helpers.tables_1969 import (
    COMPUTER_DOLLARS,
    CORE_WORDS,
    HOST_WORDS,
    NEAR_SURFACE,
    NEAR_SURFACE_STARS_DEEP,
    TERMS_OF_TABLES,
    three_figures,
    words_in_parts,
)

NEVER: Final = "cannot be"
HEAD: Final = """# The report of 1969

<!-- Made by tests/helpers/report_1969.py; a test compares them, and looks every test up. -->

After this page you know where each part of the report of 1969 is, and how it is compared.

NAVTRADEVCEN 68-C-0050-1, "Advanced Submarine Systems Equations Study": each of its programs, tables
and figures, what does the same here, and the test that compares. The report's own boat is secret,
and so are its numbers: what a test compares with is an independent implementation of the report's
equations, a published result, or what the equations imply.
"""
COLUMNS: Final = ("what it is", "type", "the test that compares")


class Row(NamedTuple):
    """One program, table or figure of the report."""

    name: str
    what: str
    command: str  # or a page, or NEVER and why
    test: str  # FILE::NAME below tests/, "" where nothing compares


Parts = Mapping[str, tuple[Row, ...]]  # by their titles


def named_terms(table: str, motion: str) -> str:
    """Return how many coefficients one of the tables 6 and 8 names, in words."""
    necessary, rest = TERMS_OF_TABLES[table], TERMS_OF_TABLES[f"{table}, to be investigated"]
    return (
        f"{len(necessary)} {motion} coefficients that are necessary, and {len(rest)} to be "
        "investigated; [which](coefficients.md)"
    )


VECTORS: Final = "analysis/test_programs_vessel.py"
RUNS: Final = "analysis/test_programs_runs.py"
FLOWN: Final = (
    "analysis/test_manoeuvres.py::test_measures_are_those_of_an_independent_implementation"
)
POLYNOMIALS: Final = f"{VECTORS}::test_polynomials_and_roots_are_those_of_the_reference"
PROGRAMS: Final = (
    Row(
        "EB920",
        "full equations (1)-(7), 131 coefficients",
        "trainer run --headless --equations full --duration 15m --speed max "
        "--orders turn.txt --csv turn.csv",
        "core/test_trajectories.py::test_recorded_controls_give_the_recorded_trajectory",
    ),
    Row(
        "EB920: EVAL",
        "accelerations by the 6x6 solve (INVER2, MATMPY)",
        "trainer boat evaluate bb2 --equations full --rates exact < states.jsonl",
        "analysis/test_evaluate.py::test_vectors_of_an_independent_program_are_met",
    ),
    Row(
        "EB920: EVAL 1",
        "each acceleration from its own equation, others of the last cycle",
        "trainer boat evaluate bb2 --equations full --rates lagged < states.jsonl",
        "analysis/test_evaluate.py::test_vectors_of_an_independent_program_are_met",
    ),
    Row(
        "EB920: KUTTA",
        "Runge and Kutta, step fixed or variable",
        "trainer boat manoeuvre meander bb2 --integrator rkv",
        "core/test_integrators.py::test_variable_runge_kutta_keeps_its_tolerance",
    ),
    Row(
        "EB920: INTEG",
        "Euler, second-order Adams, a third formula",
        "trainer boat manoeuvre meander bb2 --integrator best2",
        "core/test_integrators.py::test_each_method_has_its_order",
    ),
    Row(
        "EB920: INTEG, further methods",
        "fourth-order Adams, and 22 methods listed",
        "seventeen by [name](engineer.md#methods-of-integration), others by coefficients; "
        "of the 22 six are known: four are here, and the trapezoid as a corrector",
        "analysis/test_check.py::test_every_named_method_has_its_order_once_it_has_a_past",
    ),
    Row(
        "EB920: INPUT",
        "the listing of all coefficients and constants",
        "trainer boat check bb2 --constants",
        f"{VECTORS}::test_a_listed_constant_is_the_one_that_is_flown",
    ),
    Row("EB920: CONTR", "schedules of rudder and planes", "trainer boat manoeuvre --list", FLOWN),
    Row(
        "ZC790",
        "the vertical plane alone, (8)-(11)",
        "trainer boat manoeuvre trim bb2 --equations longitudinal",
        "analysis/test_evaluate.py::test_longitudinal_is_full_for_motion_in_the_vertical_plane",
    ),
    Row(
        "EC780, modified",
        "the compact set (12)-(17), 60 coefficients, 0.5 s",
        "trainer boat manoeuvre turn bb2 --equations modified --trig report --controls once",
        FLOWN,
    ),
    Row(
        "EC780, basic",
        "three coefficients fewer, straight lines for sine and cosine, 1 s",
        "trainer boat manoeuvre turn bb2 --equations basic --trig report --step 1",
        FLOWN,
    ),
    Row(
        "EC790",
        "constants of the compact set, (18)",
        "trainer boat check bb2 --constants",
        f"{VECTORS}::test_the_compact_constants_are_those_of_both_sets",
    ),
    Row(
        "EC430",
        "weight and balance, limits over all fillings",
        "trainer report-1969 tanks bb2",
        f"{VECTORS}::test_the_reference_tanks_have_the_reference_balance_through_any_filling",
    ),
    Row(
        "EC470",
        "neutral angles, critical speed",
        "trainer report-1969 neutral bb2",
        f"{VECTORS}::test_the_flattest_neutral_flight_is_that_of_the_reference",
    ),
    Row(
        "EC470 near the surface",
        "neutral angles with Z_star and M_star of the depth",
        "trainer report-1969 neutral bb2 --depth 15",
        f"{VECTORS}::test_neutral_angles_near_the_surface_balance_its_force_and_moment",
    ),
    Row(
        "ZC300",
        "thrust less drag, acceleration",
        "trainer report-1969 thrust bb2",
        f"{VECTORS}::test_thrust_and_acceleration_are_those_of_the_reference",
    ),
    Row(
        "EC140",
        "cubic and roots of the vertical plane",
        "trainer report-1969 modes bb2",
        POLYNOMIALS,
    ),
    Row(
        "EC200",
        "quartic and roots of the horizontal plane",
        "trainer report-1969 modes bb2",
        POLYNOMIALS,
    ),
    Row(
        "EC320",
        "linear coefficients adjusted by mean v, w, p, q, r",
        "trainer report-1969 modes bb2 --mean-w 0.2 --mean-p 0.02",
        f"{VECTORS}::test_a_mean_angle_of_attack_changes_the_cubic_as_in_the_reference",
    ),
    Row(
        "EC140 near the surface",
        "roots where Z_star and M_star change with depth",
        "trainer report-1969 modes bb2 --depth 15",
        f"{VECTORS}::test_modes_near_the_surface_feel_how_its_force_changes_with_depth",
    ),
    Row(
        "EC310, EC120, EC150, EC330",
        "damped sinusoids fitted to a response, and where the fit starts",
        "trainer boat manoeuvre impulse bb2 --csv pulse.csv && trainer report-1969 fit pulse.csv",
        f"{RUNS}::test_a_boat_disturbed_answers_with_the_roots_of_its_characteristic_polynomial",
    ),
    Row(
        "ZC590, ZC691",
        "percent change of change of two runs",
        "trainer boat manoeuvre trim bb2 --csv full.csv && trainer boat manoeuvre trim bb2 "
        "--integrator rk4 --csv other.csv && "
        "trainer report-1969 compare full.csv other.csv",
        f"{RUNS}::test_percent_change_of_change_is_that_of_the_reference",
    ),
    Row(
        "the autopilot",
        "DS = DB = 0.008 (ZC-Z) + 3.5 theta + 0.012 z' + 2 q",
        "trainer boat manoeuvre turn bb2 --law literal",
        "core/test_autopilot.py::test_the_reports_law_is_the_reference_boats_law",
    ),
    Row(
        "the depth law beyond 50 ft",
        "the literal law does not limit the depth error",
        "trainer boat manoeuvre acceleration bb2 --law literal",
        "core/test_autopilot.py::test_the_literal_law_is_literal_beyond_50_feet_too",
    ),
    Row(
        "eta",
        "command speed over speed ahead, or over the whole speed U",
        "the first; the other by [`eta_speed`](vessel-files.md#eta-by-the-whole-speed)",
        "core/test_update.py::test_eta_is_by_speed_ahead_or_by_the_whole_speed",
    ),
    Row(
        "waves: the cosine sum",
        "ten bands of equal energy, five directions",
        "trainer boat sea sea-state-5",
        "core/test_seaway.py::test_the_cosine_series",
    ),
    Row(
        "waves: the filter",
        "white noise through a low pass and three high passes",
        "trainer boat sea sea-state-5",
        "core/test_seaway.py::test_the_filter_in_both_discrete_forms",
    ),
    Row(
        "duty cycle and size",
        "38 % and 19 % of real time, 8192 words",
        "trainer dev bench --seconds 2",
        "analysis/test_bench.py::test_duty_cycle_is_work_over_step_and_is_compared_with_1969",
    ),
)
KNOWN_TERMS: Final = (
    "core/test_terms.py::test_tables_6_8_and_10_of_1969_name_terms_and_the_compact_set_"
    "keeps_the_necessary"
)
TOLD_NEAR_SURFACE: Final = "; ".join(
    f"{speed:g} kn {three_figures(figures)} %" for speed, figures in NEAR_SURFACE.items()
)
TOLD_PRICES: Final = ", ".join(f"{name} {price:,}" for name, price in COMPUTER_DOLLARS.items())
TANKAGE: Final = "analysis/test_tankage.py"
SENSITIVE: Final = (
    "analysis/test_reduce.py::test_sensitivities_are_those_of_the_full_set_without_the_coefficient"
)
TABLES: Final = (
    Row(
        "Table 1",
        "intervals in which methods are stable",
        "trainer boat check bb2",
        "analysis/test_check.py::test_a_real_mode_has_the_published_interval",
    ),
    Row(
        "Tables 2, 3, 4",
        "the 131 coefficients by equation",
        "[coefficients](coefficients.md), `trainer boat check bb2 --constants`",
        "core/test_terms.py::test_the_page_has_every_term",
    ),
    Row(
        "Table 5",
        "overshoot by tankage, x_G and z_G alone moved, 5 and 25 knots, here 6 and 20: "
        "[change of change](sweeps.md#table-5-itself) of u, theta, z",
        "trainer report-1969 tanks bb2 --overshoots",
        f"{TANKAGE}::test_tankage_changes_an_overshoot_of_a_shipped_boat_by_the_figures_of_the_page",
    ),
    Row(
        "Table 5: its rules",
        "x_G known to 5 %, z_G to 15 %",
        "trainer boat sweep centre-of-gravity --plot centre.svg",
        "analysis/test_sweep_study.py::test_the_centre_of_gravity_is_known_well_enough_by_the_rules_of_1969",
    ),
    Row(
        "Table 6",
        named_terms("6", "longitudinal"),
        "trainer boat check bb2 --constants",
        KNOWN_TERMS,
    ),
    Row(
        "Tables 7, 9, 11",
        "what each coefficient does by itself",
        "trainer boat reduce bb2 --table",
        SENSITIVE,
    ),
    Row(
        "Table 8",
        named_terms("8", "lateral"),
        "trainer boat check bb2 --constants",
        KNOWN_TERMS,
    ),
    Row(
        "Table 10",
        f"{len(TERMS_OF_TABLES['10'])} coefficients of cross-coupling that are not zero",
        "trainer boat check bb2 --constants",
        KNOWN_TERMS,
    ),
    Row(
        "Table 12",
        "overshoot, deep coefficients against those of the surface, change of change of u, theta, "
        f"z: {TOLD_NEAR_SURFACE}",
        "trainer boat manoeuvre overshoot bb2 --speed 6 --csv deep.csv && "
        "trainer boat manoeuvre overshoot bb2 --speed 6 --depth 25 --csv near.csv && "
        "trainer report-1969 compare deep.csv near.csv --column u --column theta --column z "
        "--allow 100",
        "analysis/test_manoeuvres.py::test_an_overshoot_near_the_surface_differs_from_a_deep_one_"
        "by_the_figures_of_the_page",
    ),
    Row(
        "Table 13",
        "the same at 12 kn, Z_star and M_star left deep: "
        f"{three_figures(NEAR_SURFACE_STARS_DEEP)} %",
        "`trainer boat manoeuvre overshoot FILE --depth 25` with a "
        "[file of one's own](engineer.md#manoeuvres)",
        "analysis/test_manoeuvres.py::test_an_overshoot_with_z_star_and_m_star_left_deep_differs_"
        "by_the_figures_of_the_page",
    ),
    Row(
        "Table 14",
        "weights of the waves' directions, -60, -30, 0, 30, 60 deg: 0.0906, 0.4330, 0.5236 "
        "(printed 0.5325), 0.4330, 0.0906",
        "trainer boat sea sea-state-1",
        "analysis/test_sea_page.py::"
        "test_the_page_has_the_weights_of_table_14_for_a_sum_of_cosines_alone",
    ),
    Row(
        "Table 15",
        "constants of the wave filter at 45, 40 and 35 knots of wind: w_nL 0.39, 0.43, 0.48; d_L "
        "0.325 (printed 0.25 at 40); w_nH 0.21, 0.24, 0.27; d_H 0.707",
        'trainer boat sea FILE` with `generator = "filter-1969"',
        "analysis/test_sea_page.py::"
        "test_the_page_has_the_constants_of_table_15_for_the_filter_of_1969",
    ),
    Row(
        "Table 16",
        "words of 16 bits of the compact program: "
        f"{words_in_parts(CORE_WORDS)}; {words_in_parts(HOST_WORDS)}; here 1392 of the cycle and "
        "2855 of the whole tick, on x86-64 with AVX-512",
        "`python -m tests.bench --footprint`",
        "bench/test_parts.py::test_the_words_are_printed_beside_those_of_1969",
    ),
    Row(
        "Table 17",
        f"computers of 1969 and their prices, dollars: {TOLD_PRICES}; the whole trainer's hardware "
        "285 to 325 % of the computer",
        "trainer boat export-core core --vessel bb2",
        "boat/test_export.py::test_the_host_in_the_documents_compiles_and_steers",
    ),
    Row(
        "Tables 18, 19",
        "coefficients kept by the compact set, and those left out",
        "[coefficients](coefficients.md)",
        "core/test_terms.py::test_the_sets_are_of_the_table",
    ),
)
FIGURES: Final = (
    Row(
        "Figure 2",
        "axes and signs: [glossary](glossary.md)",
        "trainer boat evaluate bb2 --equations full --rates exact < states.jsonl",
        "boat/test_helm.py::test_right_rudder_turns_right_and_left_rudder_left",
    ),
    Row(
        "Figure 4",
        "overshoots at two speeds for three tankages: u, theta, z over time",
        "trainer report-1969 tanks bb2 --overshoots --plot overshoots.svg",
        f"{TANKAGE}::test_figure_4_draws_u_theta_and_z_slow_and_fast_by_tankage",
    ),
    Row(
        "Figures 6, 7",
        "the points compared: largest change of pitch and depth, largest and steady heel",
        "trainer boat manoeuvre turn bb2 --csv full.csv && "
        "trainer boat manoeuvre turn bb2 --integrator rk4 --csv other.csv && "
        "trainer report-1969 compare full.csv other.csv --plot points.svg",
        f"{RUNS}::test_percent_change_of_change_is_that_of_the_reference",
    ),
    Row(
        "Figure 5",
        "the angle of attack, steady",
        "trainer report-1969 modes bb2",
        f"{VECTORS}::test_a_mean_angle_of_attack_changes_the_cubic_as_in_the_reference",
    ),
    Row(
        "Figures 1, 3",
        "block diagrams of EB920 and ZC790",
        "[who calls whom](architecture.md#who-calls-whom)",
        "test_structure.py::test_the_block_diagram_says_who_calls_whom",
    ),
    Row(
        "Figure 8",
        "400 s of the cosine sea, a point each second, in per cent of its largest",
        "trainer boat sea sea-state-5 --plot sea.svg",
        "analysis/test_sea_page.py::test_a_plot_has_two_series_the_spectrum_and_the_suction",
    ),
    Row(
        "550 graphs of manoeuvres",
        "full against compact: meanders, overshoots, turns, accelerations",
        "trainer boat guide FILE",
        "analysis/test_guide.py::test_the_page_stands_alone_and_its_chapters_are_linked",
    ),
    Row(
        "the contract's programme",
        "40 overshoots, 15 turns, three sets",
        "trainer boat guide FILE --programme 1969",
        "analysis/test_guide.py::"
        "test_the_programme_of_1969_has_its_forty_overshoots_and_fifteen_turns",
    ),
    Row(
        "section V: the guide of a trainer",
        "14 manoeuvres: meanders, one at the largest damping ratio (7.5 kn, there about 7), "
        "overshoots, turns, an acceleration",
        "trainer boat guide FILE --programme trainer",
        "analysis/test_guide.py::test_the_programme_of_a_trainer_is_what_section_v_asks",
    ),
    Row(
        "a run over time",
        "chosen columns of one run",
        "trainer boat manoeuvre meander bb2 --csv m.csv && trainer export m.csv --plot m.svg "
        "--column theta --column z",
        f"{RUNS}::test_columns_of_a_run_share_a_panel_in_degrees_as_asked_for",
    ),
    Row(
        "an acceleration",
        "planes, pitch, speed, pitch rate and depth over time",
        "trainer boat manoeuvre acceleration bb2 --csv a.csv && trainer export a.csv --plot a.svg "
        "--column delta_s,delta_b --column theta --column u --column q --column z",
        f"{RUNS}::test_the_charts_of_an_acceleration_are_drawn_from_its_run",
    ),
    Row(
        "page 92: overshoot pitch over speed",
        "the planesman's first chart",
        'trainer boat sweep overshoots --plot pitch.svg --measure "overshoot angle"',
        "analysis/test_sweep_study.py::test_a_grid_is_drawn_over_each_variable",
    ),
    Row(
        "page 92: depth change over pitch",
        "the planesman's second chart",
        'trainer boat sweep overshoots --plot depth.svg --measure "depth change"',
        "analysis/test_sweep_study.py::test_a_grid_is_drawn_over_each_variable",
    ),
    Row(
        "neutral angles over speed",
        "by either pair of planes, critical speeds marked",
        "trainer report-1969 neutral bb2 --plot neutral.svg",
        "analysis/test_programs_commands.py::"
        "test_the_curve_of_neutral_flights_goes_through_the_table",
    ),
    Row(
        "roots over speed",
        "the root locus",
        "trainer report-1969 modes bb2 --plot modes.svg",
        POLYNOMIALS,
    ),
    Row(
        "the spectra of the waves",
        "energy by frequency, of spectrum and filter",
        "trainer boat sea sea-state-5 --plot sea.svg",
        "core/test_seaway.py::test_the_shape_of_the_analogue_filter",
    ),
)
PARTS: Final[Parts] = {"Programs": PROGRAMS, "Tables": TABLES, "Figures": FIGURES}


def rows_of(parts: Parts) -> tuple[Row, ...]:
    """Return every row of a page."""
    return tuple(row for part in parts.values() for row in part)


def command_cell(command: str) -> str:
    """Return what to type, or a page, or why there is nothing."""
    return f"`{command}`" if command.startswith("trainer ") else command


def comparison_cell(test: str) -> str:
    """Return the name of a test as a sentence, and its file."""
    if not test:
        return "none"
    file, name = test.split("::")
    return f"{name.removeprefix('test_').replace('_', ' ')} (`{file}`)"


def page_of(head: str, parts: Parts) -> str:
    """Return a page about a report: its head, and a table for each of its parts."""
    lines = [head]
    for title, part in parts.items():
        lines += [f"## {title}\n", f"| | {' | '.join(COLUMNS)} |", "|---|---|---|---|"]
        for row in part:
            cells = (row.name, row.what, command_cell(row.command), comparison_cell(row.test))
            lines.append(f"| {' | '.join(cells)} |")
        lines.append("")
    return "\n".join(lines)


def page() -> str:
    """Return docs/report-1969.md."""
    return page_of(HEAD, PARTS)


if __name__ == "__main__":
    print(page(), end="")
