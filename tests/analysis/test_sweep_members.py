"""A member of a study is the flight that the command of its own would give, to the bit."""

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

from trainer.analysis.sweep.job import member_values
from trainer.analysis.sweep.manoeuvres import MAX_FLIGHTS_HELD, ManoeuvreSubject
from trainer.analysis.sweep.study import parse_study
from trainer.api.subjects import subject_of
from trainer.cli.main import cli
from trainer.config.boat.vessel import load_vessel, parse_vessel
from trainer.config.files import ConfigError

FACTOR = "distribution = 'normal'\nmean = 1.0\nstd = 0.1\nrelative = true"
SAMPLE = "[sample]\nplan = 'latin-hypercube'\nmembers = {members}\nseed = 5"


def study_text(manoeuvre: str, varied: dict[str, str], members: int = 20, more: str = "") -> str:
    """Return a study of a manoeuvre with keys varied, each as told."""
    rows = [
        f"[[vary]]\nname = '{i}'\nkey = '{key}'\n{how}"
        for i, (key, how) in enumerate(varied.items())
    ]
    head = "schema = 'sweep/1'\nname = 'test'"
    return "\n".join([head, more, manoeuvre, SAMPLE.format(members=members), *rows])


def manoeuvring(*told: Any, **more: Any) -> ManoeuvreSubject:
    """Return the members of such a study."""
    return ManoeuvreSubject(parse_study(study_text(*told, **more), Path("test.toml")))


def flown_alone(subject: ManoeuvreSubject, drawn: dict[str, Any]) -> tuple[list[float], str | None]:
    """Return a member's numbers, and why there are none."""
    try:
        return subject._alone(drawn, 0), None  # noqa: SLF001
    except ConfigError as error:
        return [math.nan] * len(subject.outputs), str(error)


COEFFICIENTS = {f"vessel.coefficients.{name}": FACTOR for name in ("N_v", "N_r", "Y_vav", "M_ds")}
SHORT = "[manoeuvre]\nname = 'turn'\nduration_s = 90.0"
BETWEEN = "distribution = 'uniform'\nlow = {}\nhigh = {}"


@pytest.mark.parametrize(
    ("manoeuvre", "varied", "more"),
    [
        (SHORT, COEFFICIENTS, ""),
        (
            SHORT + "\ndepth_kept = false",
            COEFFICIENTS,
            "[method]\nequations = 'basic'\ntrig = 'report'",
        ),
        (SHORT, COEFFICIENTS, "vessel = 'remus100'\n[method]\nequations = 'full'\nrates = 'exact'"),
        (SHORT, {"vessel.compensation.modified.N_dr": FACTOR}, ""),
        (SHORT, {"vessel.coefficients.M_qdot": FACTOR, "vessel.coefficients.N_rdot": FACTOR}, ""),
        (SHORT, {"vessel.vessel.mass": BETWEEN.format(4.35e6, 4.45e6)}, ""),
        (SHORT, {"vessel.control_surfaces.rate_deg_s": BETWEEN.format(3, 9)}, ""),
        (SHORT, {"vessel.fluid.rho": BETWEEN.format(1000, 1030)}, ""),
        (SHORT, {"manoeuvre.angle_deg": BETWEEN.format(5, 25), **COEFFICIENTS}, ""),
        (SHORT, {"manoeuvre.speed_kn": BETWEEN.format(5, 15)}, ""),
        ("[manoeuvre]\nname = 'climbing-turn'\nduration_s = 60.0", COEFFICIENTS, ""),
        ("[manoeuvre]\nname = 'trim'", COEFFICIENTS, ""),
        (SHORT + "\nside = 'port'", COEFFICIENTS, ""),
        ("[manoeuvre]\nname = 'turn'\nduration_s = 60.0\nlaw = 'report'", COEFFICIENTS, ""),
    ],
    ids=lambda value: None if isinstance(value, dict) else value[-30:].replace("\n", " "),
)
def test_a_member_of_a_fleet_has_the_bits_of_a_flight_alone(
    manoeuvre: str, varied: dict[str, str], more: str
) -> None:
    subject = manoeuvring(manoeuvre, varied, members=6, more=more)
    assert subject.together

    batch = subject.batch(0, 6)

    for i in range(6):
        numbers, trouble = flown_alone(subject, member_values(batch.drawn, i))
        assert trouble is None
        assert batch.outputs[i].tobytes() == np.array(numbers).tobytes()
    assert len({row.tobytes() for row in batch.outputs}) == 6


def test_members_turn_to_the_side_that_the_study_says() -> None:
    told = SHORT.replace("90", "60"), {"manoeuvre.side": "values = ['starboard', 'port']"}
    text = study_text(*told, more="measures = ['last psi', 'heading after 60 s', 'last y']")
    text = text.replace("latin-hypercube", "grid").replace("members = 20", "")
    subject = ManoeuvreSubject(parse_study(text, Path("test.toml")))

    batch = subject.batch(0, 2)

    assert subject.together
    assert list(batch.drawn["0"]) == ["starboard", "port"]
    starboard, port = batch.outputs
    assert starboard[0] > 0.0 > port[0]
    assert starboard[2] > 0.0 > port[2]


def test_fleets_of_any_size_give_the_same_bits() -> None:
    subject = manoeuvring(SHORT.replace("90", "30"), COEFFICIENTS, members=MAX_FLIGHTS_HELD + 9)

    whole = subject.batch(0, MAX_FLIGHTS_HELD + 9).outputs
    assert (
        subject.batch(MAX_FLIGHTS_HELD - 3, 7).outputs.tobytes()
        == whole[MAX_FLIGHTS_HELD - 3 : MAX_FLIGHTS_HELD + 4].tobytes()
    )


def test_what_steers_by_how_the_boat_moves_is_flown_alone() -> None:
    subject = manoeuvring("[manoeuvre]\nname = 'zigzag-20'\nduration_s = 60.0", COEFFICIENTS)

    assert not subject.together
    numbers = subject.batch(3, 1)
    assert numbers.troubles == (None,)


def test_a_middle_member_is_the_manoeuvre_of_the_command(tmp_path: Path) -> None:
    values = {"manoeuvre.angle_deg": "values = [12.0, 14.0]"}
    text = study_text(
        SHORT, values, more="measures = ['tactical diameter', 'steady roll', 'last z']"
    )
    path = tmp_path / "study.toml"
    path.write_text(text.replace("latin-hypercube", "grid").replace("members = 20", ""))

    one = CliRunner().invoke(cli, ["sweep", str(path), "--member", "1", "--json"])
    words = ["manoeuvre", "turn", "bb2", "--angle", "14", "--duration", "90"]
    other = CliRunner().invoke(cli, [*words, "--equations", "modified", "--json"])

    told = json.loads(one.stdout)
    known = {each["name"]: each["value"] for each in json.loads(other.stdout)["measures"]}
    for name in ("tactical diameter", "steady roll"):
        assert told[name] == known[name]
    assert told["trouble"] is None


def test_members_that_cannot_fly_say_why_and_are_nothing_else() -> None:
    lively = "[manoeuvre]\nname = 'trim'\nangle_deg = 30.0\nspeed_kn = 15.0"
    wide = {"vessel.coefficients.M_w": BETWEEN.format(-0.03, 0.05)}
    subject = manoeuvring(lively, wide, members=12)
    batch = subject.batch(0, 12)

    for i in range(12):
        assert np.isnan(batch.outputs[i]).all() == (batch.troubles[i] is not None)
        numbers, trouble = flown_alone(subject, member_values(batch.drawn, i))
        assert batch.outputs[i].tobytes() == np.array(numbers).tobytes()
        assert batch.troubles[i] == trouble
    assert any("pitch is" in (text or "") for text in batch.troubles)
    assert None in batch.troubles


@pytest.mark.parametrize(
    ("key", "how", "said"),
    [
        # no term of the compact set: the boat would fly as well as ever
        ("vessel.coefficients.X_qq", BETWEEN.format(-14, 14), "must be -10 to 10"),
        ("vessel.coefficients.X_udot", BETWEEN.format(-0.1, 0.1), "an added mass is negative"),
        ("vessel.control_surfaces.rate_deg_s", BETWEEN.format(-2, 9), "must be 0.01 to 1000"),
    ],
)
def test_members_that_no_vessel_file_may_be_are_refused_as_one(
    key: str, how: str, said: str
) -> None:
    batch = manoeuvring(SHORT, {key: how}, members=12).batch(0, 12)

    refused = [text for text in batch.troubles if text]
    assert refused
    assert len(refused) < 12
    assert all(said in text for text in refused)
    assert sum(np.isnan(batch.outputs).all(axis=1)) == len(refused)  # type: ignore[arg-type]


def test_a_vessel_changed_by_its_tables_is_the_vessel_of_a_file_so_written() -> None:
    subject = manoeuvring(SHORT, {"vessel.coefficients.N_v": "values = [-0.01]"}, members=1)
    file = load_vessel("bb2")
    head, mark, coefficients = file.text.partition("[coefficients.N]")
    rows = coefficients.splitlines()
    coefficients = "\n".join("N_v = -0.01" if row.startswith("N_v ") else row for row in rows)
    written = head + mark + coefficients
    assert written.count("N_v = -0.01") == 1

    (changed,) = (subject._cases({"0": np.array([-0.01])}, 1)[0][0].file,)  # noqa: SLF001
    by_key = subject.study.varied({"0": -0.01})["vessel"]["coefficients"]
    assert by_key == dict(parse_vessel(written, Path("bb2.toml")).coefficients)
    assert changed is subject.middle.file  # only coefficients differ: the records carry them


EXERCISE = """
schema = "sweep/1"
name = "test"
measures = ["last x", "last z", "largest phi", "last delta_s"]
[exercise]
duration_s = 40.0
sea = "sea-state-4"
[exercise.initial]
speed_kn = 8.0
depth_m = 20.0
[exercise.current]
set_deg = 30.0
drift_kn = 1.0
[[exercise.orders]]
at_s = 5.0
order = "rudder right {}"
[[exercise.casualties]]
name = "stern-hard-over"
severity = -0.2
at_s = 10.0
[sample]
plan = "monte-carlo"
members = 3
seed = 4
[[vary]]
name = "rudder"
key = "exercise.orders[0].order"
distribution = "uniform"
low = 5.0
high = 20.0
[[vary]]
name = "jam"
key = "exercise.casualties[0].severity"
distribution = "uniform"
low = -0.2
high = -0.1
[[vary]]
name = "sea"
key = "exercise.sea"
values = ["sea-state-3", "sea-state-4"]
"""


def test_a_member_of_an_exercise_is_the_run_of_the_command(tmp_path: Path) -> None:
    subject = subject_of(parse_study(EXERCISE, Path("test.toml")))
    batch = subject.batch(1, 2)

    for i in range(2):
        drawn = member_values(batch.drawn, i)
        own = tmp_path / f"own{i}.toml"
        own.write_text(
            f"""schema = "exercise/1"
name = "own"
briefing = "own"
duration_s = 40.0
seed = {batch.seeds[i]}
sea = "{drawn["sea"]}"
[initial]
speed_kn = 8.0
depth_m = 20.0
[current]
set_deg = 30.0
drift_kn = 1.0
[[orders]]
at_s = 5.0
order = "rudder right {drawn["rudder"]:.9f}"
[[casualties]]
name = "stern-hard-over"
severity = {drawn["jam"]!r}
at_s = 10.0
"""
        )
        words = ["run", str(own), "--headless", "--speed", "max", "--csv", str(tmp_path / "c.csv")]
        assert CliRunner().invoke(cli, words).exit_code == 0
        rows = (tmp_path / "c.csv").read_text().splitlines()
        last = dict(zip(rows[0].split(","), map(float, rows[-1].split(",")), strict=True))
        assert batch.outputs[i, 0] == last["x"]
        assert batch.outputs[i, 1] == last["z"]
        assert batch.outputs[i, 3] == last["delta_s"]
    assert len(set(batch.seeds.tolist())) == 2


def test_members_differ_by_their_waves_alone_where_nothing_else_varies() -> None:
    text = (
        EXERCISE.partition("[[vary]]")[0].replace("{}", "10").replace("20.0\n[[ex", "12.0\n[[ex", 1)
    )
    subject = subject_of(parse_study(text, Path("test.toml")))

    assert len(set(subject.batch(0, 3).outputs[:, 0].tolist())) == 3
    alike = subject_of(
        parse_study(text.replace("seed = 4", "seed = 4\nseeds = 'one'"), Path("t.toml"))
    )
    assert len(set(alike.batch(0, 3).outputs[:, 0].tolist())) == 1
