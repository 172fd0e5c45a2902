"""A boat fitted to made trials: prior, records, search, file and report."""

import csv
from collections.abc import Callable
from dataclasses import replace
from functools import cache, partial
from pathlib import Path

import numpy as np
import pytest
from helpers.boat_trials import estimated_boat, made_trial, write_csv

from trainer.analysis.estimate.uncertainty import (
    LINEAR_TERMS,
    TWIN_COEFFICIENTS,
    drawn_fit,
    filed_estimate,
    filed_fit,
)
from trainer.config.boat.vessel import load_vessel, read_vessel
from trainer.config.files import ConfigError, parse_toml
from trainer.identify.boat import figures, fit, page, search, sheet
from trainer.identify.boat.filter import CHANNEL_NAMES
from trainer.identify.boat.fitted_file import fitted_text
from trainer.identify.boat.instruments import instruments_of
from trainer.identify.boat.motion import CONTROL_PLACES, STATE, STATE_NAMES
from trainer.identify.boat.noise import SLOW_KINDS, slow_deviations
from trainer.identify.boat.prior import Knowledge, Prior, read_prior
from trainer.identify.boat.regressors import PARAMETER_NAMES
from trainer.identify.boat.report import (
    VERDICT_WORDS,
    ChannelFit,
    RecordFit,
    SlowState,
    record_warnings,
    report_fit,
)
from trainer.identify.boat.trial import (
    Instruments,
    Trial,
    find_wrong_units,
    read_trial,
    trial_problems,
    without_unflown,
)
from trainer.identify.boat.vessel import FittedVessel
from trainer.identify.fitting.minimise import SearchOptions, SearchResult
from trainer.units import DEGREE

TRUE_DRAW = 7


@pytest.fixture(scope="session")
def own(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the file of an estimated boat."""
    return estimated_boat(tmp_path_factory.mktemp("boat"))


@cache
def prior_of(path: Path) -> Prior:
    return read_prior(str(path))


@cache
def fitted(path: Path) -> tuple[search.SearchEnd, tuple[float, ...]]:
    """Return a fit of two trials of a boat drawn from the prior, and the truth."""
    prior = prior_of(path)
    truth = prior.draw(TRUE_DRAW)
    trials = [made_trial(prior.vessel, truth, seed=seed) for seed in (1, 2)]
    return search.fit_trials(prior, trials), tuple(truth)


def test_the_prior_is_the_estimates_draws_linearised(own: Path) -> None:
    prior = prior_of(own)
    made = filed_estimate(prior.vessel.file, prior.tables)
    assert prior.common == 16
    for name, sd in zip(PARAMETER_NAMES, prior.sd, strict=True):
        if name in made.sd and name not in LINEAR_TERMS and name[0] not in "abcz":
            first = TWIN_COEFFICIENTS.get(name, name)
            assert sd == pytest.approx(made.sd[first], rel=1e-9), name
    for twin, key in TWIN_COEFFICIENTS.items():
        rows = prior.root[[PARAMETER_NAMES.index(name) for name in (twin, key)]]
        assert (rows[0] == rows[1]).all()


@pytest.mark.long
def test_draws_of_small_deviates_go_with_the_estimates_own(own: Path) -> None:
    prior = prior_of(own)
    made = filed_estimate(prior.vessel.file, prior.tables)
    ours = np.array([prior.draw(number) for number in range(1, 41)])
    theirs = [made.draw(number) for number in range(1, 41)]
    for name in ("N_v", "N_r", "Y_v", "M_w"):
        j = PARAMETER_NAMES.index(name)
        spread = np.std([row[name] for row in theirs])
        assert np.std(ours[:, j]) == pytest.approx(spread, rel=0.4), name


def test_a_boat_without_deviations_is_no_prior() -> None:
    with pytest.raises(ConfigError, match=r"has no deviations.*trainer boat estimate"):
        read_prior("bb2")


def test_what_keeps_its_sign_keeps_it_in_draws() -> None:
    values = np.ones(len(PARAMETER_NAMES))
    known = Knowledge(values, 5.0 * np.eye(len(values)))
    drawn = known.draw(3)
    j = PARAMETER_NAMES.index("Y_v")
    assert (drawn < 0.0).any()
    assert all(known.draw(n)[j] >= 0.1 for n in range(1, 30))


@pytest.mark.long
def test_a_fit_settles_near_the_truth(own: Path) -> None:
    found, truth = fitted(own)
    assert found.found.converged
    moving = found.prior.sd > 0.0
    off = (np.array(truth) - found.posterior.values)[moving] / found.posterior.sd[moving]
    assert np.mean(np.abs(off) < 1.96) > 0.85
    assert (found.posterior.sd <= found.prior.sd * (1.0 + 1e-9)).all()
    assert np.count_nonzero(found.learned < 0.5) > 10
    for one in found.passes:
        chi = np.nanmean(one.innovations**2 / one.variances)
        assert 0.9 < chi < 1.1


@pytest.mark.long
def test_a_fit_has_the_same_bits_again(own: Path) -> None:
    prior = prior_of(own)
    trial = made_trial(prior.vessel, prior.draw(TRUE_DRAW), count=120)
    few = SearchOptions(2)
    first, second = (search.fit_trials(prior, [trial], few) for _ in range(2))
    assert (first.posterior.values == second.posterior.values).all()
    assert (first.posterior.root == second.posterior.root).all()


@pytest.mark.long
def test_a_search_that_is_stopped_keeps_its_best(own: Path) -> None:
    prior = prior_of(own)
    trial = made_trial(prior.vessel, prior.draw(TRUE_DRAW), count=120)

    def stop(found: SearchResult) -> None:
        if found.steps == 2:
            raise KeyboardInterrupt

    stopped = search.fit_trials(prior, [trial], SearchOptions(25, stop))
    assert not stopped.found.converged
    assert "stopped" in stopped.found.doubt
    assert np.abs(stopped.found.theta).max() > 0.0


@pytest.mark.long
def test_a_fitted_boat_is_a_vessel_file_and_the_next_prior(own: Path, tmp_path: Path) -> None:
    found, _ = fitted(own)
    report = report_fit(found, [], draws=0)
    path = tmp_path / "fitted.toml"
    text, lacks = fitted_text(found, report, path)
    assert lacks == ""
    path.write_text(text, encoding="utf-8")
    file, again = load_vessel(str(path)), read_prior(str(path))
    assert file.autopilot is not None
    assert again.common == 0
    assert again.values == pytest.approx(found.posterior.values, rel=1e-9, abs=1e-15)
    assert again.sd == pytest.approx(found.posterior.sd, rel=1e-5, abs=1e-12)
    covariance = found.posterior.root @ found.posterior.root.T
    scale = np.where(found.posterior.sd > 0.0, found.posterior.sd, 1.0)
    error = (again.root @ again.root.T - covariance) / np.outer(scale, scale)
    assert np.abs(error).max() < 1e-6


@pytest.mark.long
def test_fits_chain(own: Path, tmp_path: Path) -> None:
    both, truth = fitted(own)
    prior = prior_of(own)
    first = search.fit_trials(prior, [made_trial(prior.vessel, np.array(truth), seed=1)])
    path = tmp_path / "first.toml"
    text, _ = fitted_text(first, report_fit(first, [], draws=0), path)
    path.write_text(text, encoding="utf-8")
    later = read_prior(str(path))
    second = search.fit_trials(later, [made_trial(prior.vessel, np.array(truth), seed=2)])
    assert second.found.converged
    moving = prior.sd > 0.0
    off = (second.posterior.values - both.posterior.values)[moving] / both.posterior.sd[moving]
    # not nearer: the noise is found anew, and a posterior is taken for normal
    assert np.sqrt(np.mean(off**2)) < 0.5
    assert np.median(second.posterior.sd[moving] / both.posterior.sd[moving]) < 1.05


@pytest.mark.long
def test_a_report_tells_figures_and_what_was_foretold(own: Path) -> None:
    found, truth = fitted(own)
    prior = found.prior
    other = made_trial(prior.vessel, np.array(truth), seed=3)
    report = report_fit(found, [other], draws=12)
    assert {row.verdict for row in report.coefficients} == set(VERDICT_WORDS)
    widths = [
        (after.sd or 0.0) / before.sd
        for before, after in zip(report.before, report.after, strict=True)
        if before.sd
    ]
    assert np.median(widths) < 0.5
    shares = report.held_out[0].explained
    assert all(share[0] > 90.0 for share in shares.values())
    assert sum(share[0] > share[1] for share in shares.values()) >= 3
    text = page.render(report)
    assert max(map(len, text.splitlines())) <= 110
    for words in ("FIT:", "HELD OUT", "turn at 15 deg: diameter [m]", "from the record"):
        assert words in text


def test_a_drawn_boat_that_is_far_out_widens_no_band(
    own: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    vessel, known = prior_of(own).vessel, Knowledge(*[np.zeros(2)] * 2)
    boats = [100.0, *np.random.default_rng(1).normal(100.0, 8.0, 99), 1000.0]

    def band(diameters: list[float]) -> figures.FigureBand:
        sailed = iter(diameters)
        with monkeypatch.context() as patch:
            patch.setattr(figures, "figures_of", lambda _: {("diameter", "m"): next(sailed)})
            patch.setattr(FittedVessel, "with_values", lambda self, _: self)
            patch.setattr(Knowledge, "draw", lambda *_: None)
            (one,) = figures.figure_bands(vessel, known, len(diameters) - 1, lambda _: None)
        return one

    found, without = band(boats), band(boats[:-1])
    assert found.sd is not None
    assert found.value is not None
    assert found.sd == pytest.approx(8.0, rel=0.15)
    assert found.sd == pytest.approx(without.sd, rel=0.12)
    assert band([*[100.0] * 80, *[120.0] * 20]).sd == pytest.approx(8.0, rel=0.02)  # no middle half
    assert (found.low, found.high) == (found.value - 1.96 * found.sd, 100.0 + 1.96 * found.sd)


@pytest.mark.long
def test_a_page_shows_bands_tracks_and_what_was_foretold(own: Path) -> None:
    found, truth = fitted(own)
    other = replace(made_trial(found.prior.vessel, np.array(truth), seed=3), source="<b>.csv")
    report = replace(report_fit(found, [other], draws=6), warnings=("wild: <look> here",))
    shown = sheet.html_page(found, [other], report)
    banded = [one for one in report.after if one.low is not None]
    assert len(banded) > 10
    assert shown.count(": bands before and after") == len(banded)
    for one in report.coefficients:
        assert one.name in shown
    assert shown.count("north [m] against east [m]") == 3
    assert "Foretold: &lt;b&gt;.csv" in shown
    assert '<p class="bad">wild: &lt;look&gt; here</p>' in shown
    assert "http" not in shown.partition("<svg")[0]
    assert shown == sheet.html_page(found, [other], report)


def test_a_track_leads_over_ground() -> None:
    """Half a circle: as far as its diameter, and square to where it began."""
    angle = np.linspace(0.0, np.pi, 2001)
    states = np.zeros((len(angle), len(STATE_NAMES)))
    states[:, STATE.U], states[:, STATE.PSI] = 2.0, angle
    track = sheet.track_of("boat", states, 0.5)
    diameter = 2.0 * 2.0 * 0.5 * len(angle) / np.pi
    assert track.x[-1] == pytest.approx(diameter, rel=1e-3)
    assert track.y[-1] == pytest.approx(0.0, abs=2e-3 * diameter)
    states[:, STATE.PSI], states[:, STATE.V] = 0.0, 1.0
    assert sheet.track_of("boat", states, 0.5).x[-1] == pytest.approx(0.5 * len(angle))


def test_a_strangers_record_is_read_with_its_units(own: Path, tmp_path: Path) -> None:
    prior = prior_of(own)
    turns = prior.vessel.file.propulsion.rps_per_mps
    made = made_trial(prior.vessel, prior.draw(TRUE_DRAW), count=150)
    read = read_trial(write_csv(tmp_path / "trial.csv", made, turns), prior.vessel)
    assert read.interval == pytest.approx(made.interval)
    assert read.inputs == pytest.approx(made.inputs, abs=1e-5)
    known = np.isfinite(made.readings)
    assert (np.isfinite(read.readings) == known).all()
    assert read.readings[known] == pytest.approx(made.readings[known], abs=1e-4)
    assert any("stern planes as stern [deg]" in words for words in read.columns)


def test_gaps_are_left_empty(own: Path, tmp_path: Path) -> None:
    prior = prior_of(own)
    made = made_trial(prior.vessel, prior.values, count=150)
    path = write_csv(tmp_path / "trial.csv", made, prior.vessel.file.propulsion.rps_per_mps)
    lines = path.read_text(encoding="utf-8").splitlines()
    path.write_text("\n".join(lines[:60] + lines[64:]) + "\n", encoding="utf-8")
    read = read_trial(path, prior.vessel)
    assert len(read.readings) == 150
    assert np.isnan(read.readings[59:63]).all()
    assert read.inputs[59:63] == pytest.approx(made.inputs[59:63], abs=2e-2)
    assert any("4 rows are lacking" in words for words in read.told)


def test_a_record_without_what_a_fit_needs_is_refused(own: Path, tmp_path: Path) -> None:
    prior = prior_of(own)
    path = write_csv(tmp_path / "trial.csv", made_trial(prior.vessel, prior.values), 0.2)
    with path.open(encoding="utf-8", newline="") as file:
        rows = [[*row[:4], *row[5:9]] for row in csv.reader(file)]
    path.write_text("\n".join(map(",".join, rows)) + "\n", encoding="utf-8")
    with pytest.raises(ConfigError) as wrong:
        read_trial(path, prior.vessel)
    assert "no column is taken for depth" in str(wrong.value)
    assert "no column is taken for the revolutions" in str(wrong.value)


@pytest.mark.parametrize(
    ("column", "words"),
    [
        (
            CONTROL_PLACES.RUDDER,
            "turns her to starboard (10 standard errors): turn the sign of rudder, or turn the",
        ),
        (CONTROL_PLACES.STERN, "raise her bow (6 standard errors): turn the sign of stern"),
    ],
)
def test_a_wrong_sign_is_refused(own: Path, column: int, words: str) -> None:
    prior = prior_of(own)
    made = made_trial(prior.vessel, prior.values)
    assert find_wrong_units(made, prior.vessel, {}) == ("", False)
    inputs = made.inputs.copy()
    inputs[:, column] *= -1.0
    assert words in find_wrong_units(replace(made, inputs=inputs), prior.vessel, {})[0]


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"interval": 3.0}, "a reading each 3 s"),
        ({"readings": np.full((60, len(CHANNEL_NAMES)), 50.0), "inputs": np.eye(60, 4)}, "60 rows"),
        ({"inputs": np.full((300, 4), 3.0)}, "no surface moves by 2 deg"),
    ],
)
def test_a_record_that_tells_nothing_is_refused(
    own: Path, changes: dict[str, object], words: str
) -> None:
    prior = prior_of(own)
    made = replace(made_trial(prior.vessel, prior.values), **changes)  # type: ignore[arg-type]
    assert any(words in problem for problem in trial_problems(made, prior.vessel))


def test_shallow_and_slow_water_is_refused(own: Path) -> None:
    prior = prior_of(own)
    made = made_trial(prior.vessel, prior.values)
    readings = made.readings.copy()
    readings[:, CHANNEL_NAMES.index("depth")] -= 118.0
    readings[:, CHANNEL_NAMES.index("speed")] = 0.1
    problems = " ".join(trial_problems(replace(made, readings=readings), prior.vessel))
    assert "surface is not in the model" in problems
    assert "fits are of boats ahead" in problems


def test_a_course_that_was_only_kept_tells_nothing_of_turning(own: Path) -> None:
    prior = prior_of(own)
    made = made_trial(prior.vessel, prior.values)
    inputs = made.inputs.copy()
    inputs[:, CONTROL_PLACES.RUDDER] = 0.1 * DEGREE
    kept = without_unflown(replace(made, inputs=inputs))
    assert not kept.has("heading")
    assert not kept.has("roll")
    assert kept.has("pitch")
    assert kept.told == ("course only kept: nothing learned of turning",)
    inputs[:, [CONTROL_PLACES.STERN, CONTROL_PLACES.BOW]] = 0.0
    still = without_unflown(replace(made, inputs=inputs))
    assert [name for name in CHANNEL_NAMES if still.has(name)] == ["speed"]


def test_a_turn_keeps_what_its_planes_tell(own: Path) -> None:
    """In a turn the planes hold against what the turn does; without it its forces are unknown."""
    prior = prior_of(own)
    made = made_trial(prior.vessel, prior.values)
    inputs = made.inputs.copy()
    inputs[:, [CONTROL_PLACES.STERN, CONTROL_PLACES.BOW]] = 0.0
    assert without_unflown(replace(made, inputs=inputs)).has("depth")


@pytest.mark.long
def test_a_boat_that_cannot_fly_the_record_is_told(own: Path) -> None:
    prior = prior_of(own)
    made = made_trial(prior.vessel, prior.values)
    values = prior.values.copy()
    values[PARAMETER_NAMES.index("a1")] = 5.0
    broken = replace(prior, values=values)
    with pytest.raises(ConfigError, match="does not fly this record"):
        search.fit_trials(broken, [made])


def test_all_is_read_before_anything_is_fitted(own: Path, tmp_path: Path) -> None:
    prior = prior_of(own)
    made = made_trial(prior.vessel, prior.values)
    good = write_csv(tmp_path / "good.csv", made, prior.vessel.file.propulsion.rps_per_mps)
    bad = tmp_path / "bad.csv"
    bad.write_text("t,rudder\n0,1\n1,2\n", encoding="utf-8")
    with pytest.raises(ConfigError, match=r"bad\.csv"):
        fit.open_trials(str(own), [good], [bad])


@pytest.mark.long
def test_a_sweep_draws_a_fitted_boat_by_its_fit(own: Path, tmp_path: Path) -> None:
    found, _ = fitted(own)
    path = tmp_path / "fitted.toml"
    path.write_text(fitted_text(found, report_fit(found, [], draws=0), path)[0], encoding="utf-8")
    file = load_vessel(str(path))
    tables = {**parse_toml(file.text, path.name), "coefficients": dict(file.coefficients)}
    known = filed_fit(file, tables)
    drawn = [
        FittedVessel(read_vessel(drawn_fit(known, tables, number), "", path)).values
        for number in range(1, 31)
    ]
    for name in ("Z_ds", "N_dr", "b1", "z_b"):
        j = PARAMETER_NAMES.index(name)
        spread = np.std([row[j] for row in drawn])
        assert spread == pytest.approx(found.posterior.sd[j], rel=0.4), name


@pytest.mark.long
def test_surfaces_logged_late_are_told_with_the_delay(own: Path) -> None:
    found, _ = fitted(own)
    assert search.find_delay(found) == 0.0
    late = tuple(one.hastened(-1.0) for one in found.trials)
    assert search.find_delay(search.fit_trials(found.prior, late)) == 1.0


@pytest.mark.long
def test_wild_readings_are_left_out(own: Path) -> None:
    prior = prior_of(own)
    made = made_trial(prior.vessel, prior.draw(TRUE_DRAW), count=200)
    readings, heading = made.readings.copy(), CHANNEL_NAMES.index("heading")
    readings[[60, 121, 180], heading] += [0.4, -0.3, 0.5]
    spoilt = replace(made, readings=readings)
    clean, found = (search.fit_trials(prior, [one]) for one in (made, spoilt))
    lost = np.isfinite(readings) & np.isnan(found.passes[0].innovations)
    assert np.argwhere(lost).tolist() == [[60, heading], [121, heading], [180, heading]]
    moving = prior.sd > 0.0
    off = (found.posterior.values - clean.posterior.values)[moving] / clean.posterior.sd[moving]
    assert np.abs(off).max() < 0.3
    report = report_fit(found, [], draws=0)
    assert any("wild readings are left out, 3 of heading" in words for words in report.warnings)


def test_an_ordered_angle_is_refused(own: Path) -> None:
    prior = prior_of(own)
    made = made_trial(prior.vessel, prior.values)
    inputs = made.inputs.copy()
    inputs[:, CONTROL_PLACES.RUDDER] = 0.35 * np.sign(inputs[:, CONTROL_PLACES.RUDDER])
    (problem,) = trial_problems(replace(made, inputs=inputs), prior.vessel)
    assert "rudder moves 40.1 deg in 0.5 s" in problem
    assert "give angles that stood" in problem


def trial_read(
    folder: Path, own: Path, change: Callable[[list[str]], list[str]], said: Instruments
) -> Trial:
    """Return a trial as read from a file whose lines were changed."""
    prior = prior_of(own)
    turns = prior.vessel.file.propulsion.rps_per_mps
    path = write_csv(folder / "trial.csv", made_trial(prior.vessel, prior.values), turns)
    lines = change(path.read_text(encoding="utf-8").splitlines())
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return read_trial(path, prior.vessel, said)


def test_repeated_times_are_left_out_and_told(own: Path, tmp_path: Path) -> None:
    read = trial_read(
        tmp_path, own, lambda lines: [*lines[:50], lines[49], *lines[50:]], Instruments()
    )
    assert len(read.readings) == 300
    assert any("1 rows repeat the time before them" in words for words in read.told)


def test_readings_that_are_too_rare_are_taken_where_that_is_asked_for_and_told(
    own: Path, tmp_path: Path
) -> None:
    def slow(times: float, lines: list[str]) -> list[str]:
        cut = [line.split(",", 1) for line in lines[1:]]
        return [lines[0], *(f"{times * float(t):.2f},{rest}" for t, rest in cut)]

    with pytest.raises(ConfigError, match=r"each 3 s: needs .*; --coarse takes up to 1\.2"):
        trial_read(tmp_path, own, partial(slow, 6.0), Instruments())
    read = trial_read(tmp_path, own, partial(slow, 6.0), instruments_of([], [], coarse=True))
    assert read.interval == pytest.approx(3.0)
    assert any("a reading each 3 s, in which the boat goes" in words for words in read.told)
    with pytest.raises(ConfigError, match="a reading each 60 s"):
        trial_read(tmp_path, own, partial(slow, 120.0), Instruments(coarse=True))


def test_a_gauge_that_stands_still_is_told(own: Path, tmp_path: Path) -> None:
    def clip(lines: list[str]) -> list[str]:
        cut = [line.split(",") for line in lines]
        for row in cut[100:140]:
            row[7] = "2.00000"
        return [",".join(row) for row in cut]

    told = trial_read(tmp_path, own, clip, Instruments()).told
    assert any("pitch stands still for 40 readings from 49.5 s on" in words for words in told)
    told = trial_read(tmp_path, own, list, Instruments()).told
    assert not any("stands still" in words for words in told)


def test_columns_and_gauges_are_taken_as_said(own: Path, tmp_path: Path) -> None:
    def rename(lines: list[str]) -> list[str]:
        return [lines[0].replace("depth [m]", "Keel").replace("pitch", "lean"), *lines[1:]]

    with pytest.raises(ConfigError, match="no column is taken for pitch"):
        trial_read(tmp_path, own, rename, Instruments())
    with pytest.raises(ConfigError, match=r"Keel for depth: .* say --columns depth=Keel:m, or :ft"):
        trial_read(tmp_path, own, rename, instruments_of(["depth=Keel"], []))
    plain = trial_read(tmp_path, own, list, Instruments())
    said = instruments_of(["depth=Keel:m", "pitch=lean"], ["pitch=1", "weight=0.01"], 20.0, 1.0)
    read = trial_read(tmp_path, own, rename, said)
    depth, pitch = CHANNEL_NAMES.index("depth"), CHANNEL_NAMES.index("pitch")
    lower = read.readings[:, depth] - plain.readings[:, depth]
    assert lower == pytest.approx(20.0 * np.sin(plain.readings[:, pitch]), abs=1e-6)
    assert read.inputs[10] == pytest.approx(plain.inputs[12])
    sizes = dict(zip(SLOW_KINDS, slow_deviations(prior_of(own).vessel, read), strict=True))
    assert sizes["pitch_error"] == pytest.approx(DEGREE)
    assert sizes["weight"] == 0.01
    assert sizes["roll_error"] == SLOW_KINDS["roll_error"].usual


@pytest.mark.parametrize(
    ("columns", "biases", "words"),
    [
        (["dept=z:m"], [], "no 'dept'; nearest is depth"),
        (["depth"], [], "say depth="),
        ([], ["pich=1"], "no 'pich'"),
        ([], ["pitch=one"], "is no number"),
        ([], ["pitch=0"], "must be above 0"),
    ],
)
def test_a_wrong_word_on_instruments_is_told(
    columns: list[str], biases: list[str], words: str
) -> None:
    with pytest.raises(ConfigError) as wrong:
        instruments_of(columns, biases)
    assert words in str(wrong.value).replace('"', "'")


def test_what_is_odd_of_records_is_said_once_a_kind_and_one_without_noise_as_that() -> None:
    def record(source: str, chi: float, lag: float, bias: float) -> RecordFit:
        channels = tuple(ChannelFit(name, 100, chi, lag, 0) for name in ("heading", "pitch"))
        slow = (SlowState("pitch_error", "rad", bias, 0.001, 0.002),)
        return RecordFit(source, "", 100, 1.0, (), (), channels, slow, {}, {})

    odd = [record("a.csv", 1.5, 0.4, 0.02), record("b.csv", 0.4, -0.3, -0.02)]
    exact = record("own.csv", 0.01, 0.9, 0.0)
    sizes, lags, biases = record_warnings(odd)
    assert "heading 1.50 (a.csv), pitch 1.50 (a.csv), heading 0.40 (b.csv)" in sizes
    assert "heading +0.40 (a.csv)" in lags
    assert "pitch -0.30 (b.csv)" in lags
    assert "a.csv; --bias pitch=1" in biases
    assert "pitch error -1.15 deg, usual 0.11 (b.csv" in biases
    (told,) = record_warnings([exact])
    assert told.startswith("without noise")
    assert "own.csv" in told
    assert list(record_warnings([record("clean.csv", 1.0, 0.0, 0.0)])) == []


def test_figures_beyond_the_records_are_told(own: Path) -> None:
    file = prior_of(own).vessel.file
    everything = dict.fromkeys(("u", "v/u", "w/u", "r L/u"), (-9.0, 9.0))
    assert list(figures.flown_outside(file, [everything])) == []
    to_one_side = {**everything, "r L/u": (-2.0, 0.0), "v/u": (0.0, 2.0)}
    assert list(figures.flown_outside(file, [to_one_side])) == []
    straight = {**everything, "r L/u": (-0.1, 0.0)}
    told = list(figures.flown_outside(file, [straight]))
    assert "turn at 25 deg (turning)" in told
    assert list(figures.flown_outside(file, [straight, everything])) == []


@pytest.mark.long
def test_planes_that_only_keep_the_depth_are_told(own: Path) -> None:
    found, _ = fitted(own)
    words = "no record flies the planes"
    assert not any(words in each for each in report_fit(found, [], draws=0).warnings)
    inputs = [one.inputs * [1.0, 0.1, 0.1, 1.0] for one in found.trials]
    kept = [replace(one, inputs=each) for one, each in zip(found.trials, inputs, strict=True)]
    report = report_fit(replace(found, trials=(*kept,)), [], draws=0)
    assert any(words in each for each in report.warnings)


@pytest.mark.long
def test_an_added_mass_of_the_wrong_sign_is_told(own: Path) -> None:
    found, _ = fitted(own)
    words = "added mass of the wrong sign"
    assert not any(words in each for each in report_fit(found, [], draws=0).warnings)
    values = found.posterior.values.copy()
    values[PARAMETER_NAMES.index("K_pdot")] = 2e-6
    turned = replace(found, posterior=replace(found.posterior, values=values))
    warnings = report_fit(turned, [], draws=0).warnings
    assert any(each.startswith("K_pdot +2e-06: " + words) for each in warnings)


def test_units_of_figures_are_those_of_their_measures(own: Path) -> None:
    for sailed, manoeuvre, flight in figures.sail_figures(prior_of(own).vessel.file):
        assert flight is not None
        units = {one.name: one.unit for one in manoeuvre.measures(flight)}
        for measure, (_, unit) in sailed.measures.items():
            assert units[measure] == unit


def with_fins(off: tuple[float, float, float, float]) -> Callable[[list[str]], list[str]]:
    """Return what gives a file four fins for rudder and stern planes, each ``off`` [deg]."""

    def change(lines: list[str]) -> list[str]:
        heads = ",".join(f"fin {number} [deg]" for number in (1, 2, 3, 4))
        made = [f"time [s],{heads},{lines[0].split(',', 3)[3]}"]
        for line in lines[1:]:
            time, rudder, stern, rest = line.split(",", 3)
            level, upright = float(rudder), float(stern)
            signs = ((1, -1), (1, 1), (-1, 1), (-1, -1))
            angles = (a * level + b * upright for a, b in signs)
            fins = (f"{fin + more:.5f}" for fin, more in zip(angles, off, strict=True))
            made.append(",".join([time, *fins, rest]))
        return made

    return change


def test_four_fins_of_an_x_tail_are_rudder_and_stern_planes(own: Path, tmp_path: Path) -> None:
    plain = trial_read(tmp_path, own, list, Instruments())
    read = trial_read(tmp_path, own, with_fins((0.0, 0.0, 0.0, 0.0)), Instruments())
    assert read.inputs == pytest.approx(plain.inputs, abs=1e-6)
    assert not any("deg off" in words for words in read.told)


@pytest.mark.parametrize(
    ("off", "words"),
    [
        ((0.0, -2.0, 0.0, 0.0), "fin 2 or 4 reads -2 deg off"),
        ((0.0, 0.0, -2.0, 0.0), "fin 1 or 3 reads -2 deg off"),
        ((4.0, 4.0, 4.0, 4.0), "are they numbered and signed as x_plane_mix"),
    ],
)
def test_fins_that_do_not_fit_together_are_told(
    own: Path, tmp_path: Path, off: tuple[float, float, float, float], words: str
) -> None:
    read = trial_read(tmp_path, own, with_fins(off), Instruments())
    assert any(words in told for told in read.told)


def test_a_record_without_rudder_is_told_of_fins(own: Path, tmp_path: Path) -> None:
    def three(lines: list[str]) -> list[str]:
        made = with_fins((0.0, 0.0, 0.0, 0.0))(lines)
        return [line.replace("fin 4", "other") for line in made]

    with pytest.raises(ConfigError, match=r"rudder: call it .* all four fins of an X-tail"):
        trial_read(tmp_path, own, three, Instruments())
