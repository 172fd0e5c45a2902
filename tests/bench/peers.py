"""The cost of one step in programs made for such work, by one Python call.

JSBSim flies its own c172p, which is another vehicle and another step: what is compared is what a
user pays who drives either from Python. scipy integrates this boat, its rates called as it likes.
"""

import importlib
import importlib.metadata
import itertools
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from bench.batches import BatchCost, Voyage, time_batches
from trainer.analysis.bench.ticks import STANDARD_METHOD, ready_boat
from trainer.boat.boat import Boat
from trainer.config.boat.vessel import VesselFile
from trainer.core.kernel import Numbers
from trainer.core.rates import rates

AIRCRAFT: Final = "c172p"
TOLERANCE: Final = 1e-3  # relative, of scipy: as the report's variable step has it


@dataclass(frozen=True)
class Peer:
    """One program beside ours, in the same run."""

    name: str
    version: str
    step_s: float  # of its own; the median where it chooses
    step: BatchCost
    times_ours: float  # least over least, by step
    times_ours_by_time: float  # the same by the time [s] that a step takes the vehicle on


@dataclass(frozen=True)
class Peers:
    """A tick called from Python, beside the programs that are installed."""

    vessel: str
    step_s: float
    tick: BatchCost
    peers: tuple[Peer, ...]
    missing: tuple[str, ...]


def library(name: str) -> Any:
    """Return an optional library, None where it is not installed."""
    try:
        return importlib.import_module(name)
    except ImportError:
        return None


def jsbsim_step(jsbsim: Any) -> tuple[Callable[[], object], float]:
    """Return what takes a step of JSBSim's aircraft in flight, and its length [s]."""
    jsbsim.FGJSBBase().debug_lvl = 0
    flight = jsbsim.FGFDMExec(None)
    flight.set_debug_level(0)
    flight.load_model(AIRCRAFT)
    flight["ic/h-sl-ft"], flight["ic/vc-kts"] = 5000.0, 90.0
    flight["propulsion/set-running"] = -1
    flight.run_ic()
    return flight.run, float(flight.get_delta_t())


def scipy_steps(integrate: Any, boat: Boat) -> Iterator[float]:
    """Yield the length [s] of each step of scipy's RK45 along the boat's straight flight."""
    state, records = boat.records.state, tuple(boat.records)
    motion, now = state["motion"][0], state["rates"][0]
    start = motion.copy()

    def slopes(_time: float, y: Numbers) -> Numbers:
        motion[:] = y
        rates(*records)
        return np.array(now)

    while True:
        flight = integrate.RK45(slopes, 0.0, start, 60.0, rtol=TOLERANCE, max_step=2.0)
        while flight.status == "running":
            flight.step()
            yield flight.step_size


def repeat(step: Callable[[], object]) -> Callable[[int], None]:
    """Return what takes so many steps."""

    def run(count: int) -> None:
        for _ in range(count):
            step()

    return run


def time_peers(file: VesselFile) -> Peers:
    """Return what a step costs here and in what is installed of the others."""
    boat = ready_boat(file, STANDARD_METHOD, file.run.step_s)
    works: list[Callable[[int], object]] = [Voyage.of(boat, repeat(boat.tick))]
    names, lengths = ["trainer"], [file.run.step_s]
    missing = []
    if jsbsim := library("jsbsim"):
        step, length = jsbsim_step(jsbsim)
        names, lengths = [*names, "jsbsim"], [*lengths, length]
        works.append(repeat(step))
    else:
        missing.append("jsbsim")
    if integrate := library("scipy.integrate"):
        flight = scipy_steps(
            integrate, ready_boat(file, ("full", "exact", "adams2"), file.run.step_s)
        )
        length = float(np.median(list(itertools.islice(flight, 100))))
        names, lengths = [*names, "scipy"], [*lengths, length]
        works.append(repeat(flight.__next__))
    else:
        missing.append("scipy")
    ours, *costs = time_batches(works)
    peers = tuple(
        Peer(
            name=name,
            version=importlib.metadata.version(name),
            step_s=length,
            step=cost,
            times_ours=cost.least_ns / ours.least_ns,
            times_ours_by_time=cost.least_ns / length / (ours.least_ns / file.run.step_s),
        )
        for name, length, cost in zip(names[1:], lengths[1:], costs, strict=True)
    )
    return Peers(file.name, file.run.step_s, ours, peers, tuple(missing))


def lines(figures: Peers) -> list[str]:
    """Return the figures as lines of a page."""
    return [
        "",
        "BESIDE OTHERS (a step by one call from Python, hot; JSBSim's c172p, RK45 of this boat)",
        f"  {'':<22}{'step [s]':>10}{'median [us]':>13}{'least [us]':>12}{'times':>8}",
        row("trainer", figures.step_s, figures.tick),
        *(
            f"{row(f'{peer.name} {peer.version}', peer.step_s, peer.step)}{peer.times_ours:>8.1f}"
            for peer in figures.peers
        ),
        *(f"  {name}: not installed" for name in figures.missing),
    ]


def row(name: str, step: float, cost: BatchCost) -> str:
    """Return a row of the page."""
    return f"  {name:<22}{step:>10.4f}{cost.median_ns / 1e3:>13.2f}{cost.least_ns / 1e3:>12.2f}"
