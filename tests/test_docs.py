"""Every command in the documents is run in an empty folder; the tutorial's in test_tutorial.py."""

import re
from pathlib import Path

import pytest
from helpers.installation import SLOW_PACKAGES, installed
from helpers.nursery import run_trainer
from helpers.shell import ran, understand

ROOT = Path(__file__).parent.parent
PAGES = [*sorted(ROOT.glob("docs/*.md")), ROOT / "README.md"]


# in this one a table tells of commands what they return
PAGES.remove(ROOT / "docs" / "exit-codes.md")


def commands(page: Path) -> list[str]:
    """Return the lines of the page's shell blocks, and of its table of what to type."""
    text = page.read_text(encoding="utf-8")
    blocks = re.findall(r"```sh\n(.*?)```", text, re.DOTALL)
    lines = [line for block in blocks for line in block.splitlines()]
    lines += re.findall(r"\| `(trainer [^`]*)`", text)
    return [line for line in lines if line and not line.startswith("#")]


def runnable(line: str) -> bool:
    """Return whether a test can run the command: it needs no port, file or installation."""
    return not re.search(r"\b(URL|FILE)\b|pip install|\./boat\.toml|my-boat\.toml", line)


def shown(page: Path) -> dict[str, str]:
    """Return what a page shows of its commands: a block ``seen`` follows one of a single line."""
    text = page.read_text(encoding="utf-8")
    return dict(re.findall(r"```sh\n([^\n]*)\n```\n+```seen\n(.*?)```", text, re.DOTALL))


SHOWN = {line: text for page in PAGES for line, text in shown(page).items()}
# what a reader types one after the other in one folder, since each needs what the first wrote
FIRST_IN_FOLDER = {
    "exported-core.md": "trainer boat export-core ",
    "fitted-boat.md": "trainer boat estimate ",
    "watched-boat.md": "trainer boat estimate ",
    "classroom.md": "trainer class new ",
}
GOES_ON = re.compile(r"--part 2/2|--join parts")  # with what the line before has written


def cases(page: Path) -> list[str]:
    """Return what is typed in a folder each: the commands of a page, or those of one beginning."""
    lines = list[str]()
    for line in commands(page):
        lines += [f"{lines.pop()} && {line}" if GOES_ON.search(line) else line]
    if page.name not in FIRST_IN_FOLDER:
        return lines
    first = FIRST_IN_FOLDER[page.name]
    rows = "\n".join(lines).split(f"\n{first}")
    return [(first * bool(i) + row).replace("\n", " && ") for i, row in enumerate(rows)]


FIRST_PAGES = {line: page for page in reversed(PAGES) for line in cases(page)}
# what takes minutes, and has tests of its own
SLOW = re.compile(
    r"dev learn |"
    r"bench --(footprint|machines|against-c|seconds 2)|sweep (overshoots|centre-of-gravity)"
    r"|guide bb2 (--uncertainty )?--html|estimate small-boat|export-core (core|arm|risc|m7)"
    r"|identify --example|ship prbs bb2|run periscope-depth --web|run --web-at|guide mariner"
    r"|reduce bb2 --check|fuzz --list|tests.bench --helm"
    r"|bench --latency|^trainer dev bench$|tests\.(soak|cases)|run depth-changes .* trainer debrief"
)
SLOW_PAGES = {  # for engineers: many flights, each of a kind that has tests of its own
    *("report-1969.md", "recordings.md", "sweeps.md", "boat-by-mail.md", "own-hull.md"),
    *("reduction.md", "debrief.md", "engineer.md", "identification.md", "report-1974.md"),
    *("vessel-files.md", "exercises.md", "exercise-files.md", "validation.md"),
    *("identification-records.md", "steering.md", "guide.md", "ship-trials.md"),
    *("measures.md", "trainees.md", "world-tables.md"),
}
CASES = [
    pytest.param(
        line,
        id=f"{page.name}: {line[:60]}",
        marks=[pytest.mark.slow] if SLOW.search(line) or page.name in SLOW_PAGES else [],
    )
    for line, page in FIRST_PAGES.items()
    if runnable(line) and page.name != "tutorial.md"
]


def test_there_are_commands_to_run() -> None:
    assert len(CASES) > 8


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_what_a_page_types_are_commands_and_options_that_there_are(page: Path) -> None:
    for line in commands(page):
        if "trainer" in line and not re.search(r"[$`]|pip install", line):
            understand(line)


@pytest.mark.process
@pytest.mark.parametrize("line", CASES)
def test_a_documented_command_works(line: str, tmp_path: Path) -> None:
    for program in set(line.split()) & set(SLOW_PACKAGES):
        installed(program, SLOW_PACKAGES[program])
    done = ran(line, tmp_path)

    assert done.returncode == 0, done.stderr
    assert done.stdout
    assert "Traceback" not in done.stderr
    shown_lines = SHOWN.get(line, "").splitlines()
    assert [each for each in shown_lines if each.rstrip() not in done.stdout] == []


NEVER = "cannot be"  # how the command of a row without a test begins
# of a table about a report: what it is, what is here, its command, and a test as a sentence
REPORT_ROW = re.compile(
    r"^\| ([^|]+) \| [^|]+ \| ([^|]+) \| (?:([^|`]+) \(`([^|`]+)`\)|none) \|$", re.MULTILINE
)


@pytest.mark.parametrize("year", ["1969", "1974"])
def test_a_row_of_a_report_has_a_test_that_is_there_or_says_it_has_none(year: str) -> None:
    text = (ROOT / "docs" / f"report-{year}.md").read_text(encoding="utf-8")
    rows = REPORT_ROW.findall(text)
    faults = [
        f"{name}: {said or 'no test'} {file}"
        for name, command, said, file in rows
        if bool(said) == command.startswith(NEVER) or (said and not is_there(file, said))
    ]

    assert len(rows) == text.count("\n| ") - text.count("\n| |")  # but the heads
    assert not faults


SAID_OF_TABLES_1969 = {  # what was read of the report, in the words of its page
    "8": "19 lateral coefficients that are necessary, and 8 to be investigated",
    "10": "22 coefficients of cross-coupling that are not zero",
    "12": "6 kn 7.7, -1.1, -4.3 %; 12 kn 13.0, 3.7, 10.9 %",
    "13": "Z_star and M_star left deep: 3.6, 1.1, 1.3 %",
    "16": "COMMON 268: 2632; MAIN 417, FORTRAN I/O 1698, error check 215: 2330",
    "17": "NOVA 10,000",
}


def test_the_page_says_what_the_tables_of_1969_are() -> None:
    text = (ROOT / "docs" / "report-1969.md").read_text(encoding="utf-8")
    rows = dict(re.findall(r"^\| Table (\d+) \| ([^|]*) \|", text, re.MULTILINE))

    assert [name for name, said in SAID_OF_TABLES_1969.items() if said not in rows[name]] == []


def is_there(file: str, said: str) -> bool:
    """Return whether a file has a test whose name, as a sentence, is that."""
    name = said.replace(" ", "_")
    return f"\ndef test_{name}(" in (ROOT / "tests" / file).read_text(encoding="utf-8")


def example_files(page: str) -> list[str]:
    """Return the TOML examples of a page."""
    text = (ROOT / "docs" / page).read_text(encoding="utf-8")
    return re.findall(r"```toml\n(.*?)```", text, re.DOTALL)


# page, how its examples are run: what a newcomer copies from a page must do as it stands there
FLIGHT = ["run", "--headless", "--speed", "max", "--duration", "60"]
ANY = 'schema = "exercise/1"\nname = "Any"\nbriefing = "Any."\n'
EXAMPLES = [
    *(
        (ANY + text, ["./example.toml"])
        for text in example_files("world.md")
        if text.startswith("[current]")
    ),
    *((text, ["--sea", "./example.toml"]) for text in example_files("seas.md")),
    *((text, ["./example.toml"]) for text in example_files("exercise-files.md")),
]


@pytest.mark.process
@pytest.mark.parametrize(("text", "how"), EXAMPLES)
def test_an_example_file_of_the_documents_runs(text: str, how: list[str], tmp_path: Path) -> None:
    (tmp_path / "example.toml").write_text(text, encoding="utf-8")

    done = run_trainer(*FLIGHT, *how, cwd=tmp_path, timeout=300)

    assert done.returncode == 0, done.stderr
    assert "simulated   60.0 s" in done.stdout


@pytest.mark.process
@pytest.mark.parametrize("text", example_files("casualties.md"))
def test_an_example_table_of_casualties_is_listed(text: str, tmp_path: Path) -> None:
    (tmp_path / "own.toml").write_text(text, encoding="utf-8")
    names = re.findall(r"^\[casualty\.(.*)\]", text, re.MULTILINE)

    done = run_trainer("casualties", "./own.toml", cwd=tmp_path, timeout=300)

    assert done.returncode == 0, done.stderr
    assert names
    assert all(f"\n{name} " in f"\n{done.stdout}" for name in names)
