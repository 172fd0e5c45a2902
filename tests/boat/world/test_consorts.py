"""The other boats of a class as ships: seen while they are up, touched where they are."""

import tracemalloc
from pathlib import Path

from helpers.orders import read_order
from helpers.sessions import start_exercise

from trainer.boat.boat import Boat
from trainer.boat.helm import obey_order
from trainer.boat.world.contacts import ContactState, contacts_in
from trainer.boat.world.encounters import EncounterMonitor
from trainer.boat.world.hulls import OwnHull, Pose
from trainer.boat.world.scope import periscope_of
from trainer.boat.world.ship_force import MAX_PULLING_SHIPS
from trainer.config.exercise.class_file import DEPTH_ERROR_M, PLACE_ERROR_M

HEAD = 'schema = "exercise/1"\nname = "Boats"\nbriefing = "Boats."\nduration_s = 1200\n'
KEEL, TOP = 4.83, 11.37  # [m] of bb2 below and above its origin


def at_sea(folder: Path, depth: float = 17.5, tables: str = "") -> Boat:
    """Return a boat that goes north at 4 knots."""
    path = folder / "boats.toml"
    path.write_text(f"{HEAD}[initial]\nspeed_kn = 4\ndepth_m = {depth}\n{tables}")
    return start_exercise(path)


def told(boat: Boat, words: str) -> list[ContactState]:
    """Return the ships near after an order that is obeyed."""
    assert obey_order(boat, read_order(words)) == ""
    contacts = contacts_in(boat)
    assert contacts is not None
    return [*contacts.seen(boat.ticks)]


def in_sight(boat: Boat) -> list[str]:
    """Return what a periscope that is out sees."""
    scope = periscope_of(boat)
    assert scope is not None
    mast = scope.raised(scope.at(boat.ticks))
    return [sight.type for sight in scope.sights(scope.eye(boat.state, mast, 2.0), mast)]


def test_a_boat_is_seen_and_heard_by_radio_while_its_sail_is_out_of_the_water(
    tmp_path: Path,
) -> None:
    boat = at_sea(tmp_path)
    (up,) = told(boat, "contact boat 2 at 2000 0 depth 4 course 090 speed 6")
    assert round(up.mast, 2) == 7.37
    assert (up.mmsi, up.length) == (200_000_002, 70.2)
    assert in_sight(boat) == ["submarine"]
    (down,) = told(boat, "contact boat 2 at 2000 0 depth 12 course 090 speed 6")
    assert (down.mmsi, down.name) == (None, "boat-2")
    assert in_sight(boat) == []
    assert len(told(boat, "contact boat 3 at 3000 0 depth 50 course 090 speed 6")) == 2
    assert told(boat, "contact boats gone") == []


def test_a_boat_is_touched_between_its_keel_and_its_sails_top_and_a_little_beyond(
    tmp_path: Path,
) -> None:
    boat = at_sea(tmp_path)
    told(boat, "contact boat 2 at 0 0 depth 100 course 090 speed 0")
    contacts = contacts_in(boat)
    assert contacts is not None
    (ship,) = contacts.fleet(0).order
    hull = OwnHull.of(boat)

    def touches(depth: float, north: float = 0.0) -> bool:
        return hull.touches(Pose(north, 0.0, depth, 0.0, 0.0, 0.0), ship.body, 0.0, 0.0, 1.5708)

    above, below = 100.0 - TOP - KEEL - DEPTH_ERROR_M, 100.0 + KEEL + TOP + DEPTH_ERROR_M
    assert [touches(above + by) for by in (-0.6, 1.0)] == [False, True]
    assert [touches(below + by) for by in (-1.0, 0.6)] == [True, False]
    abeam = 35.1 + 5.3 + PLACE_ERROR_M
    assert touches(100.0, 0.9 * abeam)
    assert not touches(100.0, 1.5 * abeam)


def test_a_boat_does_not_pull_as_ships_do(tmp_path: Path) -> None:
    boat = at_sea(tmp_path, 25.0, '[contacts]\nforce = "on"\n')
    told(boat, "contact boat 2 at 20 60 depth 4 course 000 speed 12")
    assert boat.world.acts
    boat.tick()
    assert not boat.state.ship_force.any()
    for i in range(MAX_PULLING_SHIPS):
        words = f"contact add s{i} yacht at {20 * i} 60 course 0 speed 8"
        assert f"s{i}" in str(obey_order(boat, read_order(words)))
    boat.tick()
    assert boat.state.ship_force.any()


def test_many_orders_keep_little_in_memory(tmp_path: Path) -> None:
    boat = at_sea(tmp_path, 60.0)
    monitor = EncounterMonitor.over(boat)
    tracemalloc.start()
    for i in range(150):
        told(boat, f"contact boat 2 at {3000 + i} 0 depth 50 course 0 speed 5")
        boat.tick()
        monitor.look(boat)
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert most < 1e6
