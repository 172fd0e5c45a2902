"""Published figures: their file, their verdicts, their uncertainty, and the pages about them."""

import json
import math
import re
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

from trainer.analysis.guide import contents, judged_page, trials, uncertainty, validation, verdicts
from trainer.analysis.guide import page as guide_page
from trainer.analysis.guide.contents import GuideContents, leaves, write_guide
from trainer.analysis.guide.page import render
from trainer.analysis.guide.programme import fly_boat, fly_task, guide_legs
from trainer.analysis.guide.trials import (
    Figure,
    Published,
    load_published,
    numbers_digest,
    trials_path,
)
from trainer.analysis.guide.validation import FigureRow
from trainer.analysis.guide.verdicts import Validity
from trainer.analysis.manoeuvres.turns import Turn
from trainer.analysis.manoeuvres.vehicle import PORT
from trainer.cli.workshop.guide import guide, manoeuvre
from trainer.config.boat.vessel import VesselFile, load_vessel
from trainer.config.files import ConfigError, shipped_names
from trainer.console import app

MADE = "2026-01-01 00:00:00 UTC"
SHIPPED = [name for name in shipped_names("trials") if name in shipped_names("vessels")]


def published_of(name: str) -> tuple[VesselFile, Published]:
    """Return a shipped boat and its published figures."""
    file = load_vessel(name)
    return file, load_published(trials_path(file) or Path())


@pytest.fixture(scope="module")
def book() -> GuideContents:
    """Return a guide of BB2 with one leg, and all published figures."""
    file = load_vessel("bb2")
    leg = next(leg for leg in guide_legs(file) if leg.name == "turn")
    return write_guide(file, [leg], MADE, 1, lambda: None)


@pytest.fixture(scope="module")
def page(book: GuideContents) -> str:
    return guide_page.html_page(book, None)


# --- shipped figures


@pytest.mark.parametrize("name", SHIPPED)
def test_no_number_of_a_shipped_boat_changes_without_its_fitted_column_being_dated(
    name: str,
) -> None:
    file, published = published_of(name)

    now = numbers_digest(file)
    assert published.provenance.digest == now, (
        f"{name}.toml has other numbers than configs/trials/{name}.toml was judged by: go through "
        f"what is fitted and what is held out, then write digest = {now!r} and the day"
    )
    changed = file.text.replace("N_v    = -9.44e-3", "N_v    = -9.45e-3", 1)
    if changed != file.text:
        assert numbers_digest(replace(file, text=changed)) != now
    assert numbers_digest(replace(file, text=f"{file.text}\n# a remark\n")) == now


@pytest.mark.parametrize("name", SHIPPED)
def test_a_shipped_table_of_uncertainty_is_of_that_boat_and_of_every_figure(name: str) -> None:
    file, published = published_of(name)
    if not (published.trials or published.waves):
        return
    spreads = uncertainty.load_spreads(file, published)

    assert spreads, f"trainer boat guide {name} --uncertainty writes it"
    assert spreads.stale == ""
    assert {(title, each.quantity) for title, each in published.figures} == set(spreads.by_figure())
    prior = {one.name: one for one in uncertainty.prior_deviations(file, published)}
    assert {one.name for one in spreads.inputs} == set(prior)
    assert all(one.sd > 0.0 and one.reason for one in spreads.inputs)
    for one in spreads.inputs:  # a fit makes nothing less sure than it was before
        assert one.sd <= 1.01 * prior[one.name].sd


@pytest.mark.slow
def test_what_was_fitted_is_named_and_the_bad_figures_stand_where_they_are(
    book: GuideContents,
) -> None:
    rows = {(one.title, row.figure.quantity): row for one in book.guide.trials for row in one.rows}
    overshoot = rows[
        "Horizontal zig-zag 20/20 at 10 kn, constant revolutions", "heading overshoot 2"
    ]
    slow = [row for (title, _), row in rows.items() if " at 3 kn" in title or " at 6 kn" in title]

    assert overshoot.percent == pytest.approx(39.0, abs=2.0)
    assert (overshoot.figure.use, overshoot.verdict) == ("fitted", Validity.UNCERTAIN)
    assert len(slow) == 4
    assert {(row.figure.use, row.verdict) for row in slow} == {("held out", Validity.ABSENT)}
    assert book.published
    fitted = {name for fit in book.published.fits for name in fit.coefficients}
    assert {"N_v", "M_w", "K_pap"} <= fitted
    worst = [row.figure.quantity for _, row in validation.ranked_rows(book.guide.trials)]
    assert worst[:5] == ["pitch peak 1", "pitch peak 2"] * 2 + ["heading overshoot 2"]


# --- what is computed is no measurement


def test_a_computed_figure_is_no_surer_than_it_is_far_from_the_measurement() -> None:
    _, published = published_of("bb2")
    by_name = {(title.rpartition(", ")[2], one.quantity): one for title, one in published.figures}
    measured = by_name["constant revolutions", "largest sideways run"]
    computed = by_name["as computed by RANS", "largest sideways run"]

    assert (measured.value, measured.u) == (71.0, 3.0)
    assert (computed.value, computed.u) == (91.0, 20.0)
    # ours, 78 m, is nearer to the measurement than RANS: that is no model error
    assert verdicts.judge_error(78.0 - 91.0, computed.u, 91.0) is Validity.NOISE


def test_where_nobody_measured_a_computation_is_unsure_by_what_others_were_off() -> None:
    _, published = published_of("bb2")
    zigzag = "Horizontal zig-zag 20/20 at 10 kn"
    read = {title: each for title, each in _values_by_title(published).items() if zigzag in title}
    measured, computed = (read[title] for title in sorted(read, key=lambda one: "RANS" in one))
    shares = [1.0 - value / computed[name] for name, value in measured.items()]
    assert len(shares) == 16
    assert math.sqrt(np.mean(np.square(shares))) == pytest.approx(trials.COMPUTED_SHARE, abs=0.005)

    steady = next(one for _, one in published.figures if one.quantity == "steady diameter")
    assert steady.u == pytest.approx(trials.COMPUTED_SHARE * 206.0)
    heave = next(one for _, one in published.figures if one.quantity.startswith("heave"))
    assert heave.u == pytest.approx(trials.COMPUTED_SHARE * 0.265)


def _values_by_title(published: Published) -> dict[str, dict[str, float]]:
    """Return the published values by title and quantity."""
    found: dict[str, dict[str, float]] = {}
    for title, one in published.figures:
        found.setdefault(title, {})[one.quantity] = one.value
    return found


# --- verdicts


def test_an_error_is_noise_within_u_val_and_a_model_error_beyond_it() -> None:
    assert verdicts.judge_error(0.9, 1.0, 10.0) is Validity.NOISE
    assert verdicts.judge_error(-1.1, 1.0, 10.0) is Validity.MODEL_ERROR
    assert verdicts.judge_error(0.0, 3.1, -10.0) is Validity.UNCERTAIN
    assert verdicts.judge_error(9.0, 3.1, 10.0) is Validity.UNCERTAIN
    assert verdicts.judge_error(None, 0.1, 10.0) is Validity.ABSENT
    assert verdicts.judge_error(1.0, None, 10.0) is Validity.NOT_JUDGED


def test_three_steps_give_their_order_and_what_is_left() -> None:
    exact, slope = 5.0, 0.3
    u, order = verdicts.step_uncertainty([exact + slope * h**2 for h in (1.0, 2.0, 4.0)])

    assert order == pytest.approx(2.0)
    assert u == pytest.approx(1.25 * slope / 1.15)
    loose, none = verdicts.step_uncertainty([5.0, 5.4, 5.1])
    assert loose == pytest.approx(0.4)
    assert none is None
    assert verdicts.step_uncertainty([5.0, 5.0, 5.0]) == (0.0, None)


def test_the_uncertainty_of_a_comparison_is_the_root_of_three_squares() -> None:
    row = FigureRow(Figure("advance", "m", 100.0, "fitted", 6.0, 7), 90.0, 2.0, None, 3.0)

    assert row.u_val == pytest.approx(7.0)
    assert row.error == -10.0
    assert row.percent == pytest.approx(10.0)
    assert row.verdict is Validity.MODEL_ERROR
    assert replace(row, u_input=None).verdict is Validity.NOT_JUDGED


# --- the file


TRIAL = """
[boat]
judged = "2026-01-01"
digest = "0123456789abcdef"

[[trials]]
title = "a turn"
data = "sea"
source = "a report"
figure = "1"
read = "printed"
manoeuvre = "turn"
speed_m_s = 5.0
angle_deg = 20.0
u_D = { m = 3.0 }
results = [
    { quantity = "advance", unit = "m", value = 187.0, use = "held out" },
    { quantity = "u after 40 s", unit = "m/s", value = 4.0, use = "fitted", u = 0.1 },
]
"""


def test_a_file_beside_the_vessel_file_holds_its_figures(tmp_path: Path) -> None:
    vessel = tmp_path / "boat.toml"
    vessel.write_text(load_vessel("bb2").text, encoding="utf-8")
    assert trials_path(load_vessel(str(vessel))) is None

    (tmp_path / "boat.trials.toml").write_text(TRIAL.replace("angle", 'side = "port"\nangle'))
    (trial,) = load_published(trials_path(load_vessel(str(vessel))) or Path()).trials

    assert trial.manoeuvre == Turn(20.0, side=PORT)
    assert [(each.value, each.u, each.line) for each in trial.results] == [
        (187.0, 3.0, 18),
        (4.0, 0.1, 19),
    ]


@pytest.mark.parametrize(
    ("before", "after", "line", "wrong"),
    [
        ('"turn"', '"trun"', 12, 'manoeuvre = "trun": no such manoeuvre; nearest is turn'),
        ("angle_deg", "angel_deg", 14, "no such key; nearest is angle_deg"),
        ('unit = "m",', 'unit = "feet",', 17, 'unit = "feet": must be m or s or'),
        ('use = "held out"', 'use = "held"', 17, 'use = "held": must be fitted or held out'),
        (", u = 0.1", "", 18, "has no uncertainty: give it u [m/s], or the trial u_D of m/s"),
        ("{ m = 3.0 }", "{ m = 0.0 }", 15, "must be above 0"),
        ("{ m = 3.0 }", "{ metre = 3.0 }", 15, 'u_D = "metre": no such unit'),
        ('title = "a turn"\n', "", 6, "lacks title"),
        ('data = "sea"', 'data = "see"', 8, "must be sea or model or computed"),
        ("187.0", '"far"', 17, "must be a number"),
        ("187.0", "nan", 17, "must be finite"),
        ("[[trials]]", "[[trails]]", 0, "trails = ...: no such table; nearest is trials"),
    ],
)  # fmt: skip
def test_a_wrong_file_of_figures_is_told_with_its_line(
    before: str, after: str, line: int, wrong: str, tmp_path: Path
) -> None:
    path = tmp_path / "boat.trials.toml"
    path.write_text(TRIAL.replace(before, after, 1))

    with pytest.raises(ConfigError) as caught:
        load_published(path)
    told = [text for text in caught.value.problems if wrong in text]
    assert told, caught.value.problems
    if line:
        assert told[0].startswith("boat.trials.toml: line ")
        assert abs(int(re.findall(r"line (\d+)", told[0])[0]) - line) <= 1


@pytest.mark.parametrize(
    ("before", "after", "wrong"),
    [
        ('"advance"', '"advanse"', '"advanse": no such measure; nearest is advance'),
        ('unit = "m",', 'unit = "s",', 'unit = "s" does not fit, it is in m'),
        ('unit = "m/s"', 'unit = "rad/s"', 'unit = "rad/s" does not fit, it is in m/s'),
    ],
)
def test_a_quantity_or_unit_that_the_manoeuvre_has_not_is_told_with_its_line(
    before: str, after: str, wrong: str, tmp_path: Path
) -> None:
    path = tmp_path / "boat.trials.toml"
    text = TRIAL.replace("u_D = { m = 3.0 }", 'u_D = { m = 3.0, s = 1.0, "rad/s" = 1.0 }')
    path.write_text(text.replace(before, after))
    file, published = load_vessel("bb2"), load_published(path)
    (trial,) = published.trials

    with pytest.raises(ConfigError, match=re.escape(wrong)) as caught:
        trial.read_flight(published, fly_task(file.path, trial.task(file)))
    assert re.match(r"boat\.trials\.toml: line 1[78]: ", str(caught.value))


def test_a_boat_for_which_nothing_was_found_says_so(tmp_path: Path) -> None:
    path = tmp_path / "boat.trials.toml"
    heading = TRIAL.split("[[trials]]", maxsplit=1)[0]
    path.write_text(heading)
    with pytest.raises(ConfigError, match="say nothing_found in"):
        load_published(path)

    path.write_text(f'{heading}nothing_found = "nothing in three libraries"\n')
    assert load_published(path).provenance.nothing_found == "nothing in three libraries"


def test_a_deviation_or_a_fit_of_what_is_not_there_is_told(tmp_path: Path) -> None:
    path, file = tmp_path / "boat.trials.toml", load_vessel("bb2")
    row = '[[deviations]]\ninputs = ["N_vv"]\nshare = 0.1\nreason = "x"\n'
    path.write_text(TRIAL + row)
    with pytest.raises(ConfigError, match='inputs = "N_vv": no number of the boat that is not 0'):
        uncertainty.prior_deviations(file, load_published(path))
    path.write_text(TRIAL + row.replace("share = 0.1\n", ""))
    with pytest.raises(ConfigError, match="must have share or size"):
        load_published(path)
    path.write_text(TRIAL + '[[fits]]\ncoefficients = ["N_vw"]\nto = "x"\n')
    with pytest.raises(ConfigError, match='coefficients = "N_vw": no coefficient that is not 0'):
        uncertainty.fly_uncertainty(file, load_published(path), 1, lambda: None)


WAVES = """
[[waves]]
title = "a sea"
data = "computed"
source = "a report"
figure = "2"
read = "printed"
use = "held out"
speed_m_s = 5.0
period_s = 9.0
height_m = 3.0
depth_m = [15.0, 20.0]
heave = [0.3, 0.2]
u_heave = 0.01
pitch_deg = [1.0, 0.8]
u_pitch_deg = 0.05
"""


@pytest.mark.parametrize(
    ("before", "after", "wrong"),
    [
        ("[0.3, 0.2]", "[0.3]", "heave = [0.3]: must have 2 numbers as depth_m has"),
        ("period_s", "perriod_s", "perriod_s = 9.0: no such key; nearest is period_s"),
        ("height_m = 3.0", "height_m = nan", "height_m = nan: must be finite"),
        ("u_heave = 0.01\n", "", "lacks u_heave"),
    ],
)
def test_wrong_waves_are_told_with_their_line(
    before: str, after: str, wrong: str, tmp_path: Path
) -> None:
    path = tmp_path / "boat.trials.toml"
    path.write_text(TRIAL + WAVES.replace(before, after))

    with pytest.raises(ConfigError, match=re.escape(wrong)) as caught:
        load_published(path)
    assert re.match(r"boat\.trials\.toml: line [23]\d: \[waves\[0\]\] ", str(caught.value))


# --- ours beside them


# Model document, section 2: strips alone, and with the flow that the hull's lift feels
HEAD_SEA = {
    13.8724: ((0.277, 1.02), (0.274, 0.92)),
    15.3724: ((0.260, 0.96), (0.257, 0.86)),
    35.0624: ((0.112, 0.41), (0.111, 0.37)),
}


def test_the_published_head_sea_stands_beside_ours_with_and_without_flow() -> None:
    file, published = published_of("bb2")
    (waves,) = published.waves
    flow, strips = (
        validation.wave_values(file, waves, speed) for speed in (waves.heading.speed_m_s, 0.0)
    )

    assert not isinstance(flow, str)
    assert not isinstance(strips, str)
    assert waves.heading.depth_m == (*HEAD_SEA,)
    for i, told in enumerate(HEAD_SEA.values()):
        assert strips[2 * i : 2 * i + 2] == pytest.approx(told[0], abs=0.006)
        assert flow[2 * i : 2 * i + 2] == pytest.approx(told[1], abs=0.006)
    data = [figure.value for figure in waves.results]
    # what was chosen is nearer in pitch, and no further off in heave than 4 %
    assert max(abs(a / b - 1.0) for a, b in zip(flow[1::2], data[1::2], strict=True)) < 0.10
    assert max(abs(a / b - 1.0) for a, b in zip(strips[1::2], data[1::2], strict=True)) > 0.20
    assert max(abs(a / b - 1.0) for a, b in zip(flow[::2], data[::2], strict=True)) < 0.04


def test_a_boat_that_cannot_fly_level_at_the_waves_speed_says_so(tmp_path: Path) -> None:
    path = tmp_path / "boat.trials.toml"
    path.write_text(TRIAL + WAVES.replace("speed_m_s = 5.0", "speed_m_s = 0.5"))
    file, published = load_vessel("bb2"), load_published(path)
    heavy = replace(file, hull=replace(file.hull, weight=1.01 * file.hull.weight))

    assert validation.wave_values(heavy, published.waves[0], 0.5) == (
        "no straight level flight at 0.5 m/s"
    )


def test_our_figures_are_those_of_the_command_beside_them(book: GuideContents) -> None:
    one = next(each for each in book.guide.trials if "15 kn" in each.title)
    words = one.command.removeprefix("trainer boat manoeuvre ").split()
    done = CliRunner().invoke(manoeuvre, [*words, "--json"])

    told = {each["name"]: each["value"] for each in json.loads(done.stdout)["measures"]}
    for row in one.rows:
        factor = trials.FILE_UNITS[row.figure.unit]
        assert row.ours == pytest.approx(told[row.figure.quantity] / factor, rel=2e-3), (
            row.figure.quantity
        )


# Validation document of the vessel data, section 1: the columns "2510 model" of 1a and 1c
MODEL_2510 = {
    "Horizontal zig-zag 20/20 at 10 kn, constant revolutions": [
        *(0.574, 30.5, 13.0, 17.3, 58.4, -0.65, 87.0, 0.64, 153.0),
        *(0.0327, -0.0337, 4.36, 3.75, 76.0, 0.061, -0.055),
    ],
    "Vertical zig-zag 10/10 at 10 kn, sail planes fixed, by RANS": [
        *(11.8, -12.3, 12.1, 0.0161, -0.0166, 2.37, 3.82, 0.223, 0.925),
    ],
    "Vertical zig-zag 10/10 at 15 kn, sail planes fixed, by RANS": [
        *(13.3, -14.3, 14.1, 0.0240, -0.0251, 2.52, 4.15, 0.330, 0.923),
    ],
}


@pytest.mark.parametrize("title", MODEL_2510)
def test_zig_zags_are_those_of_the_published_model(book: GuideContents, title: str) -> None:
    (trial,) = (each for each in book.guide.trials if each.title == title)

    assert [row.ours for row in trial.rows] == pytest.approx(MODEL_2510[title], rel=0.04)


def test_roll_decays_as_published(book: GuideContents) -> None:
    (decay,) = (each for each in book.guide.trials if "Roll decay" in each.title)

    for row in decay.rows:
        assert row.percent < 9.0
    assert decay.rows[0].figure.use == "held out"  # the period follows from inertia and BG


# --- uncertainty


def test_a_changed_boat_flies_otherwise_and_an_unchanged_one_the_same() -> None:
    file, published = published_of("bb2")
    trial = next(each for each in published.trials if each.name == "roll-decay")
    task = trial.task(file)

    def period(**values: float) -> float:
        flight = fly_boat(uncertainty.changed_boat(file, values), task)
        return trial.read_flight(published, flight)[0] or math.nan

    usual = period()
    assert period(mass=file.hull.mass) == usual
    # of a pendulum: the period goes with the root of the inertia over that of BG
    assert period(BG=0.4406 * 1.1) / usual == pytest.approx(1.1**-0.5, rel=0.01)
    assert period(Ix=1.1 * file.hull.Ix) > usual
    fast = uncertainty.changed_boat(file, {"thrust": 2.0}).thrust.ahead[0]
    assert fast.c == 2.0 * file.thrust.ahead[0].c


def test_a_fit_leaves_what_its_figures_tell_and_keeps_what_they_do_not() -> None:
    slopes = np.array([[2.0, 0.0], [2.0, 0.0]])
    prior = np.array([10.0, 3.0])
    exact = uncertainty.fit_covariance(slopes, np.zeros(2), np.array([0.1, 0.1]), prior)

    assert math.sqrt(exact[0, 0]) == pytest.approx(0.1 / 2.0 / math.sqrt(2.0), rel=1e-3)
    assert math.sqrt(exact[1, 1]) == pytest.approx(3.0)
    poor = uncertainty.fit_covariance(slopes, np.array([1.0, -1.0]), np.array([0.1, 0.1]), prior)
    assert poor[0, 0] > 100.0 * exact[0, 0]  # residuals beyond the reading count as noise


def test_the_estimate_lends_its_share_and_no_more_than_the_coefficient() -> None:
    file, published = published_of("bb2")
    prior = {one.name: one for one in uncertainty.prior_deviations(file, published)}

    assert prior["Y_v"].sd == pytest.approx(0.28 * 6.22e-2)
    assert prior["Y_r"].sd == pytest.approx(1.61e-3)
    assert prior["mass"].reason.startswith("displacement of 4440 t")
    assert prior["BG"].reason == uncertainty.OWN_ESTIMATE
    assert "N_vw" not in prior


@pytest.mark.process
@pytest.mark.slow
def test_the_shipped_table_is_what_its_command_writes(tmp_path: Path) -> None:
    file, published = published_of("bb2")
    seen: list[None] = []

    text = uncertainty.fly_uncertainty(file, published, 2, lambda: seen.append(None))

    assert len(seen) == uncertainty.flight_count(published)
    stored = uncertainty.load_spreads(file, published)
    assert stored
    path = tmp_path / published.path.name
    path.write_text(published.text)
    uncertainty.table_path(load_published(path)).write_text(text)
    flown = uncertainty.load_spreads(file, load_published(path))
    assert flown
    for one, other in zip(stored.spreads, flown.spreads, strict=True):
        assert one.u_input == pytest.approx(other.u_input, rel=0.02), one.quantity


def test_a_table_of_another_boat_is_stale_and_judges_nothing(tmp_path: Path) -> None:
    file, published = published_of("bb2")
    other = replace(file, text=file.text.replace("-9.44e-3", "-9.45e-3", 1))
    stale = uncertainty.load_spreads(other, published)

    assert stale
    assert "was flown with vessel 53df600eaee929fe, now " in stale.stale
    assert stale.by_figure() == {}
    path = tmp_path / "bb2.trials.toml"
    path.write_text(published.text)
    mine = load_published(path)
    assert uncertainty.load_spreads(file, mine) is None
    table = uncertainty.table_path(published).read_text(encoding="utf-8")
    for broken in (
        'vessel = "x"\n',
        table.replace("members = 200", "members = inf"),
        table.replace("0.00161, ", "0.0, "),
        table.replace(", 0.00156,", ", nan,"),
    ):
        assert broken != table
        uncertainty.table_path(mine).write_text(broken)
        with pytest.raises(ConfigError, match="is no table of --uncertainty"):
            uncertainty.load_spreads(file, mine)


@pytest.mark.slow
def test_a_boat_without_figures_has_nothing_to_be_uncertain_of_and_says_why(
    tmp_path: Path,
) -> None:
    boat = tmp_path / "lone.toml"
    boat.write_text(load_vessel("sdv-mk9").text)
    digest = numbers_digest(load_vessel(str(boat)))
    heading = f'[boat]\njudged = "2026-11-25"\ndigest = "{digest}"\n'
    looked = 'nothing_found = "three libraries were looked through"\n'
    boat.with_suffix(".trials.toml").write_text(heading + looked)
    done = CliRunner().invoke(guide, [str(boat), "--uncertainty"])

    assert "--uncertainty: lone.toml has no published figures in" in str(done.exception)
    none = write_guide(load_vessel(str(boat)), [], MADE, 1, lambda: None)
    assert none.published
    assert none.guide.doubts == ()
    assert "three libraries were looked through" in judged_page.validation(none)


def test_a_few_nearly_unstable_boats_do_not_make_the_spread() -> None:
    usual = np.linspace(-3.0, 3.0, 999)

    assert uncertainty.spread_of(usual) == pytest.approx(0.6827 * 3.0, rel=0.01)
    wild = np.append(usual, [500.0, 900.0])
    assert uncertainty.spread_of(wild) == pytest.approx(uncertainty.spread_of(usual), rel=0.01)


# --- pages


def test_the_first_page_counts_both_kinds_and_puts_the_worst_first(
    book: GuideContents, page: str
) -> None:
    rows = validation.count_rows(book.guide.trials)
    counts = {row[0]: [int(each) for each in row[1:]] for row in rows}
    first = page.split('<section id="validation">')[1].split("</section>", maxsplit=1)[0]

    assert judged_page.NO_HISTORY in first
    parts = [counts[name] for name in validation.COUNTED_USES if name != "all"]
    assert counts["all"] == [sum(each) for each in zip(*parts, strict=True)]
    # of 24 held-out figures one was measured, the period of the roll; a computation is no evidence
    assert counts["held out and measured"][0] == 1
    assert counts["held out, computed by others"][0] == 23
    for numbers in counts.values():
        assert numbers[0] == sum(numbers[1:])
    assert first.index("heading overshoot 2") > first.index("pitch peak 1")
    assert page.index('id="validation"') < page.index('id="predicted"')
    text = render(book.guide, None)
    assert "held out and measured: 1, 1 below the noise" in " ".join(text.split())
    assert max(map(len, text.splitlines())) <= 79
    assert text.isascii()


def test_every_number_of_the_figures_leads_to_its_row_or_its_command(
    book: GuideContents, page: str
) -> None:
    assert book.published
    assert book.spreads
    lines = book.published.text.split("\n")
    for one in book.guide.trials:
        for row in one.rows:
            assert f'href="#data-{row.figure.line}"' in page
            assert row.figure.quantity.split(" at ")[0].split(",")[0] in lines[row.figure.line - 1]
            figures = [
                float(each) for each in re.findall(r"-?\d+\.?\d*", lines[row.figure.line - 1])
            ]
            assert row.figure.value in figures
    table = book.spreads.text.split("\n")
    figures_chapter = page.split('<section id="published">')[1].split("</section>", maxsplit=1)[0]
    for spread in book.spreads.spreads:
        assert f'href="#input-{spread.line}"' in figures_chapter
        assert json.dumps(spread.quantity) in table[spread.line - 1]
    for number in book.spreads.inputs:
        assert table[number.line - 1].strip().startswith(f'["{number.name}"')
    targets = set(re.findall(r'id="([^"]+)"', page))
    assert set(re.findall(r'href="#([^"]+)"', page)) - targets <= {
        guide_page.anchor(leg.title) for leg in book.legs
    }


def test_the_page_has_the_headings_that_a_reviewer_knows(page: str) -> None:
    heads = re.findall(r"<h2>([^<]+)</h2>", page)

    for wanted in (
        "Forces predicted", "Forces modelled", "Integration", "Software", "Manoeuvres",
        "Benchmark data", "Causes of error, sensitivity", "Statement of compliance",
        "Transport delay", "Subjective checks",
    ):  # fmt: skip
        assert any(head.startswith(wanted) for head in heads), wanted
    checks = page.split('<section id="subjective">')[1].split("</section>", maxsplit=1)[0]
    assert checks.count("yes / no") >= 8
    assert "Signature: ____" in checks


def test_a_stale_or_missing_table_is_told_on_the_first_page(book: GuideContents) -> None:
    rows = tuple(
        replace(one, rows=tuple(replace(row, u_input=None) for row in one.rows))
        for one in book.guide.trials
    )
    doubted = replace(book.guide, trials=rows, doubts=("No table: fly one",))
    html = guide_page.html_page(replace(book, guide=doubted, spreads=None), None)

    assert "No table: fly one." in html
    assert "None are stored for this boat." in html
    (_, _, *counts) = validation.count_rows(rows)[-1]
    assert counts[-1] == str(sum(len(one.rows) for one in rows))


def test_published_figures_are_among_what_moves(book: GuideContents) -> None:
    told: dict[str, Any] = json.loads(json.dumps(asdict(book.guide)))
    row = book.guide.trials[0].rows[0]
    name = f"{book.guide.trials[0].title}: {row.figure.quantity} [{row.figure.unit}]"

    assert dict(leaves(told))[name] == row.ours
    result = {"quantity": row.figure.quantity, "unit": row.figure.unit}
    before = {"trial": {"title": book.guide.trials[0].title, "results": [result]}, "ours": [1.5]}
    assert dict(leaves({**told, "trials": [before]}))[name] == 1.5


# --- transport delay


def test_an_order_moves_its_control_on_the_next_tick_and_the_boat_on_the_one_after() -> None:
    sheets = {(one.control, one.step_s): one for one in contents.measure_delays(load_vessel("bb2"))}

    for step in (0.5, 1.0):
        for control in ("rudder", "planes"):
            sheet = sheets[control, step]
            assert (sheet.control_ticks, sheet.motion_ticks) == (1, 2)
            assert sheet.mean_s(1) == pytest.approx(0.5 * step)
            assert sheet.mean_s(1, "terminal") == pytest.approx(0.5 * step + 0.05)
            assert sheet.most_s(1, "browser") == pytest.approx(step + 0.05)
        engine = sheets["engine", step].control_ticks
        assert engine
        assert engine * step == pytest.approx(3.0 + step)  # the dead time of the vessel file


def test_screens_draw_as_often_as_the_sheet_says() -> None:
    script = Path(app.__file__).parents[1] / "web/assets/js/model/motion.js"
    frame = re.search(r"const FRAME = (\d+);", script.read_text(encoding="utf-8"))

    assert frame
    assert contents.SCREEN_PERIODS_S["browser"] == int(frame[1]) / 1000.0
    assert contents.SCREEN_PERIODS_S["terminal"] == 1.0 / app.REFRESH_RATE_HZ
