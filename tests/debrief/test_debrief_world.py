"""A debrief of the world around the boat: ships, what was seen of them, and the ground."""

import re
from pathlib import Path

from helpers.typed import type_command

from trainer.cli.main import cli
from trainer.debrief.page.page import read_dossier, render

LANE = """\
schema = "exercise/1"
name = "A lane"
briefing = "Look round."
duration_s = 90

[initial]
speed_kn = 5
depth_m = 17.5

[bottom]
depth_m = 60
slope_percent = 1
deepens_deg = 180

[limits]
clearance_m_min = 35

[[contact]]
name = "big"
type = "tanker"
points = [[2000, 1000]]
course_deg = 270
speed_kn = 12

[[scores]]
name = "Seen"
measure = "time-to-detect"
full = 20
zero = 60
"""


def test_a_page_has_the_ways_of_ships_what_was_seen_each_look_and_the_water_below(
    tmp_path: Path,
) -> None:
    """Of a run past a ship, with two looks, over ground that rises."""
    exercise, orders, record = (tmp_path / name for name in ("lane.toml", "o.txt", "r.trainer"))
    exercise.write_text(LANE)
    orders.write_text("2 scope raise\n30 scope lower\n60 scope raise\n")
    words = ["run", str(exercise), "--orders", str(orders), "--record", str(record)]
    type_command(cli, *words, "--headless", "--speed", "max")
    told = render(read_dossier(record, None))

    track = told[told.index("The track from above") :]
    track = track[: track.index("</svg>")]
    assert re.search(r'class="ship-name[^>]*>big<', track)
    assert 'class="line ship"' in track
    apart = re.search(r'class="approach".*?>(\d+) m<', track)
    assert apart
    assert f"<td>{apart[1]} m</td>" in told  # as the table of ships has it
    ships = told[told.index('id="ships"') :]
    assert re.search(r"<td>big</td>.*?<small>tick \d+</small></td><td>no</td>", ships)
    line = told[told.index("What happened when") :]
    assert line[: line.index("</svg>")].count('class="shown"') == 2
    chart = told[told.index("Water under the keel against time") :]
    assert "limit 35 m" in chart[: chart.index("</svg>")]
