"""Ships in a session: added, moved and removed live, called, run into, replayed and debriefed."""

import json
import math
import re
import tomllib
from pathlib import Path

import pytest
from helpers.crewed import Begin, Crewed
from helpers.nursery import run_trainer
from helpers.places import environment
from helpers.sessions import frame_of

from trainer.api.boat import Boat
from trainer.boat.world.contacts import contacts_in
from trainer.config.files import ConfigError
from trainer.config.world.world import WorldTables, read_world
from trainer.debrief.marks.rehearsal import fly_rehearsal
from trainer.debrief.passage.ships_met import meet_ships
from trainer.session.jump import jump_to
from trainer.session.past.options import RunOptions
from trainer.session.past.plan import plan_run
from trainer.session.run import run_boat
from trainer.session.stations.channels import CHANNELS

WALL = """
[[contact]]
name = "wall"
type = "tanker"
points = [[400, 0]]
course_deg = 90
[contacts]
collision = "{what}"
"""
RUN = ("--headless", "--speed", "max")


def tables(text: str) -> WorldTables:
    """Return the tables of a world as an exercise has them."""
    return read_world(tomllib.loads(text), Path("ships.toml"))


def shallow(ship: Crewed) -> Crewed:
    """Let a boat be where its sail is in the way of keels."""
    ship.boat.start(5.0, 17.5, 0.0)
    jump_to(ship.session, ship.session.history.now(), "shallow")
    return ship


def test_a_collision_freezes_and_time_may_go_on(crewed: Begin) -> None:
    ship = shallow(crewed(seconds=None, world=tables(WALL.format(what="freeze"))))
    ship.fly(400)
    assert ship.session.time.frozen
    assert "collision with wall" in " ".join(ship.events(ship.instructor, "time"))
    assert any("COLLISION with wall" in each for each in ship.events(ship.instructor, "watch"))
    here = ship.boat.ticks
    ship.fly(20)
    assert ship.boat.ticks == here + 20


def test_an_instructor_adds_moves_and_removes_ships(ship: Crewed) -> None:
    ship.order("contact add tug1 tug at 500 -200 course 090 speed 8")
    ship.fly(10)
    contacts = contacts_in(ship.boat)
    assert contacts is not None
    (tug,) = contacts.seen(10)
    assert (tug.north, tug.east) == pytest.approx((500.0, -200.0 + 5.0 * 8.0 * 1852 / 3600))
    ship.order("contact tug1 move 900 100")
    (tug,) = contacts.seen(10)
    assert (tug.north, tug.east) == (900.0, 100.0)
    ship.order("contact tug1 course 180")
    ship.order("contact tug1 speed 0")
    ship.fly(600)
    (tug,) = contacts.seen(610)
    assert (tug.course, tug.speed) == pytest.approx((math.pi, 0.0))
    assert ship.order("contact tug1 remove") == "contact tug1 is gone"
    assert contacts.seen(610) == ()
    assert [each.name for each in contacts.seen(300)] == ["tug1"]


@pytest.mark.parametrize(
    ("words", "why"),
    [
        ("contact tug2 remove", "no contact tug2; nearest is tug1"),
        ("contact zz speed 3", "no contact zz; there are: tug1"),
        ("contact tug1 speed 15", "a tug makes 14 kn"),
        ("contact add tug1 tug at 0 900 course 0 speed 3", "there is a contact tug1 already"),
        ("contact add yy yacht at 0 900 course 0 speed 10", "a yacht makes 9 kn"),
        ("contact add add tug at 0 900 course 0 speed 3", "add: a name has at most 16"),
    ],
)
def test_what_cannot_be_is_refused(ship: Crewed, words: str, why: str) -> None:
    ship.order("contact add tug1 tug at 500 -200 course 090 speed 8")
    assert why in ship.refused(words)


LIVE = {
    0: "contact add tug1 tug at 60 -40 course 010 speed 12",
    5: "current set 300 drift 3",
    20: "contact tug1 course 030",
    35: "contact big move 80 60",
    42: "current set 100 drift 1",
    50: "contact tug1 speed 4",
    80: "contact big remove",
}
PULLING = """
[[contact]]
name = "big"
type = "tanker"
points = [[0, 120]]
speed_kn = 12
drifts = true
[contacts]
force = "on"
collision = "call"
"""


def test_a_replay_of_live_changes_ends_in_the_same_bits(crewed: Begin) -> None:
    ship, pulled = shallow(crewed(seconds=None, world=tables(PULLING))), 0
    for tick in range(100):
        if words := LIVE.get(tick):
            ship.order(words)
        ship.fly(1)
        pulled += bool(ship.boat.state.ship_force.any())
    assert 0 < pulled < 100
    ship.order("freeze")
    ship.order("replay 45 s")
    ship.fly(200)
    assert any(
        "the same to the last bit" in each for each in ship.events(ship.instructor, "moment")
    )


def test_the_instructor_is_sent_the_nearest_ships(crewed: Begin) -> None:
    ship = crewed(seconds=None, world=tables(WALL.format(what="call")))
    ship.order("contact add near tug at 0 100 course 180 speed 4")
    ship.fly(2)
    frame = frame_of(ship.boat)
    channel = CHANNELS["contacts"]
    shown = dict(zip((each.name for each in channel.fields), channel.values(frame), strict=True))
    assert (shown["ships"], shown["contact_1"], shown["contact_2"]) == ("2", "near", "wall")
    assert (shown["contact_1_type"], shown["contact_1_course"]) == ("tug", "180.0")
    assert float(shown["contact_1_bearing"]) == pytest.approx(94.1, abs=0.3)
    assert (shown["contact_2_speed"], shown["contact_2_cpa"]) == ("0.0", "0")
    assert float(shown["contact_2_tcpa"]) == pytest.approx(395.0 / 5.144, abs=1.0)
    assert float(shown["contact_1_tcpa"]) < 0.0
    assert shown["contact_3"] == ""


def test_a_rehearsal_ends_with_the_collision_that_loses_it(tmp_path: Path) -> None:
    flown = fly_rehearsal(plan_run(RunOptions(exercise=str(wall_ahead(tmp_path, "end")))))
    assert flown.lost == "collision with wall"
    met = meet_ships(flown.trajectory)
    assert [name for _, name in met.collisions] == ["wall"]
    assert met.nearest.min() == pytest.approx(met.closest["wall"][0])
    # the hull is below the keel: the sail, 7 m ahead of the origin, meets a side 16 m from it
    assert met.closest["wall"][0] == pytest.approx(23.0, abs=3.0)


def wall_ahead(folder: Path, how: str) -> Path:
    """Return the file of an exercise whose boat runs into a wall."""
    head = 'schema = "exercise/1"\nname = "Wall"\nbriefing = "A wall."\nduration_s = 300\n'
    path = folder / "wall.toml"
    path.write_text(head + "[initial]\nspeed_kn = 10\ndepth_m = 17.5\n" + WALL.format(what=how))
    return path


@pytest.mark.parametrize(
    ("how", "code", "told"),
    [
        ("end", 1, r"(lost at [\d.]+ s: collision with wall)"),
        (
            "freeze",
            1,
            r"(frozen at [\d.]+ s by collision with wall, and nobody is left to say run)",
        ),
        ("call", 0, ""),
    ],
)
def test_a_run_ends_with_an_exit_code_that_says_whether_a_collision_ended_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], how: str, code: int, told: str
) -> None:
    path = str(wall_ahead(tmp_path, how))
    assert run_boat(RunOptions(exercise=path, headless=True, speed=math.inf)) == code

    said = capsys.readouterr()
    assert not code or re.search(rf"^trainer: {told}$", said.err, re.MULTILINE)
    assert how != "end" or re.search(rf"^outcome +{told}", said.out, re.MULTILINE)


def test_a_freeze_after_a_collision_is_not_that_of_the_collision(crewed: Begin) -> None:
    ship = shallow(crewed(seconds=None, world=tables(WALL.format(what="freeze"))))
    ship.fly(400)
    ship.order("run")
    ship.order("freeze")

    ship.session._desert()  # noqa: SLF001
    assert ship.session.control.deserted.endswith(" s, and nobody is left to say run")


def test_a_boat_by_call_tells_the_collision_that_stops_it(tmp_path: Path) -> None:
    ended = Boat(exercise=wall_ahead(tmp_path, "end"))
    before = ended.snapshot()
    with pytest.raises(ConfigError, match=r"frozen at [\d.]+ s: collision with wall$"):
        ended.run()
    assert ended.lost == "collision with wall"
    with pytest.raises(ConfigError, match="cannot go on: collision with wall"):
        ended.run()
    ended.restore(before)
    assert ended.lost == ""

    stopped = Boat(exercise=wall_ahead(tmp_path, "freeze"))
    with pytest.raises(ConfigError, match=r"by collision with wall; run\(\) goes on$"):
        stopped.run()
    stopped.run()
    assert stopped.time == 300.0


CROSSED = """
schema = "exercise/1"
name = "Crossed"
briefing = "A ferry crosses."
duration_s = 300
[initial]
speed_kn = 6
depth_m = 60
[[contact]]
name = "ferry"
type = "ferry"
points = [[500, 600]]
course_deg = 270
speed_kn = 6
[limits]
cpa_m_min = 200
[[scores]]
name = "Kept clear"
measure = "closest-approach"
full = 1000
zero = 300
"""


@pytest.mark.process
def test_a_recorded_run_is_replayed_and_debriefed(tmp_path: Path) -> None:
    """At 3.09 m/s each on crossing courses, the ferry 100 m further off: 71 m at the closest."""
    (tmp_path / "x.toml").write_text(CROSSED)
    (tmp_path / "o.txt").write_text("200 contact add late tug at 900 0 course 000 speed 3\n")
    for words in (
        ("run", "./x.toml", *RUN, "--orders", "o.txt", "--record", "r.trainer"),
        ("replay", "r.trainer"),
        ("debrief", "r.trainer", "--html", "d.html", "--json"),
    ):
        done = run_trainer(*words, cwd=tmp_path, env=environment(), timeout=300)
        assert done.returncode == 0, (words, done.stdout, done.stderr)
    page = (tmp_path / "d.html").read_text(encoding="utf-8")
    assert "closest approach" in page
    told = json.loads(done.stdout)
    closest = {each["name"]: each["closest_m"] for each in told["ships"]}
    assert closest["ferry"] == pytest.approx(71.0, abs=3.0)
    assert "late" in closest
    assert told["scores"][0]["value"] == pytest.approx(closest["ferry"])
    assert "late" in page
