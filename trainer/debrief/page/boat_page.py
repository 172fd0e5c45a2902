"""A boat in numbers for a page that flies it, and its recording.

``trainer boat export-page`` calls it. A page has records, orders, channels, casualties and seas of
one boat. The page computes a recording anew with the same core, so that the page's file need not
hold every state. It holds what orders wrote before a tick, and the numbers that were recorded
otherwise than the core predicts: there are none in a whole recording of this version.
"""

import base64
import math
from collections import deque
from dataclasses import replace
from pathlib import Path
from typing import Any, Final, NamedTuple

import click
import numpy as np

from trainer.boat import casualties
from trainer.boat.boat import Boat
from trainer.boat.crew_orders import CREW_AXES
from trainer.boat.depths import (
    GUARD_AHEAD_S,
    GUARD_MARGIN_M,
    LEVEL_PITCH,
    RELEASE_MARGIN_M,
)
from trainer.boat.due_orders import fly_ticks, obey_all, orders_due
from trainer.boat.export.wasm import numbers_of, shipped_module
from trainer.boat.helm import LEVER_SHARES
from trainer.boat.sea_orders import fully_developed, standing_sea
from trainer.boat.world.world import WORLD_PARTS
from trainer.config.boat.casualties import GAUGE_UNITS, SEVERITY_MEASURES, Casualty, clause_of
from trainer.config.exercise.exercise import ExerciseLimits
from trainer.config.files import ConfigError, write_over
from trainer.config.world.sea import peak_frequency, significant_height, step_problem
from trainer.core.ballast.tanks import COMPARTMENTS, TANKS
from trainer.core.casualties import CASUALTY_TABLE, KINDS, CasualtyKind
from trainer.core.kernel import Numbers
from trainer.core.plant.parts import CONSUMER_NAMES, MODE_NAMES
from trainer.core.sea.sea import HEIGHT, OMEGA
from trainer.core.state import MAX_CASUALTIES, VALVES
from trainer.core.surfaces import SURFACES
from trainer.io.lines import plain
from trainer.io.orders.quantities import NUMBER_KINDS
from trainer.io.orders.table import FORMS, NAME_SLOTS, SIDE_SIGNS, WORD_SETS
from trainer.io.recording.recording import Branch, RecordedOrder, Recording
from trainer.io.sides import SURFACE_SIDES
from trainer.session.doors.warm_up import warm_boat
from trainer.session.exercise.reference_flight import follow_run
from trainer.session.past.header import differences, layout_of, open_whole_recording, plan_of
from trainer.session.past.journal import order_of
from trainer.session.past.layout import read_state
from trainer.session.past.options import RunOptions
from trainer.session.past.plan import Plan, plan_run
from trainer.session.people.briefing import ranges
from trainer.session.stations.channels import CHANNELS
from trainer.session.stations.roles import AID_NAMES, ROLES
from trainer.units import KNOT

SEA_STATES: Final = range(9)
WHOLE_DESK: Final = "instructor"  # the station whose page has everything
EASY_ANGLE: Final = 15.0  # [deg] of stern planes: full dive is soon too deep for a first hand
VISITORS_EXERCISE: Final = "visitor-dive"
WAY_S: Final = 120.0  # [s] of the way shown: as long as a try (js/tab/task.js)
StateWrites = list[tuple[int, float]]  # offsets of the state, and what is written there


# Limits that such a page can judge, because the boat alone tells them: the column of channel
# motion, and the sign by which the worst value is the greatest, 0 for both sides.
TASK_LIMITS: Final = {
    "depth_m_max": ("depth", 1),
    "depth_m_min": ("depth", -1),
    "pitch_deg_max": ("pitch", 0),
    "heel_deg_max": ("heel", 0),
    "speed_kn_max": ("speed", 1),
    "speed_kn_min": ("speed", -1),
}


def boat_for_page(boat: Boat, role: str) -> dict[str, Any]:
    """Return all that a station's page knows of a boat as it stands."""
    return {
        **numbers_of(boat),
        "title": boat.file.name,
        "channels": {  # name, unit and decimals of every field, and the number that it shows
            name: [(each.name, each.unit, each.decimals, each.source) for each in channel.fields]
            for name, channel in CHANNELS.items()
            if name not in AID_NAMES and channel.lack(boat) is None  # which a page has not
        },
        "ranges": list(ranges(boat, ROLES[role])),
        "casualties": [
            casualty_numbers(boat, boat.casualties[name], degree)
            for name, degree, _ in casualties.available_casualties(boat)
            if not boat.casualties[name].parts  # a page alone breaks one thing at a time
        ],
        "calms": developed_seas(boat),
        "ramp_s": boat.sea.sea.ramp_s,
        "grammar": grammar(),
        **fittings(boat),
    }


def fittings(boat: Boat) -> dict[str, Any]:
    """Return the scales by which the state is read."""
    bells = boat.file.propulsion.bells_kn
    return {
        "toward": boat.toward,
        "trims": bool(boat.vessel.capacity[TANKS.index("trim_forward")]),
        "rps": boat.file.propulsion.rps_per_mps,
        "bells": [("stop", 0.0), *((name, speed * KNOT) for name, speed in bells.items())],
        "compartments": COMPARTMENTS,
        "valves": VALVES,
        "intake": float(boat.vessel.intake_depth) if boat.vessel.compressor_rate else None,
        "kinds": KINDS,
        "slots": MAX_CASUALTIES,
        "axes": CREW_AXES,
        "modes": MODE_NAMES,
        "consumers": CONSUMER_NAMES,
        "counts": {kind.name: amount_count(boat, kind) for kind in CASUALTY_TABLE},
    }


def amount_count(boat: Boat, kind: CasualtyKind) -> dict[str, Any]:
    """Return how the amount of a kind of casualty is counted, with unit and size."""
    measure = SEVERITY_MEASURES[kind.name]
    unit, size = GAUGE_UNITS.get(kind.equipment, (measure.share, boat.toward.get(kind.equipment)))
    how, before = measure.count.value, ""
    if measure.count in casualties.AMOUNT_UNITS:
        unit, size, before = casualties.AMOUNT_UNITS[measure.count]
        how = "plain"
    return {
        "how": how,
        "before": before,
        "unit": unit,
        "size": size,
        "sides": SURFACE_SIDES.get(kind.equipment),
    }


def casualty_numbers(boat: Boat, casualty: Casualty, degree: str) -> dict[str, Any]:
    """Return the numbers of a casualty. Key ``limit`` is a surface's angle hard over, else 1."""
    limit = casualties.full_angle(boat, casualty.kind)
    measure = casualty.measure
    amount = casualty.severity * casualty.full * limit
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
        "limit": limit,
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
        "names": {name: slot.says for name, slot in NAME_SLOTS.items()},
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
        branches = recording.branches()
        accepted = [
            (branch.id, each)
            for branch in branches
            for each in recording.orders(branch.id, branch.after)
            if each.accepted
        ]
        facts: dict[str, Any] = {
            "from": plain(path.name),
            "branches": [fly_branch(recording, each, boat, plan, layout) for each in branches],
            "orders": [(each.branch, each.tick, plain(each.text)) for _, each in accepted],
            "events": [
                (e.branch, e.tick, plain(e.kind), plain(e.text)) for e in recording.first_events()
            ],
            "exercise": exercise_facts(plan),
            "causes": [
                (number, each.tick, happening)
                for number, each in accepted
                if (happening := happening_of(each, boat, plan))
            ],
            "scheduled": [
                (number, each.tick, plain(each.text))
                for number, each in accepted
                if each.entry is not None and breaks_or_clears(each, plan)
            ],
            "kept": task_of(plan.limits),
        }
        if plan.crew.rules:
            moment, number = task_moment(facts, branches), len(branches) + 1
            facts["way"] = way_from(recording, plan, moment, number)
            facts["exercise"].append(("way", "yes"))
        plan.start(boat)
    return boat, facts


def task_moment(facts: dict[str, Any], branches: list[Branch]) -> tuple[Branch, int]:
    """Return the branch and tick after what broke first, to be flown from."""
    end = facts["branches"][-1]["last"]
    by_number = {each.id: each for each in branches}
    path: dict[int, int] = {}  # the last tick of each branch on the way to the present
    here: Branch | None = branches[-1]
    until = end
    while here is not None:
        path[here.id] = until
        until, here = here.tick, by_number.get(here.parent or 0)
    caused = (tick for number, tick, _ in facts["causes"] if tick <= path.get(number, -1))
    begun = min(next(caused, -1) + 1, end)
    return next(by_number[each] for each in path if by_number[each].tick <= begun), begun


def way_from(
    recording: Recording, plan: Plan, moment: tuple[Branch, int], number: int
) -> dict[str, Any]:
    """Return the reference crew's run from a moment as a branch, and its orders.

    The crew has followed the run up to there, mute, as in a session.
    """
    parent, begun = moment
    orders = [each for each in recording.orders(parent.id) if each.tick < begun]
    mute = follow_run(plan, orders, (), begun)
    boat, crew = mute.crew.boat, mute.speak()
    start, last = boat.records.state.tobytes(), begun + round(WAY_S / plan.method.step)
    was = boat.state.whole.copy()
    before: list[tuple[int, StateWrites]] = []
    spoken: list[tuple[int, str]] = []

    def look(_: object) -> None:
        spoken.extend((boat.ticks, plain(each.text)) for each in crew.look())
        if written := state_changes(was, boat.state.whole):
            before.append((boat.ticks, written))

    for _ in fly_ticks(boat, last, orders_due(boat, plan.schedule), look):
        was[:] = boat.state.whole
    state = base64.b64encode(start).decode("ascii")
    branch = {"number": number, "parent": parent.id, "begun": begun, "last": last, "after": []}
    branch |= {"why": "the way, shown by the reference crew", "state": state, "before": before}
    return {"branch": branch, "orders": spoken}


def exercise_facts(plan: Plan) -> list[tuple[str, str]]:
    """Return keys of an exercise and their values, as a session tells them."""
    limits = [(name, value) for name, value in vars(plan.limits).items() if value is not None]
    facts = [("title", plan.title or plan.file.name)]
    facts += [("line", line) for line in plan.briefing.splitlines()]
    facts += [("limits", ",".join(f"{name}:{value:g}" for name, value in limits))] if limits else []
    facts += [("visitors", "yes")] if plan.visitors else []
    return facts + ([] if plan.duration is None else [("duration", f"{plan.duration:g}")])


def happening_of(recorded: RecordedOrder, boat: Boat, plan: Plan) -> str:
    """Return what an order breaks, "" if it breaks nothing.

    It is the clause of the casualty's description, and after a bar the amount that was ordered.
    """
    order = order_of(recorded, plan.schedule)
    if order is None or order.name != "casualty" or order.subject not in boat.casualties:
        return ""
    casualty = boat.casualties[order.subject]
    if casualty.parts:
        return plain(f"{clause_of(casualty.description)}|")
    severity = order.numbers[0] if order.numbers else casualty.severity
    numbers = casualty_numbers(boat, replace(casualty, severity=severity), "")
    return plain(f"{clause_of(casualty.description)}|{numbers['told']}")


def breaks_or_clears(recorded: RecordedOrder, plan: Plan) -> bool:
    """Return whether an order begins or ends a casualty."""
    order = order_of(recorded, plan.schedule)
    return order is not None and order.name in ("casualty", "clear")


def task_of(limits: ExerciseLimits) -> list[tuple[str, int, int, float]]:
    """Return the limits that are to be kept after a page has been taken over.

    Each has its name, its column of channel motion, the sign of its worst value, and itself.
    """
    columns = [field.name for field in CHANNELS["motion"].fields]
    return [
        (name, columns.index(TASK_LIMITS[name][0]), TASK_LIMITS[name][1], value)
        for name, value in vars(limits).items()
        if value is not None and name in TASK_LIMITS
    ]


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
    """Give the boat the orders of a tick. Return the state's offsets and values that they wrote."""
    was = boat.state.whole.copy()
    while orders and orders[0].tick <= tick:
        order = order_of(orders.popleft(), plan.schedule)
        obey_all(boat, [] if order is None else [order])
    return state_changes(was, boat.state.whole)


def state_changes(was: Numbers, now: Numbers) -> StateWrites:
    """Return the offsets where two states differ, and what the second has."""
    offsets = np.flatnonzero(was.view(np.int64) != np.ascontiguousarray(now).view(np.int64))
    return [(int(offset), float(now[offset])) for offset in offsets]


# A kiosk


def boat_of_visitors(options: RunOptions) -> tuple[Boat, dict[str, Any]]:
    """Return a boat where the visitors' dive begins, and the dive.

    ConfigError where the boat cannot make it.
    """
    plan = plan_run(replace(options, exercise=VISITORS_EXERCISE))
    boat = Boat(plan.file, plan.method)
    warm_boat(boat)
    plan.start(boat)
    planes = [surface for surface in LEVER_SHARES if boat.carries(surface)]
    if not (boat.automatic and planes):
        raise ConfigError(
            f"{plan.file.path.name}: a kiosk needs planes, and an autopilot that levels the boat"
        )
    obey_all(boat, orders_due(boat, plan.schedule).get(0, ()))
    limits = {surface: float(boat.vessel[f"limit_{SURFACES[surface]}"]) for surface in planes}
    return boat, {
        "shares": [(surface, LEVER_SHARES[surface], limits[surface]) for surface in planes],
        "guarded": plan.guard.deepest,
        "ahead": GUARD_AHEAD_S,
        "keeps": GUARD_MARGIN_M,
        "given": RELEASE_MARGIN_M,
        "level": LEVEL_PITCH,
        "lasts": plan.duration,
        "exercise": [*exercise_facts(plan), ("hand", ",".join(plan.hand))],
    }


# The page


class PageParts(NamedTuple):
    """The boat as a page knows it, the core, and the title of the page."""

    boat: dict[str, Any]
    core: bytes
    title: str


def page_of(
    boat: Boat | None, recording: Path | None, role: str, visitors: dict[str, Any] | None = None
) -> PageParts:
    """Return the parts of a page of a boat or of a recording."""
    facts = None
    if recording is not None:
        boat, facts = boat_of(recording)
    if boat is None:
        raise ValueError("a page has a boat or a recording")
    core = shipped_module(boat)
    numbers = boat_for_page(boat, role) | {
        "recording": facts,
        "visitors": visitors,
        "first_lever": first_lever(boat) if facts is None and role == WHOLE_DESK else None,
    }
    title = boat.file.name if facts is None else f"{boat.file.name}: {facts['from']}"
    return PageParts(numbers, core, title)


def first_lever(boat: Boat) -> dict[str, Any] | None:
    """Return the limit [deg] of the first lever, and the order before its first.

    Its autopilot would work the bow planes against a hand at the stern planes. None for a boat
    without stern planes.
    """
    if not boat.carries("stern"):
        return None
    limit = math.degrees(float(boat.vessel.limit_s))
    return {
        "limit": round(min(limit, EASY_ANGLE)),
        "before": "bow zero" if boat.carries("bow") else "",
    }


def write_page(path: Path, text: str) -> None:
    """Write the page whole and print its name; ConfigError where it cannot be written."""
    write_over(path, text)
    click.echo(f"{path}  {path.stat().st_size / 1000:.0f} kB")
