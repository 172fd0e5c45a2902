"""What feeds what: the page and the picture have every row of the vessel file's plant."""

import html
import re
from dataclasses import replace
from pathlib import Path

import pytest
from click.testing import CliRunner
from helpers.places import ROOT

from trainer.analysis.plant_page import draw_feeds, feed_page, named
from trainer.cli.main import cli
from trainer.config.boat.vessel import load_vessel
from trainer.config.files import ConfigError

BB2 = load_vessel("bb2")


def drawn_words(picture: str) -> list[str]:
    """Return the texts of a picture."""
    return [html.unescape(each) for each in re.findall(r">([^<>]+)</text>", picture)]


def test_every_consumer_of_the_file_is_in_the_page_and_in_the_picture_behind_its_bus() -> None:
    plant = BB2.plant
    assert plant
    page, words = " ".join(feed_page(BB2).split()), drawn_words(draw_feeds(BB2))
    for row in plant.consumers:
        assert named(row.name) in words
        for bus in row.buses:
            after = page.split(f"{bus} bus: ")[1].split(" bus: ")[0]
            assert f"{named(row.name)} ({row.power_w / 1e3:g} kW" in after
    for item in plant.burning:
        assert f"{item.dose_s:g} s" in page.split("Fire, by compartment:")[1]
    assert {"main oil", "vital oil", "rudder", "stern planes", "bow planes"} <= {*words}


def test_a_second_bus_stands_by_and_a_mode_that_the_boat_has_not_is_left_out() -> None:
    plant = BB2.plant
    assert plant
    gyro = next(row for row in plant.consumers if row.name == "gyro")
    rows = tuple(
        replace(row, buses=("port", "dc")) if row is gyro else row for row in plant.consumers
    )
    surfaces = replace(plant.surfaces, modes=("normal", "hand"))
    other = replace(BB2, plant=replace(plant, consumers=rows, surfaces=surfaces))
    page = " ".join(feed_page(other).split())
    assert "gyro (1 kW, standing by)" in page.split("dc bus: ")[1]
    assert "emergency" not in page
    assert draw_feeds(other).count('class="spare"') == draw_feeds(BB2).count('class="spare"') - 2


def test_the_document_s_picture_is_the_one_that_the_command_draws(tmp_path: Path) -> None:
    drawn = tmp_path / "plant.svg"
    done = CliRunner().invoke(cli, ["boat", "plant", "bb2", "--svg", str(drawn)])
    assert done.exit_code == 0
    assert done.output.strip() == feed_page(BB2)
    assert max(map(len, done.output.splitlines())) < 80
    kept = ROOT / "docs" / "images" / "plant.svg"
    told = "draw it again: trainer boat plant bb2 --svg docs/images/plant.svg"
    assert drawn.read_text("utf-8") == kept.read_text("utf-8"), told


def test_a_boat_without_a_plant_is_answered_in_a_line() -> None:
    file = load_vessel("sdv-mk9")
    for make in (feed_page, draw_feeds):
        with pytest.raises(ConfigError, match=re.escape("this boat has no plant: add the table")):
            make(file)
