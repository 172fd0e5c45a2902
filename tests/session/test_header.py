"""What a recording says of its run: the plan made again from it, and what differs today."""

import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from helpers.boats import make_boat
from helpers.sessions import begin_run, start_plan
from helpers.ships import NOMOTO_SHIP

from trainer.config import files
from trainer.config.files import (
    ConfigError,
    key_of,
    path_of,
    read_text,
    reading_recorded,
    remembering,
    shipped_names,
    shipped_path,
)
from trainer.config.world.sea import load_sea
from trainer.core import digest
from trainer.session.past import header as header_module
from trainer.session.past.header import differences, layout_of, method_of, notes, plan_of
from trainer.session.past.layout import LAYOUT, read_state
from trainer.session.past.options import RunOptions
from trainer.session.past.plan import plan_run

PLAIN: dict[str, Any] = {
    "exercise": None,
    "vessel": "bb2",
    "sea": None,
    "orders_file": None,
    "equations": "full",
    "rates": None,
    "trig": "exact",
    "integrator": "adams2",
    "step": None,
    "seed": 1,
    "duration": None,
    "given": frozenset(),
}
DRILL = """
schema = "exercise/1"
name = "A drill of one's own"
briefing = "Nothing is shipped with it."
casualty_table = "table.toml"
vessel = "./boat.toml"
sea = "swell.toml"
seed = 41
duration_s = 600

[[orders]]
at_s = 5
order = "depth 80"

[[casualties]]
at_s = 10
name = "weak-pump"
severity = 0.4
ramp_s = 30

[[casualties]]
when = "depth > 70"
name = "gyro-noisy"
rule = "again"
"""
TABLE = """
[casualty.weak-pump]
kind = "pump-trim-failed"
severity = 0.5
"""
MET = """
schema = "exercise/1"
name = "A ship is met"
briefing = "It answers its rudder."

[[contact]]
name = "one"
type = "cargo"
points = [[5000, 200]]
course_deg = 90
speed_kn = 12
nomoto = "./ship.toml"
"""
SWELL = "[sea]\nheight_m = 2.5\nperiod_s = 9\nspectrum = 'bretschneider'\n"


@pytest.fixture
def drill(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> RunOptions:
    """Return options of an exercise in the present folder, every file of it the user's own."""
    monkeypatch.chdir(tmp_path)
    bb2 = shipped_path("vessels", "bb2").read_text(encoding="utf-8")
    for name, text in (
        ("boat.toml", bb2),
        ("swell.toml", SWELL),
        ("table.toml", TABLE),
        ("drill.toml", DRILL),
        ("orders.txt", "7.5 rudder right 10  # by hand\n"),
    ):
        (tmp_path / name).write_text(text, encoding="utf-8")
    return RunOptions(equations="full", exercise="drill.toml", orders_file=Path("orders.txt"))


# What is read, remembered


def test_what_is_read_is_remembered_under_a_key_that_no_machine_s_paths_are_in(
    drill: RunOptions,
) -> None:
    plan_run(drill)  # what has been read before is read again
    with remembering() as texts:
        plan_run(drill)

    assert set(texts) == {
        *("drill.toml", "boat.toml", "swell.toml", "table.toml", "orders.txt"),
        *("configs/defaults.toml", "configs/sea-defaults.toml"),
        *("configs/casualties/standard.toml", "configs/casualties/compound.toml"),
    }
    assert texts["swell.toml"] == SWELL


def test_what_is_read_after_the_block_is_not_remembered() -> None:
    with remembering() as texts:
        load_sea("sea-state-2")
    before = dict(texts)
    load_sea("sea-state-5")
    assert texts == before


def test_a_file_of_the_user_s_own_is_never_taken_for_a_shipped_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    own = tmp_path / "configs" / "seas"
    own.mkdir(parents=True)
    (own / "calm.toml").write_text(SWELL)

    with remembering() as texts:
        load_sea("./configs/seas/calm.toml")
        load_sea("calm")

    assert texts["./configs/seas/calm.toml"] == SWELL
    assert "sea_state = 0" in texts["configs/seas/calm.toml"]
    for key, text in texts.items():
        assert path_of(key).read_text(encoding="utf-8") == text
        assert key_of(path_of(key)) == key


def test_recorded_texts_are_read_and_nothing_else(tmp_path: Path) -> None:
    (tmp_path / "new.toml").write_text(SWELL)
    texts = {"configs/seas/gale.toml": "a gale", "mine.toml": "mine"}
    with reading_recorded(texts):
        assert shipped_names("seas") == ("gale",)
        assert read_text(shipped_path("seas", "gale")) == "a gale"
        assert read_text(Path("mine.toml")) == "mine"
        with pytest.raises(ConfigError, match="no shipped file 'calm' among seas"):
            shipped_path("seas", "calm")
        with pytest.raises(ConfigError, match=r"new.toml: is not among the files recorded: conf"):
            read_text(tmp_path / "new.toml")
    assert "calm" in shipped_names("seas")


def test_a_shipped_file_given_by_its_path_is_found_on_another_machine() -> None:
    with reading_recorded({"configs/seas/calm.toml": "a calm"}):
        assert read_text(Path("/opt/other/configs/seas/calm.toml")) == "a calm"


# The plan made again


@pytest.mark.parametrize(
    "options",
    [
        {},
        {"vessel": "remus100", "step": 0.05, "given": frozenset({"vessel", "step"})},
        {"exercise": "periscope-depth", "sea": "sea-state-3", "given": frozenset({"sea"})},
        {"exercise": "stern-plane-jam", "seed": 2**53 - 1, "given": frozenset({"seed"})},
        {"integrator": "rk4", "equations": "basic", "trig": "report", "duration": 0.1},
        {"integrator": "a=0.5,0.5;b=1.5", "rates": "exact"},
    ],
)
def test_a_header_gives_back_the_very_same_plan(options: dict[str, Any]) -> None:
    plan, boat, header = begin_run(RunOptions(**{"equations": "full", **options}))

    again = plan_of(header)

    assert again == plan
    assert method_of(header) == plan.method
    assert layout_of(header) == LAYOUT
    other = start_plan(again)
    assert other.records.state.tobytes() == boat.records.state.tobytes()
    assert other.records.scheme.tobytes() == boat.records.scheme.tobytes()
    assert differences(header) == []
    assert notes(header) == []


def test_a_plan_is_made_again_with_none_of_its_files_left(
    drill: RunOptions, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    plan, _, header = begin_run(replace(drill, seed=5, given=frozenset({"seed"})))
    for path in tmp_path.iterdir():
        path.unlink()
    monkeypatch.setattr(files, "_text_on_disk", lambda path: pytest.fail(f"{path} was read"))

    again = plan_of(header)

    assert again == plan
    assert (again.seed, again.duration, again.title) == (5, 600.0, "A drill of one's own")
    assert [entry.order.text for entry in again.schedule][:2] == [
        "depth 80 m",
        "rudder right 10",
    ]


def test_a_header_is_texts_only_and_says_what_computed_the_run() -> None:
    _, _, header = begin_run(RunOptions(equations="full"))
    assert all(isinstance(text, str) for text in header.values())
    assert {"trainer", "core", "python", "numpy", "numba", "machine", "started"} <= set(header)
    assert header["started"].endswith("+00:00")


# What differs today


def test_a_changed_vessel_file_is_told_by_line_and_key(drill: RunOptions, tmp_path: Path) -> None:
    _, _, header = begin_run(drill)
    path = tmp_path / "boat.toml"
    lines = path.read_text(encoding="utf-8").split("\n")
    where = next(i for i, line in enumerate(lines) if line.startswith("length ="))
    lines[where] = lines[where].replace("70.2", "70.5")
    lines.insert(0, "# one line more")
    path.write_text("\n".join(lines), encoding="utf-8")

    assert differences(header) == [
        "boat.toml line 1 is new: # one line more",
        f"boat.toml line {where + 2}: length = 70.5 was 70.2",
    ]


def test_a_file_that_is_gone_is_told_by_its_name(drill: RunOptions, tmp_path: Path) -> None:
    _, _, header = begin_run(drill)
    (tmp_path / "swell.toml").unlink()
    assert differences(header) == [
        "swell.toml: there is no such file; it was read when this was recorded"
    ]


@pytest.mark.parametrize(
    ("now", "told"),
    [
        ("a\nc\n", "f line 2 as recorded is gone: b"),
        ("a\nb \nc\n", "f line 2: differs in blanks only"),
        ("a\nB\nc\n", "f line 2: B was b"),
        ("a\n\ud7ff\nc\n", "f line 2: \\ud7ff was b"),
        ("a\n" + 80 * "x" + "\nc\n", f"f line 2: {57 * 'x'}... was b"),
    ],
)
def test_a_changed_line_is_told_short_and_printable(now: str, told: str) -> None:
    assert header_module.changes("f", now, "a\nb\nc\n") == [told]  # type: ignore[attr-defined]


def test_of_many_changed_lines_the_first_are_told_and_the_others_counted() -> None:
    now, was = "\n".join(map(str, range(100))), "\n".join(f"{i} x" for i in range(100))
    told = header_module.changes("f", now, was)  # type: ignore[attr-defined]
    assert told[0] == "f line 1: 0 was 0 x"
    assert told[10:] == ["f: and 90 more lines"]


def test_a_recording_from_before_the_key_of_visitors_is_the_same_run() -> None:
    _, _, header = begin_run(RunOptions(exercise="visitor-dive", equations="full"))
    texts = json.loads(header["texts"])
    (key,) = (key for key in texts if key.endswith("visitor-dive.toml"))
    lines = texts[key].splitlines(keepends=True)
    earlier = [line for line in lines if not line.startswith("visitors")]
    assert len(earlier) == len(lines) - 1

    texts[key] = "".join(earlier)
    header["texts"] = json.dumps(texts)
    assert differences(header) == []
    assert not plan_of(header).visitors

    texts[key] = "".join(earlier).replace("depth_m = 18", "depth_m = 19")
    header["texts"] = json.dumps(texts)
    assert len(differences(header)) == 2  # every line is told where anything is flown otherwise


def test_another_version_core_or_state_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    _, _, header = begin_run(RunOptions(equations="full"))
    digest, header["core"] = header["core"], "0123456789abcdef"
    monkeypatch.setattr(header_module, "__version__", "9.9.9")
    header["layout"] = json.dumps([*LAYOUT[:-1], "old_name"])

    count, last = len(LAYOUT), LAYOUT[-1]
    assert differences(header) == [
        f"trainer 9.9.9, recorded {header['trainer']}",
        f"core {digest}, recorded 0123456789abcdef: other equations",
        f"state of {count} numbers, recorded {count}; new: {last}; gone: old_name",
    ]


def test_an_earlier_core_of_the_same_bits_is_no_difference(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    _, _, header = begin_run(RunOptions(equations="full"))
    earlier = {**header, "core": "of yesterday"}
    assert differences(earlier) != []

    monkeypatch.setattr(digest, "SAME_BITS", frozenset({"of yesterday"}))

    assert differences(earlier) == []


# The core before the force rows with a double zero at rest, and those whose bits it had.
@pytest.mark.parametrize(
    "earlier",
    ["903b64a6d0ec99fb", "85b75f58a082ce9f", "9621e438af398b4f", "2f0859a1c90a8d8c"],
)
def test_a_core_with_other_waves_is_another_core(earlier: str) -> None:
    _, _, header = begin_run(RunOptions(equations="full"))

    told = differences({**header, "core": earlier})

    assert told == [f"core {header['core']}, recorded {earlier}: other equations"]


def test_other_libraries_are_noted_and_are_no_difference() -> None:
    _, _, header = begin_run(RunOptions(equations="full"))
    now = header["numpy"]
    header["numpy"] = "1.0"
    assert differences(header) == []
    assert notes(header) == [f"numpy {now}, recorded 1.0"]


def test_a_step_vessel_or_method_given_otherwise_is_told(drill: RunOptions, tmp_path: Path) -> None:
    _, _, header = begin_run(drill)
    text = (tmp_path / "boat.toml").read_text(encoding="utf-8")
    (tmp_path / "longer.toml").write_text(text.replace("length = 70.2", "length = 71"))
    line = text[: text.index("length = 70.2")].count("\n") + 1

    assert differences(header, {"step": 0.5, "seed": 41}) == []
    assert differences(header, {"step": 1.0}) == ["step 1 s, recorded 0.5 s"]
    assert differences(header, {"integrator": "rk4", "seed": 4}) == [
        "rates exact, recorded lagged",
        "integrator rk4, recorded adams2",
        "seed 4, recorded 41",
    ]
    assert differences(header, {"vessel": "longer.toml"}) == [
        "vessel longer.toml, recorded boat.toml",
        f"longer.toml line {line}: length = 71 was 70.2",
    ]
    assert plan_of(header, {"vessel": "longer.toml"}).file.hull.length == 71.0


@pytest.mark.parametrize(
    ("spoilt", "told"),
    [
        ({"plan": "2"}, 'recording: plan = "2": this version reads plan "1"'),
        ({"options": "{"}, "recording: its header has no readable options"),
    ],
)
def test_a_header_of_another_form_is_told_not_guessed_at(spoilt: dict[str, str], told: str) -> None:
    _, _, header = begin_run(RunOptions(equations="full"))
    with pytest.raises(ConfigError) as wrong:
        plan_of(header | spoilt)
    assert str(wrong.value) == told
    assert told in differences(header | spoilt)


# States of another version


def test_a_state_of_another_version_is_read_by_the_names_of_its_numbers() -> None:
    boat = make_boat("bb2")
    boat.start(5.0, 60.0, 1.0)
    state = boat.records.state
    older = [name for name in LAYOUT if not name.startswith(("held", "sailed"))][::-1]
    places = [LAYOUT.index(name) for name in older]
    text = state["whole"][0][places].tobytes()
    standing = state.copy()
    standing["whole"] = 7.0

    read = read_state(text, older, standing)

    assert {name for name in LAYOUT if name not in older} == {
        *("held_depth", "held_position", "held_tanks", "sailed_x", "sailed_y")
    }
    assert read["held"].tolist() == [[7.0, 7.0, 7.0]]
    assert read["whole"][0][places].tobytes() == text


@pytest.mark.parametrize(
    ("part", "value", "told"),
    [
        ("options", [], "is of another form"),
        ("options", {"exercise": None}, "no option"),
        ("options", {**PLAIN, "given": [], "vessel": ["bb2"]}, "option vessel"),
        ("options", {**PLAIN, "given": [1]}, "option given"),
        ("options", {**PLAIN, "given": [], "duration": math.inf}, "option duration"),
        ("options", {**PLAIN, "given": [], "seed": 10**400}, "option seed"),
        ("texts", {"configs/x.toml": 1}, "texts = "),
        ("layout", [["u"]], "layout = "),
        ("method", {"step": 0.5}, "is no method"),
    ],
)
def test_a_header_of_anybody_s_making_is_refused_by_name(
    part: str, value: object, told: str
) -> None:
    _, _, header = begin_run(RunOptions(equations="full"))
    header[part] = json.dumps(value).replace("Infinity", "1e999")
    read = {"options": plan_of, "texts": plan_of, "layout": layout_of, "method": method_of}[part]

    with pytest.raises(ConfigError, match=told):
        read(header)  # type: ignore[operator]


def test_a_nomoto_ship_that_went_by_the_first_form_is_told(tmp_path: Path) -> None:
    """Form 1 took other steps: what is recorded does not fly again to its own bits."""
    (tmp_path / "ship.toml").write_text(NOMOTO_SHIP, encoding="utf-8")
    path = tmp_path / "met.toml"
    path.write_text(MET, encoding="utf-8")
    _, _, header = begin_run(RunOptions(exercise=str(path)))
    assert differences(header) == []
    before = {key: value for key, value in header.items() if key != "nomoto"}
    assert differences(before) == ["Nomoto ships of form 2, recorded 1: they go by other steps"]
    _, _, without = begin_run(RunOptions())
    del without["nomoto"]
    assert differences(without) == []
