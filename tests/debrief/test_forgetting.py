"""A forgotten name is nowhere any more, or it is told where it still stands, and why."""

import csv
import html
import io
import json
import os
import shutil
import sqlite3
from collections.abc import Callable, Iterator
from contextlib import closing
from pathlib import Path
from typing import Final, Literal
from unicodedata import normalize
from urllib.parse import quote

import platformdirs
import pytest
from helpers.recorded import record
from helpers.typed import type_command
from markupsafe import escape

from trainer.cli.main import cli
from trainer.config.exercise.class_file import BoatRow, ClassFile, class_text
from trainer.config.exercise.outcome import Outcome
from trainer.config.exercise.progress import ProgressRun, add_run
from trainer.config.files import ConfigError, toml_value
from trainer.debrief.marks.changes import Change, write_changes
from trainer.debrief.marks.forms import EvaluationForm, write_forms
from trainer.debrief.page.page import PAGE_BADGE
from trainer.debrief.trainees.class_debrief import CLASS_HEADER
from trainer.debrief.trainees.forgetting import SoughtName
from trainer.debrief.trainees.progress_words import write_table
from trainer.debrief.trainees.run_summary import SUMMARY_SUFFIX
from trainer.io.recording.recording import Recording
from trainer.session.past.header import open_recording, trainees_of

EXERCISE: Final = "first-depth-change"
NAME, OTHER = 'Rob "Al" O\'Brian', "C. Lee"
NUMBER: Final = "4711"
ODD_NAMES: Final = (
    NAME,
    "Bób Ærø",
    "Mark",
    NUMBER,
    "Жанна Ёлкина",
    "山田 太郎",
    "<b>Ann</b> & sons",
    "Al",
)
ENCODINGS: Final = ("utf-8", "utf-8-sig", "utf-16", "utf-16-be", "cp1252")


@pytest.fixture(scope="module")
def flown(tmp_path_factory: pytest.TempPathFactory) -> Path:
    said = {1.0: "stern planes dive 5", 2.0: f"relief {NAME}", 3.0: f"mark {NAME.upper()} was slow"}
    said |= {4.0: "relief 4711", 5.0: "mark Mark was quick"}
    path = tmp_path_factory.mktemp("flown") / "drill.trainer"
    names = (NAME, OTHER, "Mark", NUMBER)
    return record(path, EXERCISE, said, duration=10.0, trainee=names)


@pytest.fixture
def folder(flown: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the folder of a class in which a name stands wherever the product writes one."""
    monkeypatch.setattr(platformdirs, "user_data_dir", lambda *_, **__: str(tmp_path / "own"))
    folder = tmp_path / "class"
    for boat in (1, 2):
        (folder / f"boat-{boat}").mkdir(parents=True)
        shutil.copy(flown, folder / f"boat-{boat}" / "drill.trainer")
    rows = (BoatRow(number=1, name=NAME, trainees=(NAME, OTHER)), BoatRow(number=2))
    (folder / "class.toml").write_text(class_text(ClassFile(exercise=EXERCISE, boats=2, boat=rows)))
    write_table(folder / "marks.csv", CLASS_HEADER, table_rows(NAME))
    path = folder / "boat-1" / "drill.trainer"
    change = Change(branch=1.0, name="Depth", what="strike", reason=f"{NAME} was ill", at="today")
    write_changes(path, [change])
    form = EvaluationForm(
        exercise="", kind="peer", by=NAME, on="today", remark=f"as {NAME} says", marks={"Depth": 1}
    )
    write_forms(path, [form])
    path.with_name(f"drill{SUMMARY_SUFFIX}").write_text(json.dumps({"trainees": [NAME]}))
    (folder / "boat-1.log").write_text(f"noted: {NAME} has the helm\n", encoding="utf-8")
    for name in ("debrief/index.html", "pages.html/boat-1-drill.html"):
        (folder / name).parent.mkdir()
        page = f"<!doctype html>{PAGE_BADGE}<p>{escape(NAME)}</p>"
        (folder / name).write_text(page, encoding="utf-8")
    run = ProgressRun("drill.trainer", 1, EXERCISE, "", "2026-01-01", 60.0, Outcome.WON, 90.0)
    add_run(NAME, run)
    return folder


def table_rows(name: str) -> Iterator[list[str]]:
    """Yield rows of a class's table, one of them empty."""
    for boat, trainee in enumerate((name, "", OTHER), 1):
        rest = ["1.5"] * (len(CLASS_HEADER) - 5)
        yield ["tuesday", str(boat), "", trainee, EXERCISE, *rest]
        yield []


def written(name: str) -> Iterator[bytes]:
    """Yield a name in all writings in which it may stand in a file."""
    for case in (name, name.lower(), name.upper()):
        forms = {case, normalize("NFD", case), json.dumps(case)[1:-1], toml_value(case)[1:-1]}
        forms |= {str(escape(case)), html.escape(case), quote(case), case.replace('"', '""')}
        for form in forms:
            yield form.encode()
        for encoding in ("utf-16-le", "utf-16-be", "cp1252", "cp1251", "shift_jis", "gb18030"):
            try:
                yield case.encode(encoding)
            except UnicodeEncodeError:
                continue


def files_with(folder: Path, name: str) -> set[str]:
    """Return the files of a folder in whose bytes a name stands, however it is written."""
    forms = set(written(name))
    files = [path for path in folder.rglob("*") if path.is_file()]
    return {
        str(path.relative_to(folder))
        for path in files
        if any(each in path.read_bytes() for each in forms)
    }


def forget(*words: object, code: int = 0) -> str:
    """Return what the command says that forgets a name."""
    return type_command(cli, "recordings", *words[:-1], "--forget", words[-1], code=code).output


def test_a_name_is_gone_from_all_that_the_product_has_written(folder: Path) -> None:
    assert len(files_with(folder, NAME)) == 10
    told = forget(folder, NAME.lower())

    assert not files_with(folder.parent, NAME)
    assert told.count("the name is removed") == 7
    assert told.index("drill.trainer") < told.index("class.toml")
    assert OTHER in (folder / "class.toml").read_text(encoding="utf-8")
    with open_recording(folder / "boat-2" / "drill.trainer") as recording:
        assert trainees_of(recording.header()) == (OTHER, "Mark", NUMBER)
    with pytest.raises(ConfigError, match="no recording has that name"):
        forget(folder, NAME)


@pytest.mark.parametrize("name", ["", " ", "\t", "-", "\u00a0"])
def test_what_is_no_name_is_refused_and_nothing_is_touched(folder: Path, name: str) -> None:
    before = {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}

    with pytest.raises(ConfigError, match="say whose name"):
        forget(folder, name)

    assert {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()} == before


def test_a_folder_that_cannot_be_looked_through_is_told(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    scan = os.scandir

    def scandir(path: str) -> "os._ScandirIterator[str]":
        if Path(path).name == "boat-2":
            raise PermissionError(13, "Permission denied", str(path))
        return scan(path)

    monkeypatch.setattr(os, "scandir", scandir)

    told = forget(folder, NAME, code=1)

    assert f"{folder / 'boat-2'}: the name may be in it: Permission denied" in told
    assert "drill.trainer: the name is removed" in told


@pytest.mark.parametrize("encoding", ENCODINGS)
@pytest.mark.parametrize("dialect", [",", ";", "\t", "all ;"])
def test_a_table_saved_again_in_another_country_is_cleaned(
    dialect: str, encoding: str, tmp_path: Path
) -> None:
    path, names = tmp_path / "marks.csv", [*ODD_NAMES]
    if encoding == "cp1252":
        names = [name for name in names if name.isascii() or name.startswith("B")]
    if "16" in encoding:
        names.remove(NUMBER)  # a bare number is not looked for there
    for name in names:
        text = io.StringIO(newline="")
        quoting: Literal[0, 1] = csv.QUOTE_ALL if "all" in dialect else csv.QUOTE_MINIMAL
        writer = csv.writer(text, delimiter=dialect[-1], quoting=quoting)
        writer.writerows([CLASS_HEADER, *table_rows(name)])
        path.write_bytes(text.getvalue().encode(encoding))
        before = path.read_bytes().decode(encoding)
        assert "the name is removed" in forget(tmp_path, name)

        after = path.read_bytes().decode(encoding)
        assert before.count(name.replace('"', '""')) == after.count("(name removed)") == 1
        assert len(after.splitlines()) == len(before.splitlines())
        assert after.count(OTHER) == 1


@pytest.mark.parametrize("name", ODD_NAMES)
def test_a_name_is_found_and_removed_in_whatever_writing_and_not_within_another(name: str) -> None:
    sought = SoughtName(name)
    if name != NUMBER:
        for form in (*written(name),):
            if name != "Mark" or form[:1].isupper():
                assert sought.taken_from(b"(" + form + b")") != b"(" + form + b")", form
        assert (
            sought.without(f"{name}son, Ma{name}, {name}") == f"{name}son, Ma{name}, (name removed)"
        )
    assert sought.without("mark so far, 12.4711 s, 4711 t") == "mark so far, 12.4711 s, 4711 t"


def freed(path: Path) -> None:
    """Leave a name on pages that are free, as an older version that made tables anew."""
    with closing(sqlite3.connect(path, isolation_level=None)) as connection:
        connection.execute("PRAGMA secure_delete = OFF")
        connection.execute("DELETE FROM header WHERE key = 'trainees'")
        connection.execute("UPDATE events SET text = '', who = ''")
        connection.execute("UPDATE orders SET text = 'planes zero', answer = '', crew_order = ''")
        connection.execute("CREATE TABLE other (x)")
        connection.executemany("INSERT INTO other VALUES (?)", [(f"{NAME} " * 900,)] * 9)
        connection.execute("DROP TABLE other")


def unwatched(path: Path) -> None:
    """Leave a name in a remark alone, of whom no header tells."""
    with closing(sqlite3.connect(path, isolation_level=None)) as connection:
        connection.execute("DELETE FROM header WHERE key = 'trainees'")
        connection.execute("DELETE FROM orders")
        connection.execute(
            "INSERT INTO events (branch, tick, kind, who, text, wall, role) "
            "VALUES (1, 2, 'crew', ?, ?, '', 'helm')",
            (f"helm called {NAME}", f"{NAME} said so"),
        )


def killed(path: Path) -> None:
    """Leave the last of a recording in the log beside it, as a killed session does."""
    whole = path.with_name("whole.db")
    path.rename(whole)
    with closing(sqlite3.connect(whole, isolation_level=None)) as connection:
        connection.execute("PRAGMA journal_mode = WAL")
        connection.execute("UPDATE events SET text = text || ?", (f" beside {NAME}",))
        for end in ("", "-wal"):
            shutil.copy(f"{whole}{end}", f"{path}{end}")
    whole.unlink()


def test_a_name_that_is_a_part_of_anothers_leaves_the_other_whole(tmp_path: Path) -> None:
    names, said = ("Ann", "Ann Smith", "Mary Ann"), {1.0: "mark Ann, and Ann Smith"}
    path = record(tmp_path / "two.trainer", EXERCISE, said, duration=5.0, trainee=names)
    rows = [row for name in names for row in table_rows(name)]
    write_table(tmp_path / "marks.csv", CLASS_HEADER, rows)
    forget(tmp_path, "Ann")

    with closing(Recording.look(path)) as recording:
        assert trainees_of(recording.header()) == names[1:]
        (*_, order) = recording.orders(1)
    assert order.text == "mark (name removed), and Ann Smith"
    table = (tmp_path / "marks.csv").read_text(encoding="utf-8")
    told = (",Ann,", ",Ann Smith,", ",Mary Ann,", "(name removed)")
    assert [table.count(each) for each in told] == [0, 1, 1, 1]


@pytest.mark.parametrize("change", [freed, unwatched, killed])
def test_a_name_is_gone_from_free_pages_remarks_and_the_log_beside_a_recording(
    change: Callable[[Path], None], flown: Path, tmp_path: Path
) -> None:
    path = Path(shutil.copy(flown, tmp_path / "drill.trainer"))
    change(path)
    assert files_with(tmp_path, NAME)
    forget(tmp_path, NAME)

    assert not files_with(tmp_path, NAME)
    Recording.reopen(path).close()


def test_what_cannot_be_cleaned_is_told_with_why_and_the_rest_is_cleaned(folder: Path) -> None:
    damaged = folder / "boat-2" / "drill.trainer"
    data = damaged.read_bytes()
    damaged.write_bytes(data[:100] + b"\xff" * 300 + data[400:])
    (folder / "class.toml").write_text(f'trainees = ["{OTHER}"\n# {NAME}\n', encoding="utf-8")
    (folder / "roster.csv").write_text(f"pupil;class\n{NAME};3\n", encoding="cp1252")
    (folder / "drill.pdf").write_bytes(b"%PDF-1.4 packed")
    (folder / f"{NAME.split(maxsplit=1)[0]}.txt").write_text(f"letter to {NAME}", encoding="utf-16")
    used = folder / "boat-1" / "used.trainer"
    shutil.copy(folder / "boat-1" / "drill.trainer", used)
    with closing(Recording.reopen(used)):
        told = forget(folder, NAME, code=1)

    left = {"boat-2/drill.trainer", "class.toml", "roster.csv", "Rob.txt", "boat-1/used.trainer"}
    assert files_with(folder, NAME) == left
    said = [line for line in told.splitlines() if line.startswith("trainer: ")]
    for name in (*left, "drill.pdf"):
        (line,) = [each for each in said if f"{folder / name}: " in each]
        assert any(
            why in line for why in ("is damaged", "the trainer writes none", "is packed", "in use")
        ), line
    assert len(said) == 6


def test_a_name_between_texts_of_a_recording_that_nobody_can_read_is_told(tmp_path: Path) -> None:
    path = tmp_path / "drill.trainer"
    path.write_bytes(b"SQLite format 3\0" + bytes(100) + f"helm{NAME}said".encode())

    assert f"{path}: the name is still in it: " in forget(tmp_path, NAME, code=1)


def test_a_name_in_what_is_sailed_is_told_and_the_recording_is_flown_as_before(
    flown: Path, tmp_path: Path
) -> None:
    path = Path(shutil.copy(flown, tmp_path / "Mark.trainer"))
    with closing(sqlite3.connect(path, isolation_level=None)) as connection:
        connection.execute("UPDATE header SET value = value || ' ' WHERE key = 'texts'")
        connection.execute("UPDATE orders SET text = 'contact Mark speed 5' WHERE id = 1")
    told = forget(path, "Mark", code=1)

    assert "the name is still in it: orders 1\n" in told
    assert f"{path}: its own name has it" in told
    with closing(Recording.look(path)) as recording:
        said = [each.text for each in recording.orders(1)]
    assert said == [
        *(
            "contact Mark speed 5",
            "stern planes dive 5",
            f"relief {NAME}",
            f"mark {NAME.upper()} was slow",
        ),
        *("relief 4711", "mark (name removed) was quick"),
    ]


def test_a_recording_without_a_name_is_replayed_to_the_same_bits(tmp_path: Path) -> None:
    said = {0.5: "relief Ann Ott", 1.0: "stern planes dive 5", 2.0: "mark Ann Ott was quick"}
    path = record(tmp_path / "drill.trainer", EXERCISE, said, duration=5.0, trainee=("Ann Ott",))
    forget(path, "Ann Ott")

    assert "the same" in type_command(cli, "replay", path).output


def test_a_bare_number_is_forgotten_where_it_is_a_name(flown: Path, tmp_path: Path) -> None:
    path = Path(shutil.copy(flown, tmp_path / "drill.trainer"))
    forget(tmp_path, NUMBER)

    with closing(Recording.look(path)) as recording:
        assert NUMBER not in trainees_of(recording.header())
        assert "relief (name removed)" in [each.text for each in recording.orders(1)]


def test_the_folder_of_a_classs_pages_is_cleaned_alone(folder: Path) -> None:
    told = forget(folder / "pages.html", NAME)

    assert "boat-1-drill.html: removed, it showed the name" in told
    assert not files_with(folder / "pages.html", NAME)
    assert "boat-1/drill.trainer" in files_with(folder, NAME)
