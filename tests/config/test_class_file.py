"""The file of a class: what it says of each boat, and what is refused."""

import json
from pathlib import Path

import pytest
from jsonschema import Draft202012Validator

from trainer.cli.main import cli
from trainer.config.exercise.class_file import (
    class_schema,
    class_text,
    is_class_file,
    load_class,
)
from trainer.config.files import ConfigError, parse_toml
from trainer.debrief.trainees.forgetting import forget_trainee
from trainer.debrief.trainees.history import recordings_in

WHOLE = """\
exercise = "depth-changes"
boats = 3
seed = 5
seeds = "by-boat"
one_sea_m = 800
note = "Tuesday"

[[boat]]
number = 2
name = "Bravo"
trainees = ["A. Jones", "B. Smith"]

[[boat]]
number = 3
seed = 99
"""


def written(folder: Path, text: str) -> Path:
    path = folder / "tuesday.toml"
    path.write_text(text, encoding="utf-8")
    return path


def test_a_boat_has_what_is_its_own_and_else_what_is_the_classs(tmp_path: Path) -> None:
    planned = load_class(written(tmp_path, WHOLE))
    rows = [planned.row_of(number) for number in planned.numbers]

    assert planned.one_sea_m == 800.0
    assert [row.seed for row in rows] == [5, 6, 99]
    assert [row.name for row in rows] == [None, "Bravo", None]
    assert rows[1].trainees == ("A. Jones", "B. Smith")
    same = load_class(written(tmp_path, 'exercise = "depth-changes"\nboats = 2\n'))
    assert same.one_sea_m is None
    assert [same.row_of(number).seed for number in same.numbers] == [1, 1]


def test_a_class_is_the_same_after_it_is_written_and_read(tmp_path: Path) -> None:
    planned = load_class(written(tmp_path, WHOLE))

    assert load_class(written(tmp_path, class_text(planned))) == planned


COURSE = """\
boats = 2

[[course]]
exercise = "planes-and-bubble"

[[course]]
exercise = "depth-changes"
reach = 70

[[course]]
exercise = "./own.toml"
"""


def test_a_course_stands_in_place_of_the_exercise(tmp_path: Path) -> None:
    (tmp_path / "own.toml").write_text('name = "Mine"\n', encoding="utf-8")
    planned = load_class(written(tmp_path, COURSE))

    own = str(tmp_path / "own.toml")
    assert planned.exercises == ("planes-and-bubble", "depth-changes", own)
    assert [row.reach for row in planned.course] == [None, 70.0, None]
    assert load_class(written(tmp_path, class_text(planned))) == planned
    assert Draft202012Validator(class_schema()).is_valid(parse_toml(COURSE, ""))


def test_check_tells_the_course_row_by_row(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    shipped = COURSE.replace("./own.toml", "watch")
    cli(["class", "check", str(written(tmp_path, shipped))], standalone_mode=False)

    told = capsys.readouterr().out.splitlines()
    assert told[0] == "course of 3, boats: 2"
    assert told[2] == "  2. depth-changes, 70 marks to go on"


WRONG = {
    f'{WHOLE}on = "tcp://a:1"': "seed and trainees are its own session's",
    f'exercise = "watch"\n{COURSE}': "one of them, and not both",
    "boats = 2": "say that, or the rows [[course]]",
    COURSE.replace("70", "0.5"): "reach = 0.5",
    COURSE.replace("depth-changes", "depth-change"): "nearest is depth-changes",
    COURSE.replace("depth-changes", "planes-and-bubble"): "[[course]] 2: exercise = planes-and",
    COURSE.replace('bubble"', 'bubble"\nreach = 50'): "planes-and-bubble has no marks",
    'exercise = "depth-change"\nboats = 3': "nearest is depth-changes",
    'exercise = "depth-changes"\nboats = 25': "boats = 25: must be a whole number, 1 to 24",
    'exercise = "depth-changes"\nboat = []': "lacks boats",
    'exercise = "depth-changes"\nboats = 2\none_sea_m = 6000': "one_sea_m = 6000: must be 0 to",
    'exercise = "depth-changes"\nboats = 1\nseeds = "own"': "must be same or by-boat",
    'exercise = "depth-changes"\nboats = 1\n[[boat]]\nnumber = 2': "there are boats = 1",
    f"{WHOLE}[[boat]]\nnumber = 2": "is there 2 times",
    'exercise = "./none.toml"\nboats = 1': "none.toml",
}


@pytest.mark.parametrize("text", WRONG)
def test_a_wrong_class_file_is_told_by_its_key(tmp_path: Path, text: str) -> None:
    with pytest.raises(ConfigError) as refused:
        load_class(written(tmp_path, text))
    assert WRONG[text] in str(refused.value)


def test_a_class_file_is_known_from_an_exercise(tmp_path: Path) -> None:
    assert is_class_file(str(written(tmp_path, WHOLE)))
    assert not is_class_file(str(written(tmp_path, 'name = "Mine"\n')))
    assert not is_class_file("depth-changes")


def test_editors_check_a_class_file_by_its_schema() -> None:
    judge = Draft202012Validator(class_schema())

    assert judge.is_valid(parse_toml(WHOLE, "tuesday.toml"))
    assert not judge.is_valid({"exercise": "depth-changes", "boats": 0})
    assert not judge.is_valid({"exercise": "depth-changes"})
    assert json.dumps(class_schema())


def test_a_new_class_file_is_right_and_is_written_over_no_other(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "tuesday.toml"
    typed = ["class", "new", str(path), "depth-changes", "--boats", "2"]
    cli(typed, standalone_mode=False)
    cli(["class", "check", str(path)], standalone_mode=False)

    told = capsys.readouterr().out
    assert "depth-changes, boats: 2" in told
    assert "one sea" not in told
    path.write_text(path.read_text(encoding="utf-8").replace("# one_sea_m", "one_sea_m"))
    cli(["class", "check", str(path)], standalone_mode=False)
    assert "all in one sea, each 1000 m east" in capsys.readouterr().out
    with pytest.raises(ConfigError, match="is there already"):
        cli(typed, standalone_mode=False)


def test_a_name_that_is_forgotten_is_gone_from_a_class_and_the_rest_of_it_stays(
    tmp_path: Path,
) -> None:
    kept = tmp_path / "class-tuesday"
    kept.mkdir()
    path = kept / "class.toml"
    path.write_text(class_text(load_class(written(tmp_path, WHOLE))), encoding="utf-8")
    steps = [*forget_trainee("A. Jones", [path], [])]

    assert steps == [f"{path}: the name is removed"]
    left = load_class(path)
    assert left.row_of(2).trainees == ("B. Smith",)
    assert (left.row_of(2).name, left.row_of(3).seed) == ("Bravo", 99)
    assert not [*forget_trainee("A. Jones", [path], [])]


def test_the_recordings_of_a_class_are_found_in_the_folder_of_recordings(tmp_path: Path) -> None:
    for name in ("class-a/boat-1/x.trainer", "other/boat-1/y.trainer", "z.trainer"):
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.touch()
    written(tmp_path, WHOLE).rename(tmp_path / "class-a" / "class.toml")

    assert {path.name for path in recordings_in([tmp_path])} == {"x.trainer", "z.trainer"}
    assert [path.name for path in recordings_in([tmp_path / "class-a"])] == ["x.trainer"]
    assert [path.name for path in recordings_in([tmp_path / "z.trainer"])] == ["z.trainer"]
