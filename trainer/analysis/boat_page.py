"""A boat in numbers for a page that flies it, and its recording.

A page has records, orders, channels, casualties and seas of one boat. The page
computes a recording anew with the same core, so that the page's file need not hold every state. It
holds what orders wrote before a tick, and the numbers that were recorded otherwise than the core
predicts: there are none in a whole recording of this version.
"""

import base64
from collections import deque
from pathlib import Path
from typing import Any, Final, NamedTuple

import click
import numpy as np

from trainer.boat import casualties
from trainer.boat.boat import Boat
from trainer.boat.casualties import AMOUNT_SHARES, GAUGE_UNITS, SURFACE_SIDES
from trainer.boat.crew_orders import CREW_AXES
from trainer.boat.export.header import places_of
from trainer.boat.export.wasm import numbers_of, shipped_module
from trainer.boat.helm import obey_order
from trainer.boat.sea_orders import fully_developed, standing_sea
from trainer.boat.world.world import WORLD_PARTS
from trainer.config.casualties import Casualty
from trainer.config.files import ConfigError
from trainer.config.sea import peak_frequency, significant_height, step_problem
from trainer.core.ballast.tanks import BANKS, COMPARTMENTS, TANKS
from trainer.core.casualties import KINDS
from trainer.core.kernel import Numbers
from trainer.core.sea.sea import HEIGHT, OMEGA
from trainer.core.state import MAX_CASUALTIES, SCRATCH, VALVES
from trainer.core.surfaces import SURFACES
from trainer.io.atomic_write import write_whole
from trainer.io.lines import plain
from trainer.io.orders.quantities import NUMBER_KINDS
from trainer.io.orders.table import BOAT_ORDERS, FORMS, NAME_PLACES, SIDE_SIGNS, WORD_SETS
from trainer.io.recording.recording import Branch, RecordedOrder, Recording
from trainer.session.header import differences, layout_of, open_whole_recording, plan_of
from trainer.session.layout import read_state
from trainer.session.plan import Plan
from trainer.session.run_faces import order_of
from trainer.session.stations.briefing import ranges
from trainer.session.stations.channels import CHANNELS
from trainer.session.stations.roles import ROLES
from trainer.session.stations.view import Fittings
from trainer.session.warm_up import warm_boat
from trainer.units import KNOT

SEA_STATES: Final = range(9)
StateWrites = list[tuple[int, float]]  # places of the state, and what is written there


def boat_for_page(boat: Boat, role: str) -> dict[str, Any]:
    """Return all that a station's page knows of a boat as it stands."""
    return {
        **numbers_of(boat),
        "title": boat.file.name,
        "gauges_at": places_of(SCRATCH)["reading"][0],
        "channels": {  # name, unit and decimals of every field
            name: [(field.name, field.unit, field.decimals) for field in channel.fields]
            for name, channel in CHANNELS.items()
        },
        "ranges": list(ranges(boat, ROLES[role])),
        "casualties": [
            casualty_numbers(boat, boat.casualties[name], degree)
            for name, degree, _ in casualties.available_casualties(boat)
        ],
        "calms": developed_seas(boat),
        "ramp_s": boat.sea.sea.ramp_s,
        "grammar": grammar(),
        **fittings(boat),
    }


def fittings(boat: Boat) -> dict[str, Any]:
    """Return the scales by which the state is read."""
    scales = Fittings.of(boat)
    bells = boat.file.propulsion.bells_kn
    return {
        **scales._asdict(),
        "toward": boat.toward,
        "rps": boat.file.propulsion.rps_per_mps,
        "bells": [("stop", 0.0), *((name, speed * KNOT) for name, speed in bells.items())],
        "tanks": TANKS,
        "compartments": COMPARTMENTS,
        "banks": BANKS,
        "valves": VALVES,
        "compressor": bool(boat.vessel.compressor_rate),
        "kinds": KINDS,
        "slots": MAX_CASUALTIES,
        "axes": CREW_AXES,
        "sides": SURFACE_SIDES,
        "gauge_units": GAUGE_UNITS,
        "shares": AMOUNT_SHARES,
        "knot": KNOT,
    }


def casualty_numbers(boat: Boat, casualty: Casualty, degree: str) -> dict[str, Any]:
    """Return the numbers of a casualty. Key ``limit`` is a surface's angle hard over."""
    limits = [
        boat.toward[surface] * float(boat.vessel.limit[place])
        for place, surface in enumerate(SURFACES)
        if casualty.kind == f"{surface}-hard-over"
    ]
    measure = casualty.measure
    amount = casualty.severity * casualty.full * (limits or [1.0])[0]
    usual = casualties.degree_of(boat, casualty)
    return {
        "name": casualty.name,
        "kind": casualty.kind,
        "code": casualty.code,
        "severity": casualty.severity,
        "ramp": casualty.ramp_s,
        "clear": casualty.clear_ramp_s,
        "says": casualty.description,
        "full": casualty.full,
        "limit": limits[0] if limits else None,
        "low": measure.limits.low,
        "high": min(measure.limits.high, 1e300),
        "sudden": measure.sudden,
        "degree": degree,
        "usual": usual.fields if usual else "",
        "told": "" if measure.sudden else casualties.describe_amount(boat, casualty.kind, amount),
    }


def developed_seas(boat: Boat) -> dict[str, tuple[float, float]]:
    """Return height [m] and peak [rad/s] of each sea state that the boat's step allows."""
    g = float(boat.vessel.g)
    seas = {}
    for state in SEA_STATES:
        sea = fully_developed(boat.sea.sea, "state", float(state))
        height, peak = significant_height(sea, g), peak_frequency(sea, g)
        wanted = standing_sea(boat)
        wanted[HEIGHT], wanted[OMEGA] = height, peak
        if not step_problem(wanted, boat.method.step):
            seas[str(state)] = (float(height), float(peak))
    return seas


def grammar() -> dict[str, Any]:
    """Return the table of orders, by which a page reads a line."""
    return {
        "forms": [
            {"pattern": f.pattern, "name": f.name, "value": f.value, "refusal": f.refusal}
            for f in FORMS
        ],
        "sets": WORD_SETS,
        "numbers": {
            name: {
                "says": number.says,
                "units": [
                    {"text": u.text, "names": u.names, "factor": u.factor} for u in number.units
                ],
                **{key: getattr(number, key) for key in ("prefix", "low", "high", "decimals")},
            }
            for name, number in NUMBER_KINDS.items()
        },
        "names": {name: place.says for name, place in NAME_PLACES.items()},
        "signs": SIDE_SIGNS,
    }


# What was recorded


def boat_of(path: Path) -> tuple[Boat, dict[str, Any]]:
    """Return the boat of a recording at its start, and the recording for a page.

    ConfigError where it is damaged, or not of this version.
    """
    with open_whole_recording(path) as recording, np.errstate(all="ignore"):
        header = recording.header()
        for each in differences(header)[:1]:
            raise ConfigError(f"{path.name}: {each}: in a page it would not be the same run")
        plan = plan_of(header)
        boat = Boat(plan.file, plan.method)
        warm_boat(boat)
        layout = layout_of(header)
        plan.start(boat)
        refuse_world(recording, plan, path.name)
        exercise = [("title", plan.title or plan.file.name)]  # as a session tells it
        exercise += [("line", line) for line in plan.briefing.splitlines()]
        exercise += [] if plan.duration is None else [("duration", f"{plan.duration:g}")]
        branches = recording.branches()
        facts = {
            "from": plain(path.name),
            "branches": [fly_branch(recording, each, boat, plan, layout) for each in branches],
            "orders": [
                (each.branch, each.tick, plain(each.text))
                for branch in branches
                for each in recording.orders(branch.id, branch.after)
                if each.accepted
            ],
            "events": [
                (e.branch, e.tick, plain(e.kind), plain(e.text)) for e in recording.first_events()
            ],
            "exercise": exercise,
        }
        plan.start(boat)
    return boat, facts


def refuse_world(recording: Recording, plan: Plan, name: str) -> None:
    """Raise ConfigError if a recording has a world, because a page has none."""
    around = [f"[{table}]" for table in (*plan.sea.world, *plan.world)]
    for branch in recording.branches():
        orders = recording.orders(branch.id, branch.after)
        around += [each.text for each in orders if each.text.partition(" ")[0] in WORLD_PARTS]
    if around:
        problem = f"has a world around the boat, {around[0]}, and a page has none"
        raise ConfigError(f"{name}: {problem}; look at it by trainer debrief")


def fly_branch(
    recording: Recording, branch: Branch, boat: Boat, plan: Plan, layout: tuple[str, ...]
) -> dict[str, Any]:
    """Return one branch for a page, flown from its beginning beside the recorded states."""
    standing = boat.records.state
    boat.restore(read_state(branch.state, layout, standing))
    begun = standing.tobytes()
    orders = deque(recording.orders(branch.id, branch.after))
    before: list[tuple[int, StateWrites]] = []
    after: list[tuple[int, StateWrites]] = []
    last = branch.tick
    for tick, state in recording.states(branch.id):
        if tick <= branch.tick:  # of before its beginning
            continue
        if written := apply_orders(orders, tick - 1, boat, plan):
            before.append((tick - 1, written))
        boat.tick()
        recorded = read_state(state, layout, standing)["whole"][0]
        if changed := state_changes(boat.state.whole, recorded):
            after.append((tick, changed))
            boat.state.whole[:] = recorded
        last = tick
    if written := apply_orders(orders, last, boat, plan):
        before.append((last, written))
    return {
        "number": branch.id,
        "parent": branch.parent or 0,
        "begun": branch.tick,
        "last": last,
        "why": plain(branch.why),
        "state": base64.b64encode(begun).decode("ascii"),
        "before": before,
        "after": after,
    }


def apply_orders(orders: deque[RecordedOrder], tick: int, boat: Boat, plan: Plan) -> StateWrites:
    """Give the boat the orders of a tick. Return the state's places and values that they wrote."""
    was = boat.state.whole.copy()
    while orders and orders[0].tick <= tick:
        order = order_of(orders.popleft(), plan.schedule)
        if order is not None and order.name in BOAT_ORDERS:
            obey_order(boat, order)
    return state_changes(was, boat.state.whole)


def state_changes(was: Numbers, now: Numbers) -> StateWrites:
    """Return the places where two states differ, and what the second has."""
    places = np.flatnonzero(was.view(np.int64) != np.ascontiguousarray(now).view(np.int64))
    return [(int(place), float(now[place])) for place in places]


# The page


class PageParts(NamedTuple):
    """The boat as a page knows it, the core, and the title of the page."""

    boat: dict[str, Any]
    core: bytes
    title: str


def page_of(boat: Boat | None, recording: Path | None, role: str) -> PageParts:
    """Return the parts of a page: of a boat, or of a recording."""
    facts = None
    if recording is not None:
        boat, facts = boat_of(recording)
    if boat is None:
        raise ValueError("a page has a boat or a recording")
    core = shipped_module(boat)
    numbers = boat_for_page(boat, role) | {"recording": facts}
    title = boat.file.name if facts is None else f"{boat.file.name}: {facts['from']}"
    return PageParts(numbers, core, title)


def write_page(path: Path, text: str, recording: Path | None) -> None:
    """Write the page whole and print its name; ConfigError where it cannot be written."""
    if recording is not None and path.exists() and path.samefile(recording):
        raise ConfigError(f"{path} is the recording itself: give another name")
    try:
        write_whole(path, text)
    except OSError as error:
        raise ConfigError(f"{path} cannot be written: {error.strerror}") from None
    click.echo(f"{path}  {path.stat().st_size / 1000:.0f} kB")
