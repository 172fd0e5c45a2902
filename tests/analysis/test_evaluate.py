"""Evaluation against vectors made elsewhere, between equation sets, and what bad lines are told."""

import json
from collections.abc import Iterator
from dataclasses import replace

import pytest
from helpers.places import DATA
from hypothesis import given, settings
from hypothesis import strategies as st

from trainer.analysis.programs.evaluate import (
    NECESSARY_KEYS,
    evaluate_lines,
)
from trainer.config.boat.vessel import VesselFile, load_vessel
from trainer.config.files import ConfigError
from trainer.core.state import RATES
from trainer.core.terms import COMPACT_TERMS

VECTORS = DATA / "vectors"
CASES = sorted(path.stem for path in VECTORS.glob("*.args"))
STATE = dict.fromkeys(NECESSARY_KEYS, 0.0) | {"u": 5.0, "u_c": 5.0}


def line(**changes: object) -> str:
    return json.dumps(STATE | changes)


def boat(name: str = "full-refsub") -> VesselFile:
    return load_vessel(str(VECTORS / f"{name}.vessel.toml"))


def found(file: VesselFile, equations: str, rates: str, *lines: str) -> list[dict[str, float]]:
    return [json.loads(text) for text in evaluate_lines(file, equations, rates, "exact", lines)]


def options(case: str) -> tuple[str, str]:
    words = (VECTORS / f"{case}.args").read_text().split()
    given = dict(zip(words[::2], words[1::2], strict=True))
    return given["--equations"], given.get("--trig", "exact")


@pytest.mark.parametrize("rates", ["exact", "lagged"])
@pytest.mark.parametrize("case", CASES)
def test_vectors_of_an_independent_program_are_met(case: str, rates: str) -> None:
    equations, trig = options(case)
    lines = (VECTORS / f"{case}.states.jsonl").read_text().splitlines()
    expected = (VECTORS / f"{case}.{rates}.expected.jsonl").read_text().splitlines()

    answers = list(evaluate_lines(boat(case), equations, rates, trig, lines))

    assert len(answers) == len(expected) > 0
    for answer, wanted in zip(answers, expected, strict=True):
        numbers = json.loads(wanted)
        assert json.loads(answer).keys() == numbers.keys()
        for key, value in json.loads(answer).items():
            assert abs(value - numbers[key]) <= 1e-9 * max(abs(numbers[key]), 1e-6), key


def test_answers_have_the_twelve_rates_in_order_and_lose_no_digit() -> None:
    (answer,) = evaluate_lines(boat(), "full", "exact", "exact", [line(v=0.1, r=0.01, theta=0.3)])

    assert list(json.loads(answer)) == RATES
    (answer,) = evaluate_lines(boat(), "full", "exact", "exact", [line(u=0.1 + 0.2, psi=0.0)])
    assert '"xdot": 0.30000000000000004' in answer


# Iy = Iz and nothing but what the compact set keeps: there it is the full set.
KEEPING = replace(
    boat(),
    coefficients={
        key: value if key in COMPACT_TERMS else 0.0 for key, value in boat().coefficients.items()
    },
    hull=replace(boat().hull, cg=(0.4, 0.0, 0.3)),
)


@st.composite
def states(draw: st.DrawFn) -> dict[str, float]:
    sizes = {"u": (0.5, 12.0), "u_c": (-5.0, 12.0), "psi": (-7.0, 7.0)}
    sizes |= dict.fromkeys(("v", "w"), (-2.0, 2.0)) | dict.fromkeys("pqr", (-0.1, 0.1))
    sizes |= dict.fromkeys(("phi", "theta", "delta_r", "delta_s", "delta_b"), (-0.6, 0.6))
    sizes |= {f"last_{name}": (-0.1, 0.1) for name in RATES[:6]}
    return {name: draw(st.floats(*limits)) for name, limits in sizes.items()}


@pytest.mark.parametrize("rates", ["exact", "lagged"])
@given(state=states())
@settings(max_examples=50)
def test_compact_is_full_where_the_dropped_coefficients_are_zero(
    rates: str, state: dict[str, float]
) -> None:
    (full,) = found(KEEPING, "full", rates, json.dumps(state))
    (compact,) = found(KEEPING, "modified", rates, json.dumps(state))

    # rounding is relative to the largest of the six, whose terms they share
    largest = max(abs(full[name]) for name in RATES[:6])
    for name in RATES:
        assert compact[name] == pytest.approx(full[name], rel=1e-12, abs=1e-12 * largest), name


@pytest.mark.slow
@pytest.mark.parametrize("rates", ["exact", "lagged"])
@given(state=states())
@settings(max_examples=50)
def test_longitudinal_is_full_for_motion_in_the_vertical_plane(
    rates: str, state: dict[str, float]
) -> None:
    lateral = ("v", "p", "r", "phi", "delta_r", "last_vdot", "last_pdot", "last_rdot")
    vertical = json.dumps(state | dict.fromkeys(lateral, 0.0))

    (full,) = found(boat(), "full", rates, vertical)
    (longitudinal,) = found(boat(), "longitudinal", rates, vertical)

    assert longitudinal == pytest.approx(full, rel=1e-12, abs=1e-15)


def test_longitudinal_has_no_lateral_acceleration() -> None:
    (rates,) = found(boat(), "longitudinal", "exact", line(v=1.0, r=0.1, delta_r=0.3))

    assert (rates["vdot"], rates["pdot"], rates["rdot"]) == (0.0, 0.0, 0.0)


def test_a_heavier_boat_sinks() -> None:
    heavy = boat().hull.weight * 1.01

    even, sinking = found(boat(), "full", "exact", line(), line(weight=heavy))

    # 1 % of the weight over mass plus added mass, and over the 1 % more mass
    hull, c = boat().hull, boat().coefficients
    added = -0.5 * boat().fluid.rho * hull.length**3 * c["Z_wdot"]
    expected = 0.01 * hull.weight / (1.01 * hull.mass + added)
    assert sinking["wdot"] - even["wdot"] == pytest.approx(expected, rel=1e-3)


def test_a_forward_centre_of_gravity_puts_the_bow_down() -> None:
    level, forward = found(boat(), "full", "exact", line(), line(x_g=0.5))

    assert forward["qdot"] < level["qdot"] - 1e-4


def test_lines_do_not_remember_each_other() -> None:
    lines = [line(last_qdot=0.1, weight=6e7, x_g=1.0, x=50.0), line()]

    assert found(boat(), "full", "lagged", *lines)[1] == found(boat(), "full", "lagged", line())[0]


def test_blank_lines_are_skipped_but_counted() -> None:
    assert len(found(boat(), "full", "exact", "", line(), "  \n", line())) == 2
    with pytest.raises(ConfigError, match=r"^line 3: "):
        found(boat(), "full", "exact", line(), "\n", "x")


def test_answers_come_before_a_later_line_is_read() -> None:
    def lines() -> Iterator[str]:
        yield line()
        raise AssertionError

    assert next(evaluate_lines(boat(), "full", "exact", "exact", lines()))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (line(thteta=0.1), 'line 1: no such key "thteta"; nearest is theta'),
        ('{"u": 1}', "line 1: lacks v\nline 1: lacks w"),
        (line(q="fast"), 'line 1: q = "fast": must be a number'),
        (line(q=True), "line 1: q = true: must be a number"),
        (line(q=None), "line 1: q = null: must be a number"),
        (line(q={"a": 1}), "line 1: q = "),
        (line(q=float("nan")), "line 1: NaN is not a number"),
        (line(q=float("-inf")), "line 1: -Infinity is not a number"),
        (line().replace("5.0", "1e999"), "line 1: u = inf: is too large"),
        (line(u=10**400), "line 1: u = 1000"),
        ('{"u": ' + "9" * 5000 + "}", "line 1: is not JSON"),
        (line(psi=1e6), r"line 1: psi = 1000000.0: must be within +-100000 rad"),
        (line(weight=0.0), "line 1: weight = 0.0: must be above 0"),
        (line()[:-1] + ', "u": 2}', "line 1: u is given twice"),
        ("1 2 3", "line 1: is not JSON"),
        ("[" * 100_000, "line 1: is not JSON (nested too deeply"),
        ("[1, 2]", "line 1: must be one JSON object"),
        ("3", "line 1: must be one JSON object"),
        ("caf\u00e9 \u202e", "line 1: is not JSON (Expecting value): 'caf\\xe9"),
        (line(u=1e200), "line 1: udot is not finite"),
    ],
)
def test_a_bad_line_is_told_number_key_and_reason(text: str, message: str) -> None:
    with pytest.raises(ConfigError) as caught:
        found(boat(), "full", "exact", text)

    assert message in str(caught.value)
    assert str(caught.value).isascii()
