"""Every key of a vessel file changes a run or a message, or is listed as documentary."""

import copy
import math
import re
import tomllib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import pytest
from helpers.key_tables import documentary_keys
from helpers.lanes import sample_cases
from helpers.orders import read_order
from helpers.sessions import start_plan

from trainer.boat import stability
from trainer.boat.assemble import Method, fit_out
from trainer.boat.boat import Boat
from trainer.boat.depths import collapse_of, count_passed
from trainer.boat.helm import obey_order
from trainer.boat.world.scope import periscope_of
from trainer.config.boat.vessel import (
    DOCUMENTARY_TABLES,
    VesselFile,
    load_vessel,
    read_vessel,
)
from trainer.config.files import ConfigError, shipped_names, shipped_path
from trainer.io.orders.grammar import Order
from trainer.session.doors.warm_up import refuse_unstable
from trainer.session.past.options import RunOptions
from trainer.session.past.plan import plan_run
from trainer.session.stations.status import status_lines
from trainer.session.time.ledger import Ledger

Path_ = tuple[str | int, ...]  # of a value in tables and lists
RAISE = Order("scope", 0.0, "raise", "scope raise")
ORDERS = (
    *("ahead one third", "ahead two thirds", "ahead standard", "ahead full", "ahead flank"),
    *("astern one third", "astern two thirds", "astern full"),
    *("rpm 1", "periscope depth"),
)


def leaves(value: Any, path: Path_ = ()) -> Iterator[tuple[Path_, Any]]:
    """Yield every value of nested tables and lists, with its path."""
    if isinstance(value, Mapping):
        for key, item in value.items():
            yield from leaves(item, (*path, key))
    elif isinstance(value, list) and value:
        for i, item in enumerate(value):
            yield from leaves(item, (*path, i))
    else:
        yield path, value


def another(value: Any) -> Any:
    """Return another value than this one of a key: a number by 3 per cent, a word by a letter."""
    if isinstance(value, bool):
        return not value
    if isinstance(value, int | float):
        return 1.03 * value if value else 1e-4
    return [1.0] if isinstance(value, list) else value + "x"


def changed(table: Mapping[str, Any], path: Path_, value: Any) -> dict[str, Any]:
    """Return a copy of tables with one value changed."""
    found: Any = copy.deepcopy(table)
    place = found
    for key in path[:-1]:
        place = place[key]
    place[path[-1]] = value
    return found  # type: ignore[no-any-return]


def is_documentary(path: Path_) -> bool:
    """Return whether the list of documentary tables and keys has it."""
    words = [word for word in path if isinstance(word, str)]
    tables = documentary_keys()
    return words[0] in DOCUMENTARY_TABLES or any(
        words[i] in tables.get(".".join(words[:i]), ()) for i in range(len(words))
    )


def numbers(file: VesselFile) -> list[bytes]:
    """Return all records of the boat, by both compact sets."""
    return [
        record.tobytes()
        for equations in ("modified", "basic")
        for record in fit_out(file, Method(equations, "lagged", "exact", "adams2", 0.1))
    ]


def a_run(file: VesselFile, monkeypatch: pytest.MonkeyPatch) -> list[object]:
    """Return what a run of the file begins with, is checked at, says and obeys."""
    judged: list[object] = []

    def note_speeds(_boat: Boat, speeds: tuple[float, ...]) -> dict[float, object]:
        judged.append(speeds)
        return {}

    with monkeypatch.context() as patch:
        patch.setattr("trainer.session.past.plan.load_vessel", lambda _: file)
        patch.setattr(stability, "boat_responses", note_speeds)
        plan = plan_run(RunOptions())
        boat = start_plan(plan)
        refuse_unstable(boat)
    told = [*judged, plan.method, boat.records.state.tobytes()]
    told.append(status_lines(boat, Ledger(boat.method.step).summary()))
    for depth in (60.0, 100.0, 150.0, 250.0, 450.0):
        boat.state.z, boat.state.theta = depth, 0.0
        told += [collapse_of(boat), count_passed(file.hull.test_depth_m or math.inf, depth)]
    for line in ORDERS:
        order = read_order(line)
        told += [obey_order(boat, order), boat.state.ordered_u_c, boat.state.ordered_depth]
    if scope := periscope_of(boat):
        told += [obey_order(boat, RAISE), scope.head(scope.at(10))]
    return told


def reaction(table: Mapping[str, Any], name: str) -> VesselFile | str:
    """Return the boat, or why it is refused."""
    try:
        return read_vessel(table, "", Path(f"{name}.toml"))
    except ConfigError as wrong:
        return str(wrong)


@pytest.mark.long
@pytest.mark.parametrize("name", sample_cases(shipped_names("vessels"), "remus100"))
def test_every_key_of_a_shipped_boat_acts_or_is_documentary(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    table = tomllib.loads(shipped_path("vessels", name).read_text(encoding="utf-8"))
    file = reaction(table, name)
    assert isinstance(file, VesselFile)
    as_it_is, run = numbers(file), a_run(file, monkeypatch)
    without_effect, mislabelled = [], []

    def acts_as(path: Path_, value: Any) -> bool:
        other = reaction(changed(table, path, value), name)
        if isinstance(other, str):
            words = [word for word in path if isinstance(word, str)]
            named = re.search(rf"\b{re.escape(words[-1])}\b", other)
            return other.startswith(f"{name}.toml") and named is not None
        acts = other.remarks != file.remarks or numbers(other) != as_it_is
        return acts or a_run(other, monkeypatch) != run

    for path, value in leaves(table):
        acts = acts_as(path, another(value))
        if not acts and isinstance(value, float):  # what is cut off at a bound may be beyond it
            acts = acts_as(path, 0.5 * value)
        if not acts and not is_documentary(path):
            without_effect.append(path)
        if acts and is_documentary(path):
            mislabelled.append(path)

    assert without_effect == []
    assert mislabelled == []


@pytest.mark.parametrize(
    ("key", "value", "used"),
    [
        ("displaced_volume", 4400.0, "4400 m3: buoyancy/(rho g) is 4311 m3"),
        ("m_prime", 0.03, "0.03: mass/(rho/2 L^3) is 0.024923"),
        ("Ix_prime", 6.1e-5, "6.1e-05: Ix/(rho/2 L^5) is 5.9858e-05"),
        ("Iy_prime", 1.5e-3, "0.0015: Iy/(rho/2 L^5) is 0.0015737"),
        ("Iz_prime", 1.5e-3, "0.0015: Iz/(rho/2 L^5) is 0.0015645"),
    ],
)
def test_a_number_given_twice_and_differently_is_remarked(
    key: str, value: float, used: str
) -> None:
    boat = load_vessel("bb2")
    table = changed(tomllib.loads(boat.text), ("vessel", key), value)

    (remark,) = read_vessel(table, "", boat.path).remarks

    assert remark == f"bb2.toml: [vessel] {key} = {used}, which a run uses"


def test_a_number_given_twice_may_be_rounded() -> None:
    boat = load_vessel("bb2")
    table = changed(tomllib.loads(boat.text), ("vessel", "m_prime"), 0.025)

    assert read_vessel(table, "", boat.path).remarks == ()
