"""A recording as MCAP: read back by the format's own reader, each message by its schema."""

import contextlib
import json
import shutil
import sqlite3
from datetime import datetime
from functools import cache
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest
from helpers.recorded import record
from mcap.reader import make_reader
from mcap.records import SummaryOffset
from mcap.stream_reader import StreamReader
from scipy.spatial.transform import Rotation

from trainer.config.files import ConfigError
from trainer.debrief.passage.recording_export import export_file, read_recording
from trainer.io.mcap import quaternion_of
from trainer.io.recording.recording import Recording
from trainer.session.past.header import open_whole_recording
from trainer.units import DEGREE


@pytest.fixture(scope="module")
def drill(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a recording of a dive with a turn, and an order that was refused."""
    crew = {10.0: "depth 110", 20.0: "course 315", 30.0: "mark log", 40.0: "rudder right 60"}
    return record(tmp_path_factory.mktemp("drill") / "drill.trainer", "stern-plane-jam", crew)


@cache
def validator(schema: bytes) -> Any:
    """Return what judges messages by a schema, which is sound itself: made once, asked by all."""
    rules = json.loads(schema)
    kind = jsonschema.validators.validator_for(rules)
    kind.check_schema(rules)
    return kind(rules)


@pytest.fixture(scope="module")
def told(drill: Path) -> dict[str, list[tuple[int, Any]]]:
    """Return times [ns] and messages of each topic, all of them as their schemas have it."""
    out = drill.with_suffix(".mcap")
    export_file(drill, {"mcap": out}, None)
    found: dict[str, list[tuple[int, Any]]] = {}
    with out.open("rb") as file:
        for schema, channel, message in make_reader(file).iter_messages():
            assert schema
            words, rules = json.loads(message.data), validator(schema.data)
            rules.validate(words)
            assert set(words) == set(rules.schema["properties"])
            stamp = words["timestamp"]
            assert stamp["sec"] * 1_000_000_000 + stamp["nsec"] == message.log_time
            found.setdefault(channel.topic, []).append((message.log_time, words))
    return found


def test_a_clock_that_stood_before_1970_counts_from_there(tmp_path: Path, drill: Path) -> None:
    copy = tmp_path / "drill.trainer"
    shutil.copy(drill, copy)
    with contextlib.closing(sqlite3.connect(copy)) as database, database:
        changed = database.execute(
            "update header set value = '1969-12-31T23:00:00+00:00' where key = 'started'"
        )
        assert changed.rowcount == 1
    export_file(copy, {"mcap": tmp_path / "drill.mcap"}, None)
    with (tmp_path / "drill.mcap").open("rb") as file:
        times = [message.log_time for _, _, message in make_reader(file).iter_messages()]
    assert min(times) == 0
    assert max(times) > 0


def test_each_state_has_its_pose_in_axes_of_robots(drill: Path, told: Any) -> None:
    run = read_recording(drill)

    assert len(told["/boat/pose"]) == len(told["/tf"]) == len(run["t"])
    begun = told["/boat/pose"][0][0]
    for i in (0, len(run["t"]) // 2, -1):
        at, words = told["/boat/pose"][i]
        pose = words["pose"]
        assert (at - begun) * 1e-9 == pytest.approx(run["t"][i])
        assert list(pose["position"].values()) == [run["y"][i], run["x"][i], -run["z"][i]]
        ahead = Rotation.from_quat(list(pose["orientation"].values())).apply([1.0, 0.0, 0.0])
        theta, psi = run["theta"][i], run["psi"][i]
        level = np.cos(theta)
        assert ahead == pytest.approx([level * np.sin(psi), level * np.cos(psi), np.sin(theta)])
        assert told["/tf"][i][1]["rotation"] == pose["orientation"]


def test_each_message_has_the_time_of_its_tick(drill: Path, told: Any) -> None:
    run = read_recording(drill)
    with contextlib.closing(Recording.look(drill)) as recording:
        begun = datetime.fromisoformat(recording.header()["started"]).timestamp()
        orders = [each.tick for each in recording.orders(1)]
        events = [each.tick for each in recording.first_events()]
    step = run["t"][1] - run["t"][0]
    due = {topic: [*run["t"]] for topic in ("/boat/pose", "/tf", "/boat/motion")}
    due |= {
        "/orders": [step * tick for tick in orders],
        "/events": [step * tick for tick in events],
    }

    assert len(set(orders)) > 3
    assert told.keys() == due.keys()
    for topic, seconds in due.items():
        at = [time * 1e-9 - begun for time, _ in told[topic]]
        assert at == pytest.approx(seconds, abs=1e-3), topic


def test_a_roll_to_starboard_lowers_the_starboard_side() -> None:
    turned = Rotation.from_quat(list(quaternion_of(0.3, 0.0, 0.0).values()))

    assert turned.apply([0.0, -1.0, 0.0]) == pytest.approx([np.cos(0.3), 0.0, -np.sin(0.3)])


def test_motion_is_in_the_units_of_its_names(drill: Path, told: Any) -> None:
    run, (_, last) = read_recording(drill), told["/boat/motion"][-1]

    assert last["depth_m"] == run["z"][-1]
    assert last["pitch_up_deg"] == pytest.approx(run["theta"][-1] / DEGREE)
    assert last["heading_deg"] == pytest.approx(run["psi"][-1] / DEGREE % 360.0)
    assert last["speed_kn"] == pytest.approx(run["u"][-1] * 3600.0 / 1852.0)


def test_orders_and_events_are_lines_of_a_log(told: Any) -> None:
    lines = [words for _, words in told["/orders"]]

    assert any(each["message"].startswith("depth 110 m: ") for each in lines)
    assert [each["level"] for each in lines if each["message"].startswith("rudder right 60")] == [3]
    assert {each["level"] for each in lines} == {2, 3}
    assert [words["message"] for _, words in told["/events"]] == ["mark log"]


def test_without_its_library_nothing_is_written(
    drill: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("trainer.config.extras.find_spec", lambda _name: None)
    out = tmp_path / "a.mcap"

    with pytest.raises(ConfigError, match=r"--mcap needs mcap: pip install '.*\[mcap\]'"):
        export_file(drill, {"csv": tmp_path / "a.csv", "mcap": out}, None)
    assert list(tmp_path.iterdir()) == []


def test_the_file_says_what_it_is_of_and_has_the_texts_that_the_run_was_flown_by(
    drill: Path, told: Any
) -> None:
    assert told
    with open_whole_recording(drill) as recording:
        header = recording.header()
    with drill.with_suffix(".mcap").open("rb") as file:
        reader = make_reader(file)
        (record_of,) = reader.iter_metadata()
        texts = {one.name: one.data.decode() for one in reader.iter_attachments()}
        sequences: dict[str, list[int]] = {}
        for _, channel, message in reader.iter_messages():
            sequences.setdefault(channel.topic, []).append(message.sequence)
    said = record_of.metadata
    assert said["vessel"] == "configs/vessels/bb2.toml"
    assert said["exercise"] == "stern-plane-jam"
    assert (said["core"], said["seed"]) == (header["core"], header["seed"])
    assert texts == json.loads(header["texts"])
    assert all(numbers == [*range(len(numbers))] for numbers in sequences.values())


def test_its_summary_has_indexes_of_what_is_there_alone(drill: Path, told: Any) -> None:
    assert told
    with drill.with_suffix(".mcap").open("rb") as file:
        records = [*StreamReader(file).records]
    offsets = [one for one in records if isinstance(one, SummaryOffset)]
    assert len(offsets) > 4
    assert all(one.group_length > 0 for one in offsets)
