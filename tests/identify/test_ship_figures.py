"""Published figures of ships beside those of their models, and what was found of every vessel."""

import json
import shutil
from dataclasses import replace
from pathlib import Path

import pytest
from click.testing import CliRunner

from trainer.analysis.guide.trials import HELD_OUT, Published, load_published, tables_digest
from trainer.analysis.guide.verdicts import Validity
from trainer.cli.main import cli
from trainer.config.files import ConfigError, read_text, shipped_names, shipped_path
from trainer.config.ship.ship import ShipFile, load_ship
from trainer.identify.ships import vehicle
from trainer.identify.ships.published import compare_ship, figures_path, render

SHIPS = shipped_names("ships")
SAILED_TABLES = ("dimensions", "roll", "result", "coefficients")
KVLCC2_TITLES = {
    "Zig-zag 20/20 at 15.5 kn, to port first": "fitted",
    "Zig-zag 20/20 at 15.5 kn, to starboard first": HELD_OUT,
    "Zig-zag 10/10 at 15.5 kn, to port first": HELD_OUT,
    "Zig-zag 10/10 at 15.5 kn, to starboard first": HELD_OUT,
    "Turning circle to port, 35 degrees of rudder, at 15.5 kn": HELD_OUT,
    "Turning circle to starboard, 35 degrees of rudder, at 15.5 kn": HELD_OUT,
}


def ship_and_figures(name: str) -> tuple[ShipFile, Published]:
    """Return a shipped ship and its published figures."""
    ship = load_ship(shipped_path("ships", name))
    return ship, load_published(figures_path(ship))


def test_every_shipped_vessel_has_figures_or_says_that_none_were_found() -> None:
    for name in (*shipped_names("vessels"), *SHIPS):
        published = load_published(shipped_path("trials", name))
        assert bool(published.trials) is not bool(published.provenance.nothing_found), name


def test_at_least_six_manoeuvres_are_held_out() -> None:
    files = [load_published(shipped_path("trials", name)) for name in ("bb2", *SHIPS)]
    held_out = [
        trial.heading.title
        for published in files
        for trial in published.trials
        if {figure.use for figure in trial.results} == {HELD_OUT}
        and trial.heading.data in ("sea", "model")
    ]
    assert len(held_out) >= 6


@pytest.mark.parametrize("name", SHIPS)
def test_no_number_of_a_shipped_ship_changes_without_its_fitted_column_being_dated(
    name: str,
) -> None:
    ship, published = ship_and_figures(name)
    digest = tables_digest(read_text(ship.path), ship.path.name, SAILED_TABLES)
    assert published.provenance.digest == digest, f"go through configs/trials/{name}"


@pytest.mark.slow
def test_kvlcc2_is_fitted_to_one_record_and_its_turns_stand_where_they_are_bad() -> None:
    ship, published = ship_and_figures("kvlcc2")
    uses = {each.heading.title: {one.use for one in each.results} for each in published.trials}
    assert uses == {title: {use} for title, use in KVLCC2_TITLES.items()}
    assert {name for fit in published.fits for name in fit.coefficients} == set(ship.uncertain)

    compared = {each.title: each for each in compare_ship(ship, published)}
    fitted = compared["Zig-zag 20/20 at 15.5 kn, to port first"]
    assert {row.verdict for row in fitted.rows} == {Validity.NOISE}
    turn = compared["Turning circle to port, 35 degrees of rudder, at 15.5 kn"]
    advance = next(row for row in turn.rows if row.figure.quantity == "advance")
    assert advance.figure.value == 969.2  # [m] of the record
    assert advance.error == pytest.approx(105.0, abs=5.0)
    assert advance.u_input is not None
    assert advance.u_input > 20.0
    assert advance.verdict is Validity.MODEL_ERROR

    # the command that stands beside a figure gives it
    words = turn.command.split()
    assert words[0] == "trainer"
    result = CliRunner().invoke(cli, [*words[1:], "--json"])
    flown = {one["name"]: one["value"] for one in json.loads(result.stdout)["measures"]}
    assert flown["advance"] == pytest.approx(advance.ours, abs=0.1)
    text = render(ship, published, tuple(compared.values()))
    assert all(len(line) <= 79 for line in text.splitlines())


@pytest.mark.long
def test_what_the_mariner_s_coefficients_are_worth_decides_its_verdict(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(vehicle, "MAX_DRAWS", 20)
    ship, published = ship_and_figures("mariner")
    ((row,),) = (each.rows for each in compare_ship(ship, published))
    assert row.figure.value == 0.875
    assert row.ours == pytest.approx(0.877, abs=0.005)
    assert row.u_input
    assert row.u_input > 0.02
    assert row.verdict is Validity.NOISE
    ((unsure,),) = (each.rows for each in compare_ship(ship, replace(published, deviations=())))
    assert unsure.ours == row.ours
    assert (unsure.u_input, unsure.verdict) == (None, Validity.NOT_JUDGED)


# Bad input


@pytest.mark.slow
@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        (
            'inputs = ["N_v"]',
            'inputs = ["N_w"]',
            r"line \d+: .*N_w.*no coefficient of mariner.toml",
        ),
        (
            "last speed, of the first",
            "last speed",
            r"line \d+: .*last speed.*no such measure",
        ),
        ('unit = "-"', 'unit = "knots"', r"line \d+: .*knots"),
        (", u = 0.02", "", r"line \d+: .*has no uncertainty"),
    ],
)
def test_a_mistake_in_a_ship_s_figures_is_named_with_its_line(
    old: str, new: str, told: str, tmp_path: Path
) -> None:
    shutil.copy(shipped_path("ships", "mariner"), tmp_path / "mariner.toml")
    ship = load_ship(tmp_path / "mariner.toml")
    with pytest.raises(ConfigError, match=r"mariner\.toml: has no published figures"):
        figures_path(ship)
    text = shipped_path("trials", "mariner").read_text(encoding="utf-8")
    assert old in text
    (tmp_path / "mariner.trials.toml").write_text(text.replace(old, new), encoding="utf-8")
    with pytest.raises(ConfigError, match=told):
        compare_ship(ship, load_published(figures_path(ship)))


@pytest.mark.long
def test_the_guide_of_a_ship_prints_its_figures_and_makes_no_page(tmp_path: Path) -> None:
    result = CliRunner().invoke(cli, ["guide", "mariner", "--json"])
    assert result.exit_code == 0
    ((row,),) = (each["rows"] for each in json.loads(result.stdout))
    assert row["verdict"] == Validity.NOISE
    page = tmp_path / "mariner.html"
    refused = CliRunner().invoke(cli, ["guide", "mariner", "--html", str(page)])
    assert refused.exit_code == 2
    assert "--html" in refused.output
    assert not page.exists()
