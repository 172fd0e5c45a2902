"""The page docs/report-1974.md: what of the 1974 report is here, as a command and as a test.

    python -m helpers.report_1974 > docs/report-1974.md

in the folder of the tests' helpers writes it; a test compares page, commands and tests.
"""

from typing import Final

from helpers.report_1969 import NEVER, Parts, Row, page_of

HEAD: Final = """# The report of 1974

<!-- Made by tests/helpers/report_1974.py; a test compares them, and looks every test up. -->

After this page you know where each part of the report of 1974 is, and how it is compared.

Astrom, Norrbin, Kallstrom and Bystrom, *The Identification of Linear Ship Steering Dynamics Using
Maximum Likelihood Parameter Estimation* (Lund 7431 / SSPA 1920-1): each of its programs, tables and
figures, what does the same here, and the test that compares. Its records have not survived, and its
figures are not in the copies that were read. A test therefore recomputes what was printed, or
simulates a ship of the report and identifies it again: S1 to S11 of `python -m tests.cases`.
Formulas were re-derived where the print is wrong or missing; an independent program's numbers stand
for them. [Identification](identification.md) tells how to use all this.
"""

STUDY: Final = "identify/test_study.py"
LIKELIHOOD: Final = "identify/test_likelihood.py"
SAMPLING: Final = "identify/test_sampling.py"
ESTIMATE: Final = "identify/test_estimate.py"
TABLES_TEST: Final = "identify/test_model_tables.py"
STEERED: Final = "identify/test_steered.py"
ALLOWED: Final = "identify/test_allowed_ships.py"
DECCA: Final = "identify/test_decca.py"
CASES: Final = "identify/test_cases.py"
RUNS: Final = "identify/test_runs.py"
OWN: Final = "identify/test_own_systems.py"
RESULTS: Final = "identify/test_results.py"
NONLINEAR: Final = "identify/test_nonlinear.py"
MODELLED: Final = f"{SAMPLING}::test_each_model_has_the_transfer_function_that_its_document_says"
FOUND: Final = f"{CASES}::test_a_ship_of_the_report_is_found_again"
SEEN: Final = f"{CASES}::test_what_the_report_saw_is_seen_again"
DERIVED: Final = f"{STEERED}::test_a_table_of_derivatives_gives_the_gains_printed_beside_it"
PLOTTED: Final = f"{STUDY}::test_a_plot_is_drawn"
SELFTEST: Final = "python -m tests.cases"

PROGRAMS: Final = (
    Row(
        "LISPID, abs ISYS 1",
        "measurement noise only: output error",
        "trainer identify FILE --noise output-error",
        f"{STUDY}::test_a_ship_is_found_within_three_deviations_by_every_noise_model",
    ),
    Row(
        "LISPID, abs ISYS 2",
        "state noise through a gain, loss V1",
        "trainer identify FILE --noise innovations",
        f"{LIKELIHOOD}::test_predictors_with_a_gain_have_exact_gradients",
    ),
    Row(
        "LISPID, abs ISYS 3",
        "state noise by covariances, loss V2, the likelihood",
        "trainer identify FILE --noise covariance",
        f"{LIKELIHOOD}::test_the_likelihood_is_that_of_statsmodels",
    ),
    Row(
        "LISPID, abs ISYS 4",
        "no estimation: simulate, screen residuals",
        "trainer identify FILE --simulate --reject 0.05",
        f"{RUNS}::test_nothing_is_estimated_where_only_a_simulation_is_wanted",
    ),
    Row(
        "LISPID, ISYS below 0",
        "the user's own system by discrete matrices",
        "trainer identify FILE --system FILE",
        f"{OWN}::test_matrices_of_one_step_are_found_too",
    ),
    Row(
        "SYST",
        "the user's own system, continuous",
        "trainer identify FILE --system FILE",
        f"{OWN}::test_a_system_in_a_file_is_found",
    ),
    Row(
        "SHIP: Model 1", "sway and yaw, 34 parameters", "trainer identify FILE --model 1", MODELLED
    ),
    Row(
        "SHIP: Model 2",
        "rudder to sway, 27 parameters",
        "trainer identify FILE --model 2",
        f"{STUDY}::test_a_ship_of_sway_alone_is_found_from_its_own_start_with_intervals",
    ),
    Row(
        "SHIP: Model 3",
        "rudder to yaw, 24 parameters",
        "trainer identify FILE --model 3",
        MODELLED,
    ),
    Row(
        "SHIP: ITH, SCAL",
        "which parameters are estimated, others fixed, scale factors",
        "[`[[parameters]]`](identification-keys.md#parameters) of a study",
        f"{ESTIMATE}::test_scale_changes_nothing_but_the_numbers_moved",
    ),
    Row(
        "MEAS",
        "instantaneous or integrating measurements",
        "[`measurement`](identification-keys.md#model) of a study",
        f"{SAMPLING}::test_readings_summed_over_the_interval_are_exact",
    ),
    Row(
        "ISAMP 1, 2, 3",
        "one interval, samples missing, intervals that vary",
        "trainer identify FILE",
        f"{LIKELIHOOD}::test_the_likelihood_is_that_of_the_filter_written_out",
    ),
    Row(
        "COSDY",
        "sampling with a time lag of the rudder",
        "trainer identify FILE",
        f"{SAMPLING}::test_a_rudder_that_lags_inside_the_interval_is_sampled_exactly",
    ),
    Row(
        "COSA, TRANS",
        "sampling of system and noise by series",
        "trainer identify FILE",
        f"{SAMPLING}::test_sampling_agrees_with_the_matrix_exponential_of_scipy",
    ),
    Row(
        "SGAIN",
        "the settled gain of the filter",
        "trainer identify FILE --noise innovations",
        "identify/test_alternatives.py::test_the_settled_gain_is_that_of_scipys_riccati_equation",
    ),
    Row(
        "SINT: NPRED1, NPRED2",
        "prediction over several steps",
        "[`predict_from`, `predict_to`](identification-keys.md#model) of a study",
        f"{LIKELIHOOD}::test_predictions_several_steps_ahead_have_exact_gradients",
    ),
    Row(
        "SINT: CHISQ",
        "outliers screened by chi-square",
        "[`reject`](identification-keys.md#model) of a study, a probability",
        f"{LIKELIHOOD}::test_an_outlier_is_rejected_and_moves_nothing",
    ),
    Row(
        "NUFLET",
        "quasi-Newton with difference gradients; here they are exact",
        "trainer identify FILE --method bfgs",
        f"{ESTIMATE}::test_every_minimiser_comes_to_the_same_minimum",
    ),
    Row(
        "POWBRE",
        "principal axes, no gradient; here Powell's directions",
        "trainer identify FILE --method direct",
        f"{ESTIMATE}::test_every_minimiser_comes_to_the_same_minimum",
    ),
    Row(
        "LOOP",
        "restarts of the minimiser",
        "[`restarts`](identification-keys.md#model) of a study",
        f"{ESTIMATE}::test_restarts_leave_a_shallow_minimum",
    ),
    Row(
        "LOOP 0",
        "simulate only",
        "trainer identify FILE --simulate",
        f"{RUNS}::test_nothing_is_estimated_where_only_a_simulation_is_wanted",
    ),
    Row(
        "LOOP -1",
        "print and plot data only",
        "trainer identify FILE --data-only",
        f"{RUNS}::test_a_record_is_shown_alone",
    ),
    Row(
        "LPAR, MSL",
        "parameters kept when time runs out",
        "trainer identify FILE --checkpoint FILE",
        f"{STUDY}::test_a_search_goes_on_from_its_checkpoint",
    ),
    Row(
        "GRASD",
        "gradient and second derivatives by differences; here of the exact gradient",
        "trainer identify FILE --html FILE",
        f"{ESTIMATE}::test_the_hessian_is_near_the_information",
    ),
    Row(
        "standard deviations, error 6",
        "by the second derivatives; eigenvalues and vectors of them",
        "trainer identify FILE --html FILE",
        "identify/test_alternatives.py::"
        "test_standard_deviations_are_those_of_the_likelihoods_own_curvature",
    ),
    Row(
        "RESLIS",
        "correlations, sign changes, distribution of residuals",
        "trainer identify FILE --plot FILE",
        "identify/test_armax.py::test_white_residuals_pass_and_coloured_ones_are_told",
    ),
    Row(
        "IOLISP",
        "all settings echoed",
        "trainer identify FILE --json",
        f"{STUDY}::test_the_page_tells_parameters_ship_stability_losses_and_residuals",
    ),
    Row(
        "NPRI 1, 2",
        "system and covariance matrices printed, initial and final",
        "trainer identify FILE --matrices",
        f"{RESULTS}::test_matrices_are_printed_when_asked",
    ),
    Row(
        "NPRI 3",
        "inputs, measurements, model outputs, errors, residuals by sample",
        "trainer identify FILE --csv FILE",
        f"{RESULTS}::test_a_csv_holds_the_series_and_leaves_a_missing_reading_empty",
    ),
    Row(
        "IPLOT, IYY",
        "inputs, measurements, model and residuals plotted",
        "trainer identify FILE --plot FILE",
        PLOTTED,
    ),
    Row(
        "IDPAC",
        "ARMAX models of rising order, AIC and F",
        "trainer identify FILE --armax",
        "identify/test_alternatives.py::test_an_armax_model_has_the_loss_and_deviations_of_statsmodels",
    ),
    Row(
        "IDPAC: data",
        "means, trends, dead time taken off",
        "[`[armax]`](identification-keys.md#armax) of a study",
        "identify/test_armax.py::test_dead_time_and_trend_are_taken_out",
    ),
    Row(
        "DECCON",
        "Decca lanes to places to sway velocity",
        "trainer ship decca FILE --csv FILE",
        f"{DECCA}::test_lanes_of_a_known_track_give_its_sway_velocity",
    ),
    Row(
        "DECCON: smoothing",
        "Spencer's 15 points",
        "trainer ship decca FILE --smooth",
        f"{DECCA}::test_spencers_points_smooth_as_published_and_keep_cubics",
    ),
    Row(
        "DECCON: rudder",
        "its output with the rudder, for LISPID",
        "trainer ship decca FILE --csv FILE",
        f"{DECCA}::test_the_track_with_a_rudder_is_a_record_to_identify",
    ),
    Row(
        "instead of Decca: GPS",
        "latitude and longitude to sway",
        "trainer identify FILE",
        "identify/test_track.py::test_a_track_gives_sway_and_yaw_rate",
    ),
    Row(
        "Monte Carlo",
        "ships drawn from what the record leaves open",
        "trainer identify FILE --plot FILE",
        f"{ALLOWED}::test_the_ships_allowed_hold_the_truth_and_the_estimate",
    ),
    Row(
        "PRBS",
        "a binary sequence for the rudder",
        "trainer ship prbs bb2 --amplitude 2",
        f"{TABLES_TEST}::test_sequences_are_those_of_the_shift_register",
    ),
    Row(
        "zig-zag",
        "a zig-zag planned: overshoot, period, reach",
        "trainer ship prbs bb2 --zigzag 10/10",
        "identify/test_design.py::test_a_zigzag_is_told_and_flown_again_by_its_orders",
    ),
)
THEORY: Final = (
    Row(
        "section 2.4: lever arms",
        "l_v, l_r, l_delta, and gains from them",
        "trainer ship steering bb2",
        f"{STEERED}::test_lever_arms_give_the_gains_of_their_table",
    ),
    Row(
        "section 2.4: stability",
        "l_r - l_v above zero",
        "trainer ship steering bb2",
        f"{TABLES_TEST}::test_a_ship_is_stable_when_yaw_acts_further_forward_than_sway",
    ),
    Row(
        "(2.7) to (2.9)",
        "transfer functions of heading and sway",
        "trainer ship steering bb2",
        f"{TABLES_TEST}::test_transfer_functions_and_time_constants_are_those_of_the_matrices",
    ),
    Row(
        "(2.12)",
        "steady turns bend, an unstable ship's spiral has a loop",
        "trainer ship steering FILE --plot FILE",
        f"{STEERED}::test_the_spiral_of_an_unstable_ship_has_the_loop_of_its_kappa",
    ),
    Row(
        "section 2.3: effective K', T'",
        "of a turn, by its own speed, beside K and T; Sea Splendour -1.63 and 3.62",
        "trainer boat manoeuvre turning-circle FILE --csv turn.csv && "
        "trainer ship steering FILE --record turn.csv",
        f"{STEERED}::test_a_turn_of_sea_splendour_has_the_gain_and_lag_of_table_9_2",
    ),
    Row(
        "section 2.8: K and T by Nomoto's method",
        "of A K Fernstrom's zig-zag, K -0.08 1/s and T 148.3 s as section 8 has them",
        "trainer boat manoeuvre zigzag-20 FILE --duration 1500 --csv zz.csv && "
        "trainer ship steering FILE --record zz.csv",
        f"{STEERED}::test_nomoto_s_method_finds_the_first_order_ship_that_the_report_found",
    ),
    Row(
        "section 2.8: against a likelihood",
        "both of one zig-zag, within a sixth",
        "trainer identify FILE --model nomoto1 --length 244 --at 14.2 --write-nomoto likely.toml "
        "&& trainer ship steering likely.toml --record FILE",
        f"{STEERED}::test_nomoto_s_method_and_a_likelihood_find_one_ship",
    ),
    Row(
        "phase plot of a zig-zag",
        "Bech and Smitt's T1', T2', T3': those of Tables 8.1 and 9.2 come back",
        "trainer ship steering FILE --record FILE",
        f"{STEERED}::test_the_phase_plot_of_a_zigzag_gives_the_time_constants_back",
    ),
    Row(
        "spirals",
        "Dieudonne's direct spiral, Bech's reversed one",
        "trainer boat manoeuvre spiral FILE && trainer boat manoeuvre reverse-spiral FILE",
        f"{STEERED}::test_the_spiral_of_an_unstable_ship_has_the_loop_of_its_kappa",
    ),
    Row(
        "kappa from a large manoeuvre",
        "the bend of a linear ship",
        "trainer identify FILE --kappa FILE",
        f"{NONLINEAR}::test_kappa_comes_back_from_a_manoeuvre",
    ),
    Row(
        "kappa with K and T",
        "all of (2.12) fitted together",
        "trainer identify FILE --kappa FILE --joint",
        f"{NONLINEAR}::test_kappa_and_the_linear_constants_come_back_together_from_two_records",
    ),
    Row(
        "H(r)",
        "Bech's function instead of a quadratic",
        "trainer identify FILE --bech FILE",
        f"{NONLINEAR}::test_h_comes_back_from_a_manoeuvre_of_an_unstable_ship",
    ),
    Row(
        "H(r) from a reversed spiral",
        "the same from steady turns",
        "trainer identify FILE --spiral FILE",
        f"{NONLINEAR}::test_h_comes_back_from_steady_turns_with_the_terms_that_it_has",
    ),
    Row(
        "linear and non-linear terms",
        "how large each is in the motion",
        "trainer identify FILE --bech FILE",
        f"{RESULTS}::test_the_report_tells_how_large_the_terms_are",
    ),
    Row(
        "section 3: what can be told apart",
        "parameters that one record cannot separate are named",
        "trainer identify FILE --model 1",
        f"{ESTIMATE}::test_what_cannot_be_told_apart_is_named_before_fitting",
    ),
    Row(
        "order tests",
        "F for losses; the likelihood ratio takes its place",
        "trainer identify FILE --model nomoto2 --against nomoto1",
        f"{ALLOWED}::test_a_model_is_tested_against_a_simpler_one_and_without_a_parameter",
    ),
    Row(
        "several runs",
        "common parameters of several records",
        "trainer identify FILE FILE",
        f"{RUNS}::test_two_records_are_fitted_by_one_command",
    ),
)
SHIPS: Final = (
    Row(
        "section 6: Atlantic Song by IDPAC",
        "ARMAX of order 2 from headings, S1",
        SELFTEST,
        "identify/test_armax.py::test_atlantic_song_is_found_as_exactly_as_the_report_says",
    ),
    Row("section 6: Atlantic Song by LISPID", "Model 3 of first order, S2", SELFTEST, FOUND),
    Row("section 7: Bore I", "a second-order ship from yaw rate alone, S4", SELFTEST, FOUND),
    Row(
        "section 8: A K Fernstrom",
        "an unstable ship looks stable in large zig-zags, S5",
        SELFTEST,
        SEEN,
    ),
    Row("section 9: Sea Splendour", "Model 1 with two logs, S6", SELFTEST, FOUND),
    Row("section 10: Compass Island", "Model 1 from a zig-zag 20/20, S7", SELFTEST, FOUND),
    Row(
        "section 10: Compass Island's sway",
        "Model 2 by itself, near a double root, S8",
        SELFTEST,
        f"{CASES}::test_time_constants_near_a_double_root_lie_in_the_intervals_of_their_draws",
    ),
    Row(
        "sections 8, 10, 11: N_v",
        "underestimated, and the more so the larger the helm, S10",
        SELFTEST,
        SEEN,
    ),
    Row(
        "section 5: Decca",
        "lanes to sway to Model 1, with smoothing and without, S11",
        SELFTEST,
        f"{CASES}::test_lanes_as_they_are_give_the_ship_and_smoothed_ones_another",
    ),
)
TABLES: Final = (
    Row("Table 4.1", "units of states and outputs", "trainer identify FILE --model 1", MODELLED),
    Row(
        "lever arms, section 2.4",
        "gains and time constants by lever arms",
        "trainer ship steering bb2",
        f"{STEERED}::test_lever_arms_give_the_gains_of_their_table",
    ),
    Row(
        "section 6: AIC and F",
        "seven numbers, to 0.1",
        "trainer identify FILE --armax",
        f"{TABLES_TEST}::test_the_reports_criteria_are_reproduced",
    ),
    Row(
        "Table 6.1: T and the gain",
        "T 29.4 s; its K is -0.074 1/s, the -0.055 printed is another model's",
        "trainer identify FILE --armax",
        f"{TABLES_TEST}::test_a_second_order_model_gives_the_reports_time_constant_without_wind",
    ),
    Row(
        "Table 6.2: the third-order model",
        "K' -2.38, T' 8.32, 1.11, 4.61: K -0.115 1/s, T 172.3, 22.9, 95.5 s",
        "trainer ship steering FILE",
        f"{STEERED}::test_the_third_order_model_has_the_numbers_of_table_6_2",
    ),
    Row(
        "(6.3), (6.4): zeros",
        "of A and B",
        "trainer identify FILE --armax",
        f"{TABLES_TEST}::test_zeros_of_the_reports_models_are_where_it_says",
    ),
    Row(
        "Table 8.1",
        "A K Fernstrom: [derivatives](steering.md#a-table-of-derivatives) to gains",
        "trainer ship steering FILE",
        DERIVED,
    ),
    Row(
        "Tables 9.1, 9.2",
        "Sea Splendour: derivatives to gains",
        "trainer ship steering FILE",
        DERIVED,
    ),
    Row(
        "Table 9.2: SI",
        "K -0.018 1/s, K_v 3.8 m/s, T1 92.5 and 155.6 s",
        "trainer ship steering FILE",
        f"{STEERED}::test_sea_splendour_has_the_gains_of_table_9_2_in_seconds",
    ),
    Row("Tables 9.3, 10.4", "noise, biases, initial states", SELFTEST, FOUND),
    Row(
        "Tables 10.1 to 10.3",
        "Compass Island: derivatives to gains",
        "trainer ship steering FILE",
        DERIVED,
    ),
    Row(
        "all tables: prime, bis, SI",
        "numbers of one ship in three systems",
        "trainer identify FILE",
        f"{TABLES_TEST}::test_prime_values_of_the_report_become_dimensional",
    ),
)
FIGURES: Final = (
    Row(
        "measured and model outputs",
        "with the rudder, one figure for a ship",
        "trainer identify FILE --plot FILE",
        PLOTTED,
    ),
    Row(
        "correlations of residuals",
        "of their own and with the rudder",
        "trainer identify FILE --plot FILE",
        PLOTTED,
    ),
    Row(
        "figures 6.3 to 6.5",
        "steps and pulses of drawn ships, with bands",
        "trainer identify FILE --plot FILE",
        f"{ALLOWED}::test_a_step_ends_at_the_gain_and_a_pulse_is_its_slope",
    ),
    Row(
        "figure 9.1",
        "one half predicts the other",
        "trainer identify FILE --check FILE",
        f"{STUDY}::test_one_part_of_a_record_predicts_another",
    ),
    Row(
        "spiral curves",
        "yaw rate over rudder, the loop",
        "trainer ship steering FILE --plot FILE",
        f"{STEERED}::test_the_spiral_is_drawn_with_its_fold",
    ),
    Row(
        "Bode figures",
        "gain and phase of the ships found, with bands",
        "trainer identify FILE --plot FILE",
        f"{RESULTS}::test_a_bode_figure_is_that_of_the_transfer_function",
    ),
)
LOST: Final = (
    Row("the five records", "Atlantic Song to Compass Island", f"{NEVER}: they are lost", ""),
    Row(
        "the figures themselves",
        "curves of records and of bands",
        f"{NEVER}: the copies read have no figures",
        "",
    ),
    Row(
        "section 6: K -0.055 1/s with T 29.4 s",
        "Atlantic Song",
        f"{NEVER}: the two are of different models, (6.2) and (6.3)",
        "",
    ),
    Row(
        "section 6: rounding asks for order 3",
        "Atlantic Song",
        f"{NEVER} seen: in simulations order 3 wins about as often without rounding; the lag "
        "inside an interval asks for it",
        "",
    ),
    Row(
        "section 7: T 15.6 s of first order",
        "Bore I",
        f"{NEVER}: T, T' and K, K' of the print contradict each other",
        "",
    ),
    Row(
        "section 8: the last K and T1",
        "A K Fernstrom",
        f"{NEVER}: so near neutral that the digits printed do not tell them; 1/K is compared",
        "",
    ),
    Row(
        "Tables 9.3, 10.4: all of theta13, 14, 15, 25",
        "biases estimated together",
        f"{NEVER}: no record separates them; here they are refused by name",
        "",
    ),
    Row(
        "losses and AIC of sections 7 to 10",
        "by their records",
        f"{NEVER}: they need the records",
        "",
    ),
)
PARTS: Final[Parts] = {
    "Programs": PROGRAMS,
    "Theory": THEORY,
    "Ships": SHIPS,
    "Tables": TABLES,
    "Figures": FIGURES,
    "What cannot be reproduced": LOST,
}


def page() -> str:
    """Return docs/report-1974.md."""
    return page_of(HEAD, PARTS)


if __name__ == "__main__":
    print(page(), end="")
