"""The propeller's slip in the compact set: the terms of (1)-(6) by eta - 1, without a division."""

from dataclasses import replace

import numpy as np
import pytest

from trainer.boat.assemble import Method, Records, fit_out
from trainer.config.boat.vessel import VesselFile, load_vessel
from trainer.core import compact, full
from trainer.core.kinematics import EXACT_TRIGONOMETRY, attitude_of
from trainer.core.terms import EXTRA_TERMS, LENGTH_POWERS, SLIP_TERMS, TERM_TABLE

STATE_VALUES = {
    "u": 3.1,
    "v": -0.7,
    "w": 0.4,
    "p": 0.011,
    "q": -0.013,
    "r": 0.021,
    "delta_r": 0.3,
    "delta_s": -0.1,
    "delta_b": 0.05,
    "u_c": 5.9,
}


def slipping(file: VesselFile, value: float) -> VesselFile:
    """Return the boat with every term of slip that the compact set has room for at ``value``."""
    coefficients = {**file.coefficients, **dict.fromkeys(SLIP_TERMS, value)}
    kept = replace(file.compact, extra_terms=EXTRA_TERMS)
    factors: dict[str, dict[str, float]] = {name: {} for name in file.compensation}
    return replace(file, coefficients=coefficients, compact=kept, compensation=factors)


def records_of(file: VesselFile, equations: str, whole: float) -> Records:
    """Return the records of a boat in the state above, with eta by u or by U."""
    records = fit_out(file, Method(equations, "exact", "exact", "adams2", 0.5))
    for record in (records.vessel, records.compact):
        record["eta_whole"] = whole
    for name, number in STATE_VALUES.items():
        records.state[name] = number
    return records


@pytest.mark.parametrize("whole", [0.0, 1.0])
def test_slip_is_that_of_the_full_set(whole: float) -> None:
    file = load_vessel("bb2")
    forces = []
    for value in (0.0, 0.004):
        records = records_of(slipping(file, value), "full", whole)
        out = np.zeros(6)
        full.forces(
            records.vessel, attitude_of(EXACT_TRIGONOMETRY, records.state), records.state, out
        )
        forces.append(out)
    records = records_of(slipping(file, 0.004), "modified", whole)
    slip = np.zeros(6)
    compact.slip_forces(records.compact, records.state, slip)
    c = records.compact[0]
    assert c.slipping == 1.0
    slip[3:] /= [c.T4, c.T5, c.T6]
    assert slip == pytest.approx(forces[1] - forces[0], rel=1e-6)
    assert abs(slip).min() > 1.0


def test_terms_of_slip_are_all_that_need_no_division() -> None:
    """What is left of u^2 (eta - 1) or u x (eta - 1) is u_c - u times the rest."""
    of_slip = [term for term in TERM_TABLE if "(eta-1)" in term.multiplies]
    assert {t.key for t in of_slip if t.multiplies.startswith("u")} == set(SLIP_TERMS)
    assert set(SLIP_TERMS) < set(EXTRA_TERMS) < set(LENGTH_POWERS)


def test_a_boat_without_slip_is_not_touched() -> None:
    for name, flag in (("bb2", 1.0), ("sdv-mk9", 0.0), ("remus100", 1.0)):
        file = load_vessel(name)
        records = fit_out(file, Method("modified", "lagged", "exact", "adams2", 0.5))
        assert records.compact[0].slipping == flag, name
