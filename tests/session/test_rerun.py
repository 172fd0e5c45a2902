"""Rerun's library and viewer given a run: as a file, live, and looked at.

The library is half a gigabyte and no part of what a developer installs; without it, or without the
drivers that draw a picture on no screen, these tests are skipped. `pip install rerun-sdk`, and
`apt-get install mesa-vulkan-drivers libvulkan1 libxkbcommon-x11-0 libgl1-mesa-dri` have them run.
`TRAINER_PICTURES=1` renews the picture of the documents.
"""

import contextlib
import math
import os
import signal
import socket
import subprocess
import time
import warnings
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.nursery import Done, run_trainer, start_trainer
from helpers.places import ROOT
from helpers.waiting import await_that

from trainer.config.files import ConfigError
from trainer.debrief.passage.recording_export import export_file
from trainer.io.recording.recording import Recording
from trainer.session.past.layout import LAYOUT
from trainer.units import KNOT

pytestmark = pytest.mark.process

rerun = pytest.importorskip("rerun", reason="rerun-sdk is not installed: half a gigabyte")
chunks = pytest.importorskip("rerun.chunk")

HERE = dict(os.environ)
HEADLESS = ("run", "stern-plane-jam", "--headless", "--no-record")
PATIENCE = 60.0  # [s]
PICTURE = ROOT / "docs" / "images" / "rerun.png"
LARGEST = 300_000  # [bytes] of a picture in the documents
ORDERS = "20 course 060\n62 sea state 4\n"

Columns = dict[str, dict[str, Any]]


@pytest.fixture(scope="module")
def private(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """Return an environment in which the viewer has a home of its own, and reports no usage."""
    home = tmp_path_factory.mktemp("home")
    cache = os.environ.get("XDG_CACHE_HOME") or str(Path.home() / ".cache")
    private = os.environ | {"HOME": str(home), "XDG_CACHE_HOME": cache, "RUST_LOG": "off"}
    tool("analytics", "disable", environment=private)
    return private


def trainer(*words: str, **more: Any) -> Done:
    """Return the trainer's program, run to its end."""
    return run_trainer(*words, timeout=PATIENCE, **{"env": HERE, **more})


def viewer() -> str:
    """Return the path of the viewer itself: the command in the path is a script that starts it."""
    import rerun_cli  # noqa: PLC0415

    return str(Path(rerun_cli.__file__).parent / "rerun")


def tool(*words: str, environment: dict[str, str]) -> Done:
    """Return the viewer's program, run to its end."""
    return subprocess.run(
        [viewer(), *words],
        env=environment,
        capture_output=True,
        text=True,
        timeout=PATIENCE,
        check=False,
    )


@pytest.fixture(scope="module")
def flown(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with one run: recorded, and written for Rerun live and by export."""
    folder = tmp_path_factory.mktemp("flown")
    (folder / "orders.txt").write_text(ORDERS)
    words = ("run", "stern-plane-jam", "--headless", "--speed", "max", "--duration", "140")
    files = ("--record", folder / "run.trainer", "--rrd", folder / "live.rrd")
    done = trainer(*words, "--orders", str(folder / "orders.txt"), *map(str, files))
    assert (done.returncode, done.stderr) == (0, "")
    export_file(folder / "run.trainer", {"rrd": folder / "exported.rrd"}, None)
    return folder


def contents(path: Path) -> Columns:
    """Return what a file holds: by entity and component, the value at each time."""
    found: Columns = {}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # a viewer that is ended leaves a file without its index
        reader = chunks.RrdReader(str(path))
    for chunk in reader.stream().to_chunks():
        batch = chunk.to_record_batch()
        table = {name: batch.column(name) for name in batch.schema.names}
        when = table.get("time")
        times = [None] * batch.num_rows if when is None else when.cast("int64").to_pylist()
        for name, values in table.items():
            if ":" in name:
                rows = found.setdefault(chunk.entity_path, {}).setdefault(name, {})
                rows |= dict(zip(times, values.to_pylist(), strict=True))
    return {path: parts for path, parts in found.items() if not path.startswith("/__")}


def recorded(path: Path) -> dict[str, np.ndarray]:
    """Return each number of the recorded states by its name, one for each tick."""
    with contextlib.closing(Recording.look(path)) as recording:
        whole = np.stack([np.frombuffer(tick.state) for tick in recording.flown(1)])
    return dict(zip(LAYOUT, whole.T, strict=True))


def column(found: Columns, path: str, ends: str) -> dict[float, Any]:
    """Return a component of an entity by the time [s]."""
    (name,) = (name for name in found[path] if name.endswith(ends))
    rows = found[path][name].items()
    return dict(sorted((when / 1e9, value) for when, value in rows if when is not None))


def comparable(found: Any) -> Any:
    """Return what a file holds with its NaN as a word, since no NaN is the same as another."""
    if isinstance(found, Mapping):
        return {name: comparable(each) for name, each in found.items()}
    if isinstance(found, list):
        return [comparable(each) for each in found]
    return "nan" if isinstance(found, float) and math.isnan(found) else found


# Files


def test_rerun_accepts_the_files(flown: Path, private: dict[str, str]) -> None:
    paths = [str(flown / name) for name in ("live.rrd", "exported.rrd")]

    done = tool("rrd", "verify", *paths, environment=private)

    assert done.returncode == 0, done.stderr
    assert "2 files verified without error" in done.stdout + done.stderr


def test_a_file_written_while_the_run_goes_on_is_that_of_its_recording(flown: Path) -> None:
    live, exported = contents(flown / "live.rrd"), contents(flown / "exported.rrd")

    assert comparable(live) == comparable(exported)


def test_every_tick_of_the_recording_is_in_the_file_to_its_resolution(flown: Path) -> None:
    state = recorded(flown / "run.trainer")
    found = contents(flown / "exported.rrd")

    place = column(found, "/world/boat", ":translation")
    depth = column(found, "/charts/depth_m", ":scalars")
    attitude = column(found, "/charts/attitude_deg", ":scalars")

    assert list(place) == [0.5 * tick for tick in range(281)]
    expected = np.stack([state["x"], state["y"], state["z"]], axis=1)
    assert np.array([row[0] for row in place.values()]) == pytest.approx(expected, rel=1e-6)
    assert [row[0] for row in depth.values()] == (-state["z"]).tolist()  # downwards
    pitch = [row[0] for row in attitude.values()]
    assert pitch == pytest.approx(np.degrees(state["theta"]).tolist(), rel=1e-14)


def test_the_boat_is_turned_as_her_angles_say(flown: Path) -> None:
    state = recorded(flown / "run.trainer")
    phi, theta, psi = state["phi"], state["theta"], state["psi"]
    turned = column(contents(flown / "exported.rrd"), "/world/boat", ":quaternion")

    x, y, z, w = np.array([row[0] for row in turned.values()]).T

    forward = np.stack((1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)))
    expected = np.stack(
        (np.cos(theta) * np.cos(psi), np.cos(theta) * np.sin(psi), -np.sin(theta))
    )  # where the bow points, north, east and down
    assert forward == pytest.approx(expected, abs=1e-6)
    down_to_starboard = 2 * (y * z + x * w)  # of the starboard axis
    assert down_to_starboard == pytest.approx(np.cos(theta) * np.sin(phi), abs=1e-6)


def test_orders_casualties_and_calls_are_in_the_log_and_in_lanes(flown: Path) -> None:
    found = contents(flown / "exported.rrd")
    texts = {
        text[0]
        for path in found
        if path.startswith("/log/")
        for text in column(found, path, ":text").values()
    }
    jam = column(found, "/lanes/stern-hard-over", ":state")

    assert "20 s: keeping course 060" in texts
    assert any("LIMIT: " in text for text in texts)
    assert ["acting"] in jam.values()
    assert min(when for when, word in jam.items() if word == ["acting"]) == 66.5  # by its seed


def test_the_sea_the_ordered_depth_and_the_limit_are_drawn(flown: Path) -> None:
    state = recorded(flown / "run.trainer")
    found = contents(flown / "exported.rrd")
    level = column(found, "/world/near/sea", ":translation")
    ordered = column(found, "/world/near/ordered", ":strips")

    assert len(level) > 50  # it moves once there is a sea
    for when, ((_, _, down),) in level.items():
        assert down == pytest.approx(-state["eta_wave"][round(2 * when)], rel=1e-6)
    assert next(iter(ordered.values()))[0][0][2] == 100.0
    assert "/world/near/limit" in found


AROUND = """
schema = "exercise/1"
name = "Around"
briefing = "A slope and two ships."
duration_s = 60
[bottom]
depth_m = 150
slope_percent = 10
deepens_deg = 90
[[contact]]
name = "liner"
type = "ferry"
points = [[2000, 0]]
course_deg = 90
speed_kn = 18
"""


def test_ships_the_ground_near_and_the_periscope_s_mast_are_drawn(tmp_path: Path) -> None:
    (tmp_path / "around.toml").write_text(AROUND)
    order = "30 contact add tug1 tug at 500 -500 course 180 speed 6\n"
    (tmp_path / "orders.txt").write_text(f"10 scope raise\n{order}40 scope lower\n")
    words = ("run", "./around.toml", "--headless", "--speed", "max", "--orders", "orders.txt")
    done = trainer(*words, "--record", "run.trainer", "--rrd", "live.rrd", cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    export_file(tmp_path / "run.trainer", {"rrd": tmp_path / "exported.rrd"}, None)
    found = contents(tmp_path / "exported.rrd")
    assert comparable(contents(tmp_path / "live.rrd")) == comparable(found)

    mast = column(found, "/world/boat/mast", ":translation")
    (head,) = found["/world/boat/mast/shape"]["Mesh3D:vertex_positions"].values()
    assert min(point[2] for point in head) == pytest.approx(-8.0)  # all that it comes out
    down = mast[0.0][0][2]
    assert mast[0.0][0][0] == 6.0
    out = [down - mast[when][0][2] for when in (14.0, 18.0, 42.0, 48.0)]
    assert out == pytest.approx([4.0, 8.0, 6.0, 0.0], abs=1e-5)
    assert set(mast) == {0.0, *np.arange(10.5, 18.5, 0.5), *np.arange(40.5, 48.5, 0.5)}

    ships = column(found, "/world/ships", ":positions")
    assert list(ships)[:3] == [0.0, 1.0, 2.0]
    (liner,), (later, tug) = ships[29.0], ships[60.0]
    assert liner == pytest.approx([2000.0, 29.0 * 18.0 * KNOT, 0.0])
    assert later[1] == pytest.approx(60.0 * 18.0 * KNOT)
    assert tug == pytest.approx([500.0 - 180.0 * KNOT, -500.0, 0.0])
    labels = column(found, "/world/ships", ":labels")
    assert labels[60.0] == ["liner 090 18.0 kn", "tug1 180 6.0 kn"]
    arrows = column(found, "/world/ships/courses", ":vectors")
    assert arrows[60.0][1] == pytest.approx([-360.0 * KNOT, 0.0, 0.0], abs=1e-3)

    near = column(found, "/world/near", ":translation")
    ground = column(found, "/world/near/ground", ":vertex_positions")
    assert ground.keys() == near.keys()
    for when, points in ground.items():
        east = near[when][0][1]
        for point in points[::50]:
            assert point[2] == pytest.approx(150.0 + 0.1 * (east + point[1]), rel=1e-5)


def test_a_run_wound_back_is_one_file_whose_time_goes_on(tmp_path: Path) -> None:
    words = ("run", "--speed", "max", "--teletype", "--rrd", "run.rrd", "--record", "run.trainer")
    orders = "freeze\nstep 10\nsnapshot ten\nstep 10\nrestore ten\nstep 4\nquit\n"

    done = trainer(*words, "--frozen", input=orders, cwd=tmp_path)

    assert done.returncode == 0, done.stderr
    run = column(contents(tmp_path / "run.rrd"), "/lanes/run", ":state")
    assert run == {0.0: ["branch 1"], 10.5: ["branch 2"]}
    ticks = column(contents(tmp_path / "run.rrd"), "/world/boat", ":translation")
    assert list(ticks) == [0.5 * tick for tick in range(26)]


def test_a_file_that_cannot_be_written_is_told_before_the_run(tmp_path: Path) -> None:
    path = tmp_path / "missing" / "run.rrd"

    done = trainer(*HEADLESS, "--speed", "max", "--rrd", str(path))

    assert done.returncode == 2
    assert f"--rrd {path}: No such file or directory" in done.stderr


def test_a_recording_is_not_exported_onto_nothing(flown: Path, tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="No such file or directory"):
        export_file(flown / "run.trainer", {"rrd": tmp_path / "missing" / "run.rrd"}, None)
    kept = tmp_path / "kept.rrd"
    kept.write_text("here")
    with pytest.raises(ConfigError, match="no branch 7"):
        export_file(flown / "run.trainer", {"rrd": kept}, 7)
    assert kept.read_text() == "here"


# The viewer


def free_port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as server:
        return int(server.getsockname()[1])


@pytest.fixture
def shown(private: dict[str, str], tmp_path: Path) -> Iterator[Callable[..., Any]]:
    """Return a function that starts a viewer without a window, and says where it listens."""
    with contextlib.ExitStack() as started:

        def begin(*words: str) -> "tuple[subprocess.Popen[bytes], str]":
            port = free_port()
            process = subprocess.Popen(
                [viewer(), *words, "--bind", "127.0.0.1", "--port", str(port)],
                env=private,
                cwd=tmp_path,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
            )
            started.enter_context(process)
            started.callback(process.kill)
            until = time.monotonic() + PATIENCE
            while True:
                with contextlib.suppress(OSError):
                    socket.create_connection(("127.0.0.1", port), 1.0).close()
                    return process, f"127.0.0.1:{port}"
                assert time.monotonic() < until

        yield begin


def sail(where: str, *words: str) -> "subprocess.Popen[str]":
    """Return a run that is shown at a viewer."""
    return start_trainer(
        *HEADLESS,
        "--rerun-at",
        where,
        *words,
        env=HERE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )


def test_a_viewer_is_shown_every_tick(shown: Callable[..., Any], tmp_path: Path) -> None:
    process, where = shown("--save", "seen.rrd")

    with sail(where, "--speed", "max", "--duration", "100") as run:
        _, err = run.communicate(timeout=PATIENCE)
    process.send_signal(signal.SIGINT)
    process.wait(PATIENCE)

    assert run.returncode == 0
    assert err == ""
    depth = column(contents(tmp_path / "seen.rrd"), "/charts/depth_m", ":scalars")
    assert list(depth) == [0.5 * tick for tick in range(201)]


def test_a_viewer_that_is_not_there_is_one_line() -> None:
    windowless = {name: text for name, text in HERE.items() if "DISPLAY" not in name}
    port = free_port()
    words = ("--speed", "max", "--duration", "5", "--rerun-at", f":{port}")

    done = trainer(*HEADLESS, *words, env=windowless)

    assert done.returncode == 0
    (told,) = done.stderr.splitlines()
    assert f"start one: rerun --bind 127.0.0.1 --port {port}" in told


@pytest.mark.skipif(os.name != "posix", reason="a shell stands in for the window")
def test_where_there_is_a_screen_a_viewer_is_opened_and_stays(
    private: dict[str, str], tmp_path: Path
) -> None:
    stand_in = tmp_path / "rerun"  # what is opened, with a file in place of its window
    stand_in.write_text(f'#!/bin/sh\necho $$ >pid\nexec {viewer()} --save seen.rrd "$@"\n')
    stand_in.chmod(0o755)
    screen = HERE | {"HOME": private["HOME"], "DISPLAY": ":0", "RERUN_CLI_PATH": str(stand_in)}
    screen["XDG_CACHE_HOME"] = private["XDG_CACHE_HOME"]
    words = ("--speed", "10", "--duration", "60", "--rerun-at", f":{free_port()}")

    done = trainer(*HEADLESS, *words, env=screen, cwd=tmp_path)
    opened = int((tmp_path / "pid").read_text())
    os.kill(opened, signal.SIGINT)  # it is there
    await_that(lambda: not Path(f"/proc/{opened}").exists())

    assert (done.returncode, done.stderr) == (0, "")
    depth = column(contents(tmp_path / "seen.rrd"), "/charts/depth_m", ":scalars")
    assert list(depth) == [0.5 * tick for tick in range(121)]


@pytest.mark.parametrize(
    ("number", "told"), [("SIGKILL", "it has gone"), ("SIGSTOP", "its end is missing")]
)
def test_a_viewer_that_dies_or_hangs_costs_the_run_one_line(
    shown: Callable[..., Any], number: str, told: str
) -> None:
    process, where = shown("--serve-grpc")

    with sail(where, "--speed", "100", "--duration", "300") as run:
        await_connection(run.pid, where)
        process.send_signal(getattr(signal, number))
        out, err = run.communicate(timeout=PATIENCE)

    assert run.returncode == 0
    assert "simulated   300.0 s" in out
    assert len(err.splitlines()) == 1
    assert told in err


def await_connection(pid: int, where: str) -> None:
    """Wait for a connection that lasts: the first is only a look whether somebody is there."""
    seen = 0

    def lasts() -> bool:
        nonlocal seen
        seen = seen + 1 if connected(pid, where) else 0
        return seen == 12

    await_that(lasts)


def connected(pid: int, where: str) -> bool:
    """Return whether a process holds a connection to a port of this machine."""
    port = f"{int(where.rpartition(':')[2]):04X}"
    with contextlib.suppress(OSError):
        lines = Path(f"/proc/{pid}/net/tcp").read_text().splitlines()[1:]
        return any(line.split()[2].endswith(port) and line.split()[3] == "01" for line in lines)
    return False


# The picture


def drivers() -> bool:
    """Return whether a picture can be drawn on no screen."""
    return bool(list(Path("/usr/share/vulkan/icd.d").glob("lvp_icd*")))


@pytest.mark.skipif(not drivers(), reason="no software Vulkan here: mesa-vulkan-drivers has it")
def test_the_viewer_draws_the_boat_her_charts_and_her_log(
    flown: Path, private: dict[str, str], tmp_path: Path
) -> None:
    image = pytest.importorskip("matplotlib.image")
    path = tmp_path / "seen.png"
    look = ("--headless", "--screenshot-to", str(path), "--window-size", "1600x900")
    with (flown / "exported.rrd").open("rb") as stream:
        subprocess.run(
            [viewer(), "-", *look],
            stdin=stream,
            env=private | {"XDG_RUNTIME_DIR": str(tmp_path)},
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            timeout=PATIENCE,
            check=True,
        )

    pixels = (255 * image.imread(path)[::2, ::2, :3]).astype(int)
    scene, charts = pixels[80:520, 20:940], pixels[80:880, 980:]

    assert share(scene, (167, 74, 0), 20) > 0.0005  # her surfaces, as they are lit
    assert share(scene, (240, 228, 66), 30) > 0.0005  # her track
    assert share(scene, (36, 80, 108), 30) > 0.01  # the sea above
    assert share(charts, (86, 180, 233), 30) > 0.001  # what is true
    assert share(charts, (230, 159, 0), 30) > 0.0005  # what is ordered
    if "TRAINER_PICTURES" in os.environ:
        keep(path)


def share(pixels: np.ndarray, colour: tuple[int, int, int], off: int) -> float:
    """Return the share of the pixels that have a colour, give or take."""
    return float(np.mean(np.abs(pixels - colour).max(axis=-1) < off))


def keep(path: Path) -> None:
    """Keep a picture for the documents, at half its size and with few colours."""
    from PIL import Image  # noqa: PLC0415

    with Image.open(path) as whole:
        size = whole.width // 2, whole.height // 2
        small = whole.convert("RGB").resize(size, Image.Resampling.LANCZOS)
    small.quantize(256, dither=Image.Dither.NONE).save(PICTURE, optimize=True)


def test_the_picture_of_the_documents_is_small() -> None:
    assert PICTURE.stat().st_size < LARGEST
