"""An output with the name of an input is refused before anything is computed, in every command."""

import os
import sys
from collections.abc import Callable, Iterator
from itertools import combinations
from pathlib import Path

import click
import pytest
from helpers.decca_run import FILE as DECCA_STUDY
from helpers.recorded import record

from trainer.boat import compilation
from trainer.boat.boat import Boat
from trainer.cli import main
from trainer.cli.recordings import export
from trainer.cli.types import File, Name, Output
from trainer.config.files import read_text, shipped_path
from trainer.identify.pages import results
from trainer.io.outputs import FILE_KINDS, note_input

Typed = Callable[..., tuple[int, str]]
CONTENT = b"what was measured\n"
MIN_OUTPUTS = 50  # of all commands together: fewer would mean that the walk is blind


@pytest.fixture
def typed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Typed:
    """Give what runs a command line here, in an empty folder; it returns exit code and stderr."""
    monkeypatch.chdir(tmp_path)

    def run(*words: str) -> tuple[int, str]:
        monkeypatch.setattr(sys, "argv", ["trainer", *words])
        capsys.readouterr()
        with pytest.raises(SystemExit) as ended:
            main.run_command(main.cli, "trainer")
        return int(ended.value.code or 0), capsys.readouterr().err

    return run


def commands_below(
    words: tuple[str, ...], command: click.Command
) -> Iterator[tuple[tuple[str, ...], click.Command]]:
    """Yield all commands and the words that are typed for them."""
    if not isinstance(command, click.Group):
        yield words, command
    below: dict[str, click.Command] = getattr(command, "commands", {})
    for name, each in below.items():
        yield from commands_below((*words, name), each)


COMMANDS = [
    (words, command, [one for one in command.params if isinstance(one.type, Output)])
    for words, command in commands_below((), main.cli)
]
WRITERS = [each for each in COMMANDS if each[2]]


def line_of(words: tuple[str, ...], command: click.Command, given: dict[str, str]) -> list[str]:
    """Return a command line with these parameters; other arguments have a name that will do."""
    line = list(words)
    for param in command.params:
        name = param.name or ""
        if isinstance(param, click.Option) and name in given:
            line += [max(param.opts, key=len), given[name]]
        if isinstance(param, click.Argument):
            own = param.type.endings[:1] if isinstance(param.type, File) else ()
            usual = f"free-{name}{''.join(own)}" if isinstance(param.type, File) else "bb2"
            choices = getattr(param.type, "choices", (usual,))
            line.append(given.get(name, choices[0]))
    return line


def no_work(*_given: object, **_options: object) -> None:
    raise AssertionError("the command has begun")


def refusal_fault(told: tuple[int, str]) -> str:
    """Return what is wrong with a refusal, "" if it is one line and exit code 2."""
    code, text = told
    good = code == 2 and text.count("\n") == 1 and text.startswith("trainer: ") and "another name"
    return "" if good and "another name" in text else f"{code}: {text}"


def test_the_walk_sees_the_commands_with_an_output() -> None:
    assert sum(len(outputs) for _, _, outputs in WRITERS) >= MIN_OUTPUTS
    names = {" ".join(words) for words, _, _ in WRITERS}
    assert names >= {
        *("run", "serve", "resume", "export", "debrief", "recordings", "identify", "identify new"),
        *("ship decca", "ship prbs", "ship steering", "ship identify", "dev schema"),
        *("report-1969 compare", "report-1969 fit"),
        *("boat estimate", "boat reduce", "boat guide", "boat manoeuvre", "boat sweep", "boat sea"),
        *("boat export-page", "boat export-core", "boat export-fmu", "boat new"),
        *("exercise new", "exercise form", "exercise validate", "boat check-cases"),
    }


def test_no_option_takes_a_path_that_the_walk_does_not_see() -> None:
    """A plain path of click's is neither noted as an input nor refused as an output."""
    plain = {
        (*words, one.name)
        for words, command, _ in COMMANDS
        for one in command.params
        if isinstance(one.type, click.Path | click.File) and not isinstance(one.type, File)
    }
    noted = {("boat", "check-cases", "folder")}  # whose files are noted as they are read
    kept = {("class", "folder"), ("class", "resume")}  # folders, as are those of a debrief
    assert plain == noted | kept | {("class", "debrief", name) for name in ("folder", "html")}


def test_an_output_that_is_an_input_is_refused_under_every_name(
    typed: Typed, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    faults, tried = [], 0
    for words, command, outputs in WRITERS:
        monkeypatch.setattr(command, "callback", no_work)
        inputs = [one for one in command.params if type(one.type) in (File, Name)]
        for output, read in ((output, read) for output in outputs for read in inputs):
            own = output.type.endings if isinstance(output.type, File) else ()
            known = read.type.endings if isinstance(read.type, File) else (".toml",)
            path = tmp_path / f"in{''.join(known[:1])}"
            path.write_bytes(CONTENT)
            hard, soft = tmp_path / f"hard{''.join(own[:1])}", tmp_path / f"soft{''.join(own[:1])}"
            hard.hardlink_to(path)
            soft.symlink_to(path.name)
            names = [hard.name, str(soft), *({f"./{path.name}"} if own[:1] == known[:1] else ())]
            for name in names:
                given = {
                    output.name or "": name,
                    read.name or "": f"../{tmp_path.name}/{path.name}",
                }
                line = line_of(words, command, given)
                tried += 1
                if fault := refusal_fault(typed(*line)):
                    faults.append(f"{' '.join(line)}: {fault}")
                if path.read_bytes() != CONTENT or not hard.samefile(path):
                    faults.append(f"{' '.join(line)}: the input is lost")
            for each in tmp_path.iterdir():
                each.unlink()
        monkeypatch.undo()
        monkeypatch.chdir(tmp_path)
    assert tried > 300
    assert faults == []


def test_an_ending_of_another_kind_is_refused(typed: Typed, tmp_path: Path) -> None:
    """Whether there is such a file or not: nobody looks for a page in drill.trainer."""
    faults = []
    for words, command, outputs in WRITERS:
        for output in outputs:
            kind = output.type
            assert isinstance(kind, Output)
            for ending in FILE_KINDS.keys() - {*kind.endings}:
                line = line_of(words, command, {output.name or "": f"zz{ending.upper()}"})
                if fault := refusal_fault(typed(*line)):
                    faults.append(f"{' '.join(line)}: {fault}")
    assert faults == []
    assert not list(tmp_path.iterdir())


def test_two_outputs_of_a_command_are_two_files(typed: Typed, tmp_path: Path) -> None:
    faults, tried = [], 0
    for words, command, outputs in WRITERS:
        for first, second in combinations(outputs, 2):
            given = {first.name or "": "both.out", second.name or "": "./both.out"}
            line = line_of(words, command, given)
            tried += 1
            if fault := refusal_fault(typed(*line)):
                faults.append(f"{' '.join(line)}: {fault}")
    assert tried > 30
    assert faults == []
    assert not list(tmp_path.iterdir())


def test_an_output_without_a_folder_is_refused_before_anything_is_done(
    typed: Typed, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    faults, tried = [], 0
    for words, command, outputs in WRITERS:
        monkeypatch.setattr(command, "callback", no_work)
        for output in outputs:
            kind = output.type
            assert isinstance(kind, Output)
            if not kind.endings:  # a folder, which is made
                continue
            tried += 1
            line = line_of(words, command, {output.name or "": f"no/out{kind.endings[0]}"})
            code, told = typed(*line)
            if code != 2 or "there is no folder no" not in told:
                faults.append(f"{' '.join(line)}: {code}: {told}")
    assert tried >= MIN_OUTPUTS
    assert faults == []
    assert not list(tmp_path.iterdir())


REFUSED_LATE = [  # lines whose last words are wrong, where those before them would be carried out
    "debrief it.trainer --change CHANGE --text --json",
    "debrief it.trainer --text --change CHANGE --reference-from 9999",
    "debrief it.trainer --html new.html --change CHANGE --reference-from 9999",
    "debrief it.trainer --text --change CHANGE --form wrong.toml",
    "debrief it.trainer --form form.toml --text --json",
    "debrief it.trainer --text --form form.toml --change nonsense",
    "debrief it.trainer --text --form form.toml --reference-from 9999",
    "debrief it.trainer --html new.html --branch 7",
    "debrief it.trainer --change CHANGE",
    "export it.trainer --csv new.csv --plot new.svg --column depht",
    "export it.trainer --csv new.csv --plot new.svg --branch 7",
    "recordings --csv new.csv --progress --trainee Nobody",
]


@pytest.mark.long
@pytest.mark.usefixtures("few_points")
@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_a_refused_command_changes_nothing(
    typed: Typed, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    record(tmp_path / "it.trainer", "steady-course", {}, "instructor at a desk")
    assert typed("exercise", "form", "steady-course", "-o", "form.toml")[0] == 0
    form = (tmp_path / "form.toml").read_text().replace('by = ""', 'by = "B. Smith"')
    (tmp_path / "form.toml").write_text(form)
    (tmp_path / "wrong.toml").write_text(form.replace("form/1", "form/2"))
    (tmp_path / "it.html").write_text("no page of ours")  # where the page would go by itself
    typed("debrief", "it.trainer", "--text")  # what is kept of each run

    def kept() -> dict[Path, bytes]:
        return {each: each.read_bytes() for each in tmp_path.rglob("*") if each.is_file()}

    before = kept()
    faults = []
    for line in REFUSED_LATE:
        words = ["outcome: lost, tested" if word == "CHANGE" else word for word in line.split()]
        code, told = typed(*words)
        if code != 2 or kept() != before:
            changed = [str(each) for each in kept() if kept()[each] != before.get(each)]
            faults.append(f"{line}: {code}: {told.strip()[:80]}; changed {changed}")
    assert faults == []
    assert typed("debrief", "it.trainer", "--change", "outcome: lost, tested", "--text")[0] == 0
    assert kept() != before


def test_the_recording_is_named_where_a_page_was_to_be_written(typed: Typed) -> None:
    code, told = typed("export-page", "zz.trainer")
    assert code == 2
    assert "such as zz.html; --recording zz.trainer reads it" in told


def make_study(folder: Path) -> None:
    """Write a study, its record and its boat."""
    text = read_text(shipped_path("records", "example"))
    folder.joinpath("b.toml").write_text(text.replace("example.csv", "b.csv"), encoding="utf-8")
    record = shipped_path("records", "example").with_suffix(".csv")
    folder.joinpath("b.csv").write_bytes(record.read_bytes())
    folder.joinpath("lanes.csv").write_text("t,red,green,purple,heading\n", encoding="utf-8")
    lanes = DECCA_STUDY.format(east=0, north=0)
    folder.joinpath("d.toml").write_text(lanes, encoding="utf-8")
    vessel = read_text(shipped_path("vessels", "bb2"))
    folder.joinpath("v.toml").write_text(vessel, encoding="utf-8")
    sweep = read_text(shipped_path("studies", "turn-uncertainty"))
    changed = sweep.replace('vessel = "bb2"', 'vessel = "v.toml"')
    folder.joinpath("s.toml").write_text(changed, encoding="utf-8")
    sea = read_text(shipped_path("seas", "sea-state-3"))
    folder.joinpath("sea.toml").write_text(sea, encoding="utf-8")
    exercise = (
        'schema = "exercise/1"\nname = "x"\nbriefing = "x"\nvessel = "v.toml"\nsea = "sea.toml"\n'
    )
    folder.joinpath("x.toml").write_text(exercise, encoding="utf-8")


@pytest.mark.parametrize(
    ("line", "lost"),
    [
        ("identify b.toml --csv OUT.csv", "b.csv"),
        ("identify b.toml --html OUT", "b.csv"),
        ("identify b.toml --plot OUT.svg", "b.csv"),
        ("identify b.toml --write-nomoto OUT.toml", "b.csv"),
        ("identify b.toml --armax --html OUT.html", "b.csv"),
        ("identify b.csv --model 1 --vessel ./v.toml --write-vessel OUT.toml", "v.toml"),
        ("decca d.toml --csv OUT.csv", "lanes.csv"),
        ("decca d.toml --plot OUT.png", "lanes.csv"),
        ("sweep s.toml --plot OUT.svg", "v.toml"),
        ("sweep s.toml --out OUT.parquet", "v.toml"),
        ("run x.toml --headless --speed max --duration 1 --csv OUT.csv", "v.toml"),
        ("run x.toml --headless --speed max --duration 1 --rrd OUT.rrd", "sea.toml"),
        ("exercise form x.toml -o OUT.toml", "v.toml"),
    ],
)
def test_what_a_file_names_is_an_input_too(
    typed: Typed, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, line: str, lost: str
) -> None:
    monkeypatch.setattr(Boat, "__init__", no_work)
    for name in ("fit_study", "simulate_study"):
        monkeypatch.setattr(results, name, no_work)
    monkeypatch.setattr(compilation, "mark_path", lambda *_: tmp_path)  # as if fits were compiled
    make_study(tmp_path)
    before = (tmp_path / lost).read_bytes()
    (name,) = (word for word in line.split() if word.startswith("OUT"))
    out = tmp_path / name
    for link in (out.hardlink_to, out.symlink_to):
        link(tmp_path / lost)
        assert refusal_fault(typed(*line.split())) == ""
        assert (tmp_path / lost).read_bytes() == before
        out.unlink()


def test_what_a_command_has_written_it_may_write_again(typed: Typed, tmp_path: Path) -> None:
    for _ in range(2):
        assert typed("schema", "sea", "-o", "sea.schema.json") == (0, "")
    assert (tmp_path / "sea.schema.json").stat().st_size > 100
    assert typed("schema", "sea", "-o", os.devnull) == (0, "")


@pytest.mark.long
def test_a_boat_of_one_s_own_is_not_written_over_but_an_estimate_is(
    typed: Typed, tmp_path: Path
) -> None:
    line = ("boat", "estimate", "small-boat", "-o", "mine.toml", "--draws", "0")
    assert typed(*line)[0] == typed(*line)[0] == 0
    (tmp_path / "mine.toml").unlink()
    assert typed("boat", "new", "mine.toml", "--from", "bb2")[0] == 0
    before = (tmp_path / "mine.toml").read_bytes()
    assert typed(*line)[0] == 2
    assert (tmp_path / "mine.toml").read_bytes() == before


def test_a_file_that_is_kept_between_searches_is_of_no_other_kind(typed: Typed) -> None:
    code, told = typed("identify", "b.toml", "--checkpoint", "b.toml")
    assert code == 2
    assert ".toml is the ending of a file of settings" in told


def test_words_half_typed_promise_nothing(tmp_path: Path) -> None:
    """A shell asks for completions again and again, of lines that are never run."""
    path = tmp_path / "a.csv"
    path.write_bytes(CONTENT)
    words = ["in.trainer", "--csv", str(path)]
    context = export.make_context("export", words, resilient_parsing=True)
    assert context.params["csv"] == path
    note_input(path)
