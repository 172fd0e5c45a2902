"""A system of the user's own: read, refused, and fitted like any other."""

import ast
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.lanes import sample_cases
from helpers.places import ROOT
from helpers.rolling import PROGRAM, ROWS, SYSTEM, K, W, Z, sampled, write_record, write_study
from helpers.studies import identified, numbers
from helpers.typed import type_command
from numpy.testing import assert_allclose

from trainer.cli.workshop.identify import identify
from trainer.config.files import ConfigError
from trainer.identify.model.sampled import COMPLEX_STEP, step_aside
from trainer.identify.model.system_files import load_system, parse_expression

pytest.importorskip("scipy")

TRUE = {"w": W, "z": Z, "k": K, "roll_0": 2.0}


def assert_found(report: Any) -> None:
    """Check that the truth is found, within four deviations that are small."""
    assert report["converged"]
    for name, true in TRUE.items():
        value, deviation = numbers(report)[name]
        assert abs(value - true) < 4.0 * deviation, name
    assert numbers(report)["w"][1] < 0.01


@pytest.mark.long
@pytest.mark.parametrize(
    "noise", sample_cases(["covariance", "innovations", "output-error"], "innovations")
)
def test_a_system_in_a_file_is_found(tmp_path: Path, noise: str) -> None:
    report = identified(write_study(tmp_path), "--noise", noise)
    assert_found(report)
    ship = {one["name"]: one for one in report["ship"]}
    # a pair: Re = -z w, Im = w sqrt(1 - z^2); steady gain k
    assert ship["1/T1"]["value"] == pytest.approx(Z * W, rel=0.1)
    assert ship["period 1"]["value"] == pytest.approx(
        2 * np.pi / (W * np.sqrt(1 - Z * Z)), rel=0.02
    )
    assert ship["fin to roll"]["low"] < ship["fin to roll"]["value"] < ship["fin to roll"]["high"]
    assert ("q" in numbers(report)) == (noise != "output-error")


@pytest.mark.slow
def test_a_program_finds_what_the_file_finds(tmp_path: Path) -> None:
    study, program = write_study(tmp_path), tmp_path / "system.py"
    program.write_text(PROGRAM)
    by_file, by_program = identified(study), identified(study, "--system", program)
    for name, (value, deviation) in numbers(by_file).items():
        assert numbers(by_program)[name][0] == pytest.approx(value, rel=1e-6, abs=1e-3 * deviation)
        assert numbers(by_program)[name][1] == pytest.approx(deviation, rel=1e-4)


def test_a_program_is_run_only_where_the_command_names_it(tmp_path: Path) -> None:
    study, mark = write_study(tmp_path), tmp_path / "ran"
    (tmp_path / "system.py").write_text(f"open({str(mark)!r}, 'w').close()\n" + PROGRAM)
    study.write_text(study.read_text().replace("system.toml", "system.py"))
    with pytest.raises(ConfigError, match="is run only where the command names it"):
        identified(study)
    assert not mark.exists()
    identified(study, "--system", tmp_path / "system.py")
    assert mark.exists()


@pytest.mark.parametrize(
    ("body", "how"),
    [
        ("w**2", "complex step"),
        ("np.exp(2 * np.log(w))", "complex step"),
        ("math.exp(2 * math.log(w))", "differences"),  # takes no complex number
        ("abs(w) ** 2", "differences"),  # loses the step in silence
        ("max(w.real, 0) * w", "differences"),  # loses a half of it
    ],
)
def test_slopes_of_a_program_are_exact_or_by_differences(
    tmp_path: Path, body: str, how: str
) -> None:
    path = tmp_path / "system.py"
    path.write_text("import math\nimport numpy as np\n" + PROGRAM.replace("-(w**2)", f"-({body})"))
    system = load_system(path)
    found = system.matrices(step_aside(system.starts))["A"]
    assert system.how == how
    assert_allclose(found[0].real, [[0.0, 1.0], [-0.36, -0.24]], rtol=1e-12)
    assert_allclose(found[1].imag / COMPLEX_STEP, [[0.0, 0.0], [-1.2, -0.4]], rtol=1e-7)
    assert_allclose(found[2].imag / COMPLEX_STEP, [[0.0, 0.0], [0.0, -1.2]], rtol=1e-7, atol=1e-12)


def test_matrices_of_one_step_are_found_too(tmp_path: Path) -> None:
    Phi, Gamma, noise = sampled()
    text = SYSTEM.split("A =", maxsplit=1)[0] + 'time = "discrete"\n'
    text += f'A = [["a", {Phi[0, 1]}], ["b", {Phi[1, 1]}]]\nB = [["g"], [{Gamma[1]}]]\n'
    text += f'C = [[1, 0]]\nR1 = {noise.tolist()}\nR2 = [["s"]]\nx0 = [2, 0]\n'
    starts = {"a": 0.9, "b": -0.1, "g": 0.1, "s": 0.1}
    text += "".join(f'\n[[parameters]]\nname = "{n}"\nstart = {x}\n' for n, x in starts.items())
    report = identified(write_study(tmp_path, text))
    for name, true in {"a": Phi[0, 0], "b": Phi[1, 0], "g": Gamma[0]}.items():
        value, deviation = numbers(report)[name]
        assert abs(value - true) < 4.0 * deviation < 0.2
    ship = {one["name"]: one["value"] for one in report["ship"]}
    assert ship["1/T1"] == pytest.approx(Z * W, rel=0.1)  # by the logarithm of the root
    rows = (tmp_path / "roll.csv").read_text().splitlines()
    (tmp_path / "roll.csv").write_text("\n".join(rows[:100] + rows[110:]) + "\n")
    with pytest.raises(ConfigError, match="matrices of one step need one interval"):
        identified(tmp_path / "study.toml")


@pytest.mark.slow
def test_a_gain_of_its_own_is_taken(tmp_path: Path) -> None:
    text = SYSTEM.replace('R1 = [[0, 0], [0, "q"]]', 'K = ["g1", "g2"]').replace('R2 = [["s"]]', "")
    rows = ROWS.replace('"q"', '"g1"').replace('"s"', '"g2"')
    report = identified(write_study(tmp_path, text + rows), "--noise", "innovations")
    assert_found(report)
    gain = numbers(report)["g1"]
    assert 0.0 < gain[0] < 0.3  # the settled filter's is 0.05
    assert gain[1] < 0.1


@pytest.mark.long
def test_two_inputs_and_none(tmp_path: Path) -> None:
    text = SYSTEM.replace('["fin"]', '["fin", "sea"]').replace('["k*w**2"]', '["k*w**2", 0]')
    path = write_study(tmp_path, text.replace("[[0], ", "[[0, 0], ") + ROWS)
    lines = (tmp_path / "roll.csv").read_text().splitlines()
    more = [f"{line},{i % 7 if i else 'sea'}" for i, line in enumerate(lines)]
    (tmp_path / "roll.csv").write_text("\n".join(more) + "\n")
    report = identified(path)
    assert_found(report)
    assert report["inputs"] == ["fin", "sea"]
    free = [",".join(line.split(",")[::2]) for line in lines]
    (tmp_path / "roll.csv").write_text("\n".join(free) + "\n")
    text = SYSTEM.replace('inputs = ["fin"]\n', "").replace('B = [[0], ["k*w**2"]]\n', "")
    rows = ROWS.replace('name = "k"\nstart = 1.0', 'name = "k"\nstart = 1.0\nfree = false')
    path.with_name("system.toml").write_text(text + rows)
    report = identified(path)
    assert report["inputs"] == []
    assert "k" not in numbers(report)


@pytest.mark.slow
def test_its_page_plot_series_and_check(tmp_path: Path) -> None:
    study = write_study(tmp_path)
    other = write_record(tmp_path / "other.csv", 2, (-3.0, 1.0))
    found = type_command(
        identify,
        *(study, "--check", other, "--csv", tmp_path / "x.csv"),
        *("--html", tmp_path / "x.html", "--matrices"),
    )
    for part in ("model own", "fin to roll", "The system is stable", "% variance", "Phi"):
        assert part in found.stdout
    assert max(map(len, found.stdout.splitlines())) <= 79
    heads = (tmp_path / "x.csv").read_text().splitlines()[0]
    assert heads.startswith("t_s,fin,roll_measured,roll_model")
    assert "roll by a step of 1 of fin" in (tmp_path / "x.html").read_text()
    check = identified(study, "--check", other)["check"]
    assert check["explained"][0] > 0.99


def test_what_an_expression_says_is_what_it_is() -> None:
    values = {"a": 0.7, "b": -2.0}
    for text in ("a**2 - b/3", "-(a + 2) * +b", "sqrt(a)*exp(b)", "cos(pi*a)", "abs(b) ** 1.5"):
        plain = compile(text.replace("abs", "np.abs").replace("pi", "np.pi"), "", "eval")
        functions = {"np": np, "sqrt": np.sqrt, "exp": np.exp, "cos": np.cos}
        expected = eval(plain, functions, values)  # noqa: S307
        assert parse_expression(text, ("a", "b"))(values) == pytest.approx(expected, rel=1e-14)
    stepped = parse_expression("abs(b)**3 * a", ("a", "b"))({"a": 0.7, "b": -2.0 + 1e-100j})
    assert stepped.imag == pytest.approx(-3 * 4 * 0.7 * 1e-100)


@pytest.mark.parametrize(
    "text",
    [
        "__import__('os').system('true')",
        "a.real",
        "a[0]",
        "(lambda: 1)()",
        "a if b else 1",
        "[1][0]",
        "a and b",
        "a < b",
        "f'{a}'",
        "sqrt(a, b)",
        "sqrt(x=a)",
        "eval('1')",
        "open(a)",
        "a @ b",
        "a // b",
        "True",
        "'a'",
        "1j",
        "a := 1",
        "*a",
        "",
        "a b",
        "9" * 400,
        "c",
        "-" * 60 + "a",
        "a+" * 90 + "a",
    ],
)
def test_an_expression_that_is_none_is_refused(text: str) -> None:
    with pytest.raises(ConfigError):
        parse_expression(text, ("a", "b"))


def test_a_power_without_end_is_no_number() -> None:
    with np.errstate(all="ignore"):
        assert parse_expression("9**9**9**9", ())({}) == np.inf


def test_expressions_are_never_run() -> None:
    source = (ROOT / "trainer/identify/model/system_files.py").read_text(encoding="utf-8")
    called = {
        node.func.id
        for node in ast.walk(ast.parse(source))
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name)
    }
    assert not called & {"eval", "exec", "compile", "__import__"}


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ('"-w**2"', '"-ww**2"', 'A: no parameter "ww"; nearest is w'),
        ('B = [[0], ["k*w**2"]]', "B = [[0]]", "B is 1 by 1, must be 2 by 1, states by inputs"),
        ('[["s"]]', '[["-s"]]', "R2 is no covariance at the start values"),
        ("C = [[1, 0]]", "C = [[1], [0, 1]]", "must be 1 to 20 rows of one length"),
        ('"-w**2"', '"log(-w)"', "A is not finite at the start values"),
        ('"-w**2"', "true", "A: true: must be a number or an expression"),
        ('["roll"]\nunits', '["rol"]\nunits', 'no column "rol" for rol; nearest is roll'),
        ('["fin"]', '["t2"]', 'no column "t2"'),
        ('name = "w"', 'name = "exp"', 'parameter "exp": is the name of a function'),
        ('name = "w"', 'name = "2w"', "must be a letter"),
        ("C = ", "E = ", "no such key"),
    ],
)
def test_a_system_that_is_wrong_says_where(tmp_path: Path, old: str, new: str, told: str) -> None:
    text = SYSTEM + ROWS
    assert old in text
    with pytest.raises(ConfigError) as caught:
        identified(write_study(tmp_path, text.replace(old, new)))
    assert told in "\n".join(caught.value.problems)


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("w**2), -2", "w**2), 1 / 0 * -2", "gives no A and C"),
        ("return A,", "return A, A,", "matrices(): must return A, B, C, D"),
        ("w, z, k, q, s, roll_0, rate_0 = theta", "w = theta.nothing", "AttributeError"),
        ("outputs =", "output =", "lacks outputs"),
        ("def matrices", "def matrices(", "SyntaxError"),
    ],
)
def test_a_program_that_is_wrong_says_where(tmp_path: Path, old: str, new: str, told: str) -> None:
    path = tmp_path / "system.py"
    assert old in PROGRAM
    path.write_text(PROGRAM.replace(old, new))
    with pytest.raises(ConfigError) as caught:
        load_system(path)
    assert told in "\n".join(caught.value.problems)


def test_a_study_of_its_own_kind_says_what_it_needs(tmp_path: Path) -> None:
    study = write_study(tmp_path)
    text = study.read_text()
    for old, new, told in (
        ('file = "system.toml"', "", "of kind own lacks file"),
        ('kind = "own"', 'kind = "own"\noutputs = ["heading"]', "has outputs of its own"),
        ('kind = "own"', 'kind = "1"', "goes with kind own"),
    ):
        study.write_text(text.replace(old, new))
        with pytest.raises(ConfigError) as caught:
            identified(study)
        assert told in "\n".join(caught.value.problems)


def test_an_input_must_be_known_and_a_reading_may_be_missing(tmp_path: Path) -> None:
    study = write_study(tmp_path)
    rows = (tmp_path / "roll.csv").read_text().splitlines()
    rows[7] = rows[7].rsplit(",", 1)[0] + ","
    (tmp_path / "roll.csv").write_text("\n".join(rows) + "\n")
    report = identified(study)
    assert report["samples"] == 299
    assert any("1 of 300 values are missing" in text for text in report["findings"])
    rows[9] = rows[9].replace(rows[9].split(",")[1], "", 1)
    (tmp_path / "roll.csv").write_text("\n".join(rows) + "\n")
    told = identified(study)["findings"]
    assert any("fin: has no reading for" in text for text in told)
