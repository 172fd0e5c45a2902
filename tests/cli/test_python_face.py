"""The Python face: the same bits and the same words as the command line, and next to no cost."""

import ast
import copy
import json
import math
import pickle
import platform
import sys
import threading
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from helpers.installation import run_program
from helpers.nursery import Done, run_trainer
from helpers.places import PACKAGES, environment
from numpy.typing import NDArray

import trainer
from trainer.cli.main import cli
from trainer.config.files import ConfigError
from trainer.config.ship.series import load_series
from trainer.session.past.header import open_whole_recording
from trainer.session.replay import replay_anyway
from trainer.session.session import Session

ORDERS = ((0, "depth 80"), (60, "rudder left 20"), (90, "rudder meet"), (200, "course 300"))


def typed(*words: object, folder: Path) -> Done:
    """Run a command of the trainer in a folder."""
    return run_trainer(*map(str, words), cwd=folder, env=environment(), timeout=300)


def headless(folder: Path, *words: object) -> None:
    """Fly a headless run at full speed."""
    done = typed("run", "--headless", "--speed", "max", *words, folder=folder)
    assert done.returncode == 0, done.stderr


def order_at_times(boat: trainer.Boat, until: float) -> None:
    """Give the orders at their times, and run to the end [s]."""
    for seconds, words in ORDERS:
        if seconds > boat.time:
            boat.run(seconds - boat.time)
        boat.order(words)
    boat.run(until - boat.time)


def same(one: dict[str, NDArray[np.float64]], other: dict[str, NDArray[np.float64]]) -> bool:
    """Return whether columns are the same to the bit."""
    return one.keys() == other.keys() and all(
        one[name].tobytes() == other[name].tobytes() for name in one
    )


# What it costs, and what is there


@pytest.mark.process
def test_importing_the_trainer_imports_nothing_else() -> None:
    code = "import sys; before = set(sys.modules); import trainer; print(set(sys.modules) - before)"
    done = run_program([sys.executable, "-S", "-c", code], env=environment())

    assert ast.literal_eval(done.stdout) == {"trainer"}


@pytest.mark.process
def test_a_boat_by_call_imports_no_room_that_it_does_not_call() -> None:
    """Each would be paid for at every start: consoles, pages, recordings' exports, a compiler."""
    code = "import sys, trainer; trainer.Boat('bb2'); print([*sys.modules])"
    done = run_program([sys.executable, "-c", code], env=environment())
    modules = ast.literal_eval(done.stdout)
    rooms = [name for name in modules if name.startswith("trainer.")]
    idle = ("cli", "debrief", "report", "analysis", "identify", "authoring", "console", "web")

    assert not [name for name in rooms if name.split(".")[1] in idle]
    assert not {"session.run", "session.rerun", "session.account", "session.doors.ports"} & {
        name.removeprefix("trainer.") for name in rooms
    }
    assert not {"numba", "click", "statistics", "importlib.metadata"} & {*modules}
    assert "llvmlite" not in modules or sys.platform != "linux" or platform.machine() != "x86_64"
    assert len(rooms) <= 264


@pytest.mark.process
def test_garbage_is_collected_after_an_import_as_it_was_before() -> None:
    code = (
        "import gc, trainer; trainer.TrainerError; print(gc.isenabled())\n"
        "gc.disable(); trainer.Boat; print(gc.isenabled())"
    )
    done = run_program([sys.executable, "-c", code], env=environment())
    assert done.stdout.split() == ["True", "False"]


def test_at_most_fifteen_names_are_public_and_all_are_there() -> None:
    assert len(trainer.__all__) <= 15
    for name in trainer.__all__:
        assert getattr(trainer, name).__doc__
        assert name in dir(trainer)
    with pytest.raises(AttributeError, match="no attribute 'Submarine'"):
        _ = trainer.Submarine  # type: ignore[attr-defined]


def test_a_type_checker_is_told_of_every_public_name() -> None:
    tree = ast.parse(Path(PACKAGES, "trainer", "__init__.py").read_text(encoding="utf-8"))
    (told,) = (node for node in tree.body if isinstance(node, ast.If))
    imported = [
        each for node in told.body if isinstance(node, ast.ImportFrom) for each in node.names
    ]

    assert sorted(each.asname or each.name for each in imported) == trainer.__all__


# The same bits


@pytest.mark.process
@pytest.mark.parametrize(
    ("words", "options"),
    [
        (("--sea", "sea-state-4", "--seed", "7"), {"sea": "sea-state-4", "seed": 7}),
        (
            ("--equations", "full", "--integrator", "rk4", "--step", "0.25"),
            {"equations": "full", "integrator": "rk4", "step": 0.25},
        ),
    ],
)
def test_a_boat_by_call_has_the_rows_of_a_headless_run(
    words: tuple[str, ...], options: Any, tmp_path: Path
) -> None:
    schedule = "".join(f"{seconds} {order}\n" for seconds, order in ORDERS)
    (tmp_path / "orders.txt").write_text(schedule, encoding="utf-8")
    told = ("--orders", "orders.txt", "--duration", "600", "--csv", "run.csv")
    headless(tmp_path, *told, *words)
    written = load_series(tmp_path / "run.csv").columns

    boat = trainer.Boat("bb2", **options)
    order_at_times(boat, 600.0)
    scheduled = trainer.Boat("bb2", orders=tmp_path / "orders.txt", **options)
    scheduled.run(600)

    assert same(boat.columns, written)
    assert same(scheduled.columns, written)
    assert boat.state == scheduled.state


@pytest.mark.process
def test_an_exercise_by_call_is_recorded_as_by_a_headless_run(tmp_path: Path) -> None:
    headless(tmp_path, "stern-plane-jam", "--seed", 3, "--record", "one.trainer")
    with trainer.Boat(exercise="stern-plane-jam", seed=3, record=tmp_path / "two.trainer") as boat:
        boat.run()

    one, two = (trainer.read_recording(tmp_path / f"{name}.trainer") for name in ("one", "two"))
    for clocked in ("lateness_ns", "work_ns"):
        del one.columns[clocked], two.columns[clocked]
    assert same(one.columns, two.columns)
    assert one.orders == two.orders
    assert [each["text"] for each in two.events] == [each["text"] for each in boat.events]
    assert {name: values[-1] for name, values in two.columns.items() if name in boat.state} == {
        name: value for name, value in boat.state.items() if name in two.columns
    }


# Going back


def test_a_moment_gone_back_to_goes_on_as_it_did_also_while_a_swing_is_being_met() -> None:
    boat = trainer.Boat(sea="sea-state-5", speed=12)
    boat.order("rudder left 20")
    boat.run(40)
    boat.order("rudder meet")
    before = boat.snapshot()
    orders, events = boat.orders, boat.events
    boat.run(200)
    state, columns = boat.state, boat.columns
    assert boat.orders[-1]["text"] == "rudder amidships"  # the swing was met

    boat.restore(before)

    assert boat.time == before.time == 40.0
    assert boat.orders == orders
    assert boat.events == events
    assert boat.columns["t"][-1] == 40.0
    boat.run(200)
    assert boat.state == state
    assert same(boat.columns, columns)


def test_a_later_moment_has_its_ships_and_its_words_again_after_an_earlier_one() -> None:
    boat = trainer.Boat()
    boat.run(1)
    first = boat.snapshot()
    boat.order("contact add blue tug at 500 200 course 090 speed 5")
    boat.order("order course 045")
    boat.run(1)
    later = boat.snapshot()
    boat.restore(first)

    boat.restore(later)

    assert boat.order("contact blue course 180") == "contact blue course 180"
    assert boat.order("belay") == "no longer ordered: course 045"


def test_a_recording_by_call_replays_to_the_bit_with_its_branches(tmp_path: Path) -> None:
    with trainer.Boat(record=tmp_path / "it.trainer", sea="sea-state-2") as boat:
        boat.run(30)
        before = boat.snapshot()
        boat.order("depth 90")
        boat.run(30)
        boat.restore(before)
        boat.order("course 90")
        boat.run(30)
        assert [each["text"] for each in boat.orders] == ["course 090"]

    with open_whole_recording(tmp_path / "it.trainer") as recording:
        flights = replay_anyway(recording)
    assert len(flights) == 2
    assert all(flight.same for flight in flights)
    assert trainer.read_recording(tmp_path / "it.trainer").branch == 2


def test_a_boat_that_is_closed_can_be_read_and_not_run(tmp_path: Path) -> None:
    with trainer.Boat(record=tmp_path / "it.trainer") as boat:
        boat.order("depth 70")
        boat.run(20)
    boat.close()

    assert [each["text"] for each in boat.orders] == ["depth 70 m"]
    assert boat.columns["t"][-1] == boat.time == 20.0
    for call in (lambda: boat.run(1), lambda: boat.order("depth 60")):
        with pytest.raises(trainer.TrainerError, match="this boat is closed"):
            call()


def test_a_boat_that_is_lost_says_so_and_can_go_back() -> None:
    boat = trainer.Boat(depth=400.0)
    boat.order("stern planes dive 10")
    before = boat.snapshot()

    with pytest.raises(trainer.TrainerError, match=r"frozen at .* s: collapse at 450 m"):
        boat.run(900)
    with pytest.raises(trainer.TrainerError, match="cannot go on: collapse"):
        boat.run(900)
    assert boat.lost

    boat.restore(before)
    boat.order("depth 250")
    boat.run(60)
    assert not boat.lost


def test_a_boat_takes_one_call_at_a_time_and_no_row_is_lost(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    boat = trainer.Boat()
    before = boat.snapshot()
    begun, told, real = threading.Event(), threading.Event(), Session.run

    def run_slowly(session: Session) -> None:
        begun.set()
        told.wait(60.0)
        real(session)

    monkeypatch.setattr(Session, "run", run_slowly)
    other = threading.Thread(target=boat.run, args=(60.0,))
    other.start()
    try:
        assert begun.wait(60.0)
        calls: tuple[Callable[[], object], ...] = (
            lambda: boat.run(60.0),
            lambda: boat.order("depth 80"),
            lambda: boat.columns,
            lambda: boat.orders,
            lambda: boat.restore(before),
            boat.snapshot,
            boat.close,
        )
        for call in calls:
            with pytest.raises(trainer.TrainerError, match="another thread is at this boat"):
                call()
    finally:
        told.set()
        other.join(60.0)

    boat.run(60.0)
    assert boat.time == 120.0
    assert boat.columns["t"].tolist() == [0.5 * tick for tick in range(241)]


# The same words


@pytest.mark.process
@pytest.mark.parametrize(
    ("words", "options"),
    [
        (("--vessel", "bb3"), {"vessel": "bb3"}),
        (("--vessel", "./nix.toml"), {"vessel": "./nix.toml"}),
        (("perisc",), {"exercise": "perisc"}),
        (("--sea", "storm"), {"sea": "storm"}),
        (("--orders", "nix.txt"), {"orders": "nix.txt"}),
        (("--integrator", "bdf3", "--step", "2"), {"integrator": "bdf3", "step": 2.0}),
    ],
)
def test_what_is_wrong_is_told_in_the_command_line_s_words(
    words: tuple[str, ...], options: Any, tmp_path: Path
) -> None:
    flight = ("run", "--headless", "--speed", "max", "--duration", "1", *words)
    done = typed(*flight, folder=tmp_path)

    with pytest.raises(trainer.TrainerError) as wrong:
        trainer.Boat(**options)

    assert done.returncode == 2
    assert "\n" not in str(wrong.value)
    assert done.stderr.partition(" (trainer run --help")[0].strip() == f"trainer: {wrong.value}"


fit = partial(trainer.identify_ship, "nix.trainer")
turn = partial(trainer.manoeuvre, "turn")
fleet = partial(trainer.Fleet, "bb2", 2, orders=["stern"], reads=["z"])


@pytest.mark.parametrize(
    ("call", "options", "told"),
    [
        (trainer.Boat, {"speed": -1.0}, "Boat: speed = -1.0: must be 0.001 to 60 kn"),
        (trainer.Boat, {"depth": math.nan}, "Boat: depth = nan: must be finite, 0 to 12000 m"),
        (
            trainer.Boat,
            {"depth": 5000},
            "Boat: depth = 5000 m: must be less than collapse_depth_m = 450 m",
        ),
        (trainer.Boat, {"course": "north"}, "Boat: course = "),
        (trainer.Boat, {"equations": "ful"}, 'Boat: equations = "ful": must be full or mod'),
        (trainer.Boat, {"step": 30}, "Boat: step = 30: must be 0.001 to 2 s"),
        (trainer.Boat, {"seed": -1}, "Boat: seed = -1: must be a whole number, 0 to "),
        (trainer.Boat, {"sea": 5}, "Boat: sea = 5: must be a name or a path"),
        (
            trainer.Boat,
            {"speeed": 5},
            "no keyword 'speeed'; nearest is speed; there are battery, course, ",
        ),
        (trainer.Boat, {"unsafe_stp": "yes"}, "no keyword 'unsafe_stp'; nearest is unsafe_step"),
        (trainer.Boat, {"speed": 5, "record": "a.trainer"}, "record=: a recorded run begins as"),
        (
            trainer.manoeuvre,
            {"name": "turning-circl"},
            "no manoeuvre 'turning-circl'; nearest is t",
        ),
        (turn, {"direction": "up"}, 'manoeuvre: direction = "up": must be rise or'),
        (turn, {"angle": 91}, "manoeuvre: angle = 91: must be 0 to 90 deg"),
        (turn, {"angel": 9}, "no keyword 'angel'; nearest is angle"),
        (turn, {"csv": "x"}, "no keyword 'csv'"),
        (turn, {"execute": 9}, "--execute: turn has no such parameter"),
        (turn, {"vessel": "bb3"}, 'no vessel "bb3"; nearest is bb2'),
        (trainer.sweep, {"study": "turn-uncertain"}, 'no study "turn-uncertain"'),
        (fit, {"modell": "1"}, "no keyword 'modell'; nearest is model"),
        (fit, {"model": "7"}, 'identify_ship: model = "7": must be 1 or 2'),
        (fleet, {"spede": 5}, "no keyword 'spede'; nearest is speed; there are battery, c"),
        (fleet, {"exercise": "depth-changes"}, "no keyword 'exercise'; there are battery"),
        (fit, {"model": "nomoto1", "vessel": "bb2"}, "nix.trainer: "),
    ],
)
def test_a_wrong_keyword_is_told_with_what_is_right(
    call: Callable[..., object], options: Any, told: str
) -> None:
    with pytest.raises(ConfigError) as wrong:
        call(**options)

    assert str(wrong.value).startswith(told)


@pytest.mark.parametrize(
    ("words", "told"),
    [
        ("dephts 80", '"dephts" is no order; did you mean depth?'),
        ("rudder left 50", "the limit of the rudder is 30 degrees, not 50"),
        ("quit", "quit: is an order of a session; here time and moments are the calls run()"),
        ("# nothing", "no order: say one, such as depth 80"),
    ],
)
def test_a_refused_order_is_told_in_the_console_s_words(words: str, told: str) -> None:
    boat = trainer.Boat()
    state = boat.state

    with pytest.raises(trainer.TrainerError) as refused:
        boat.order(words)

    assert str(refused.value).startswith(told)
    assert boat.state == state


def test_what_an_exercise_has_in_hand_is_refused_as_at_the_console() -> None:
    boat = trainer.Boat(exercise="depth-changes")
    with pytest.raises(trainer.TrainerError, match="the planes are in hand in this exercise"):
        boat.order("depth 80")
    assert boat.order("stern planes rise 2") == "stern planes rise 2, by hand"


@pytest.mark.parametrize(
    ("call", "told"),
    [
        (lambda boat: boat.order(5), "order(): an order is text, such as 'depth 80', not int"),
        (lambda boat: boat.run("5"), "run(): give a number of seconds, such as run(900), not str"),
        (lambda boat: boat.run(10**400), "run(1000000000"),
        (lambda boat: boat.run(10**5000), "run((too long to show)): a run lasts longer than 0 s"),
        (lambda boat: boat.run(0.0), "run(0.0): a run lasts longer than 0 s, and ends"),
        (lambda boat: boat.run(math.nan), "run(nan): a run lasts longer than 0 s, and ends"),
        (lambda boat: boat.run(), "say run(seconds)"),
        (lambda boat: boat.restore(5), "restore: this is no snapshot"),
        (lambda boat: boat.restore(trainer.Boat().snapshot()), "another boat"),
    ],
)
def test_what_a_boat_cannot_be_given_is_told_in_one_line(
    call: Callable[[Any], object], told: str
) -> None:
    boat = trainer.Boat()

    with pytest.raises(trainer.TrainerError) as wrong:
        call(boat)

    assert told in str(wrong.value)
    assert "\n" not in str(wrong.value)
    boat.run(1)
    assert boat.time == 1.0


# Recordings and frames


def test_a_recording_that_is_none_or_a_column_that_is_none_is_told(tmp_path: Path) -> None:
    with pytest.raises(trainer.TrainerError, match="No such file"):
        trainer.read_recording(tmp_path / "nix.trainer")
    with trainer.Boat(record=tmp_path / "it.trainer") as boat:
        boat.run(2)
    with pytest.raises(trainer.TrainerError, match="has no branch 4"):
        trainer.read_recording(tmp_path / "it.trainer", branch=4)
    with pytest.raises(trainer.TrainerError, match='no column "deltar"; nearest is delta_r'):
        _ = trainer.read_recording(tmp_path / "it.trainer")["deltar"]
    with pytest.raises(trainer.TrainerError, match="is an input here; give another name"):
        trainer.Boat(record=tmp_path / "it.trainer")


def test_a_frame_has_the_columns_by_time_and_asks_for_pandas(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    boat = trainer.Boat()
    boat.run(10)
    frame = boat.frame()
    assert frame.index.name == "t"
    assert frame["z"].to_numpy().tobytes() == boat.columns["z"].tobytes()

    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(trainer.TrainerError, match=r"pip install 'submarine-trainer\[pandas\]'"):
        boat.frame()


# Manoeuvres and sweeps


def test_a_manoeuvre_by_call_is_that_of_the_command() -> None:
    told = CliRunner().invoke(
        cli, ["manoeuvre", "meander", "bb2", "--dive", "--angle", "5", "--json"]
    )

    turn = trainer.manoeuvre("meander", "bb2", direction="dive", angle=5)

    assert turn.as_json() == json.loads(told.stdout)
    assert all(
        turn.figures[each["name"]].unit == each["unit"] for each in turn.as_json()["measures"]
    )
    assert turn.columns["t"].size == turn.columns["z"].size


def test_a_sweep_by_call_is_that_of_the_command_and_keeps_nothing_unasked(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    study = trainer.sweep("turn-uncertainty", members=3)
    assert not list(tmp_path.iterdir())

    kept = trainer.sweep("turn-uncertainty", members=3, out="it.parquet")

    assert list(tmp_path.glob("it.parquet"))
    assert study.columns["member"].tolist() == [0, 1, 2]
    for name in study.figures:
        assert study.columns[name].tobytes() == kept.columns[name].tobytes()
        assert study.figures[name].mean == pytest.approx(study.columns[name].mean())


def test_what_is_shipped_is_listed_by_name() -> None:
    assert trainer.vessels()["remus100"].startswith("REMUS 100")
    assert trainer.seas()["sea-state-4"] == "Sea state 4, moderate"
    listed = json.loads(CliRunner().invoke(cli, ["exercises", "--json"]).stdout)
    assert list(trainer.exercises().items()) == list(listed.items())


COPIES = {
    "copy": copy.copy,
    "deepcopy": copy.deepcopy,
    "pickle": lambda boat: pickle.loads(pickle.dumps(boat)),  # noqa: S301  our own
}


@pytest.mark.parametrize("way", COPIES.values(), ids=COPIES)
@pytest.mark.parametrize("exercise", ["crossing-traffic", "heavy-boat", "stern-plane-jam"])
def test_a_copy_flies_on_as_its_boat_and_neither_moves_the_other(
    exercise: str, way: Callable[[trainer.Boat], trainer.Boat], tmp_path: Path
) -> None:
    boat = trainer.Boat(exercise=exercise, sea="sea-state-4", record=tmp_path / "it.trainer")
    boat.run(20)
    boat.order("stern planes dive 4")
    boat.run(40)
    boat.order("order depth 70")
    boat.order("rudder left 5")
    here = boat.state
    twin = way(boat)
    assert (twin.state, twin.time, twin.events) == (here, boat.time, boat.events)
    for each in (twin, boat):
        each.run(30)
        each.order("rudder right 10")
        each.run(60)
    assert (twin.state, twin.lost) == (boat.state, boat.lost)
    assert all((twin.columns[name] == boat.columns[name]).all() for name in boat.columns)
    assert [each["text"] for each in twin.orders] == [each["text"] for each in boat.orders]
    there = boat.state
    twin.run(10)
    assert boat.state == there
    boat.close()
    with pytest.raises(trainer.TrainerError, match="closed"):
        way(boat)
