"""The briefing of a station about exercise and vessel: lines for people, facts for programs.

``attendance`` sends it to whoever takes a role. The crew hears nothing that names what is hidden,
when it comes or what cures it. So it hears no scores and no file's name, and of the losing
conditions only those that its own gauges show.
"""

import math
import textwrap
from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass, field, fields
from typing import Final

from trainer.boat.boat import Boat
from trainer.config.boat.plant_records import HAND_MODE
from trainer.config.exercise.derived import Loss
from trainer.config.exercise.exercise import ExerciseLimits
from trainer.config.exercise.loss_words import word_loss
from trainer.core.ballast.tanks import COMPARTMENTS, TANKS
from trainer.core.surfaces import SURFACES
from trainer.io.orders.grammar import Order, parse
from trainer.io.orders.help import NO_ROLE_TEXT
from trainer.session.crew.manning import BY_HAND
from trainer.session.stations.display import MAX_LINE_LETTERS
from trainer.session.stations.panels import TONNE_KG
from trainer.session.stations.roles import INSTRUCTOR_ROLE, Role, refusal
from trainer.units import KNOT

# a losing condition on one of these is no secret: gauges of the crew show it
OPEN_QUANTITIES: Final = frozenset({"depth", "pitch", "heel", "speed", "showing", "time"})
WINNING_TEXT: Final = (
    "each order carried out in time and kept; every danger mastered; no limit passed"
)
SIDE_WORDS: Final = {"max": "at most", "min": "at least"}
LIMIT_NAMES: Final = {  # quantities of limits that have another name among people
    "cpa": "range to a ship",
    "clearance": "water under the keel",
    "speed_over_ground": "speed over the ground",
}
BRIEFING_TITLES: Final = {
    "hand": "by hand",
    "hand-from": "by hand from [s]",
    "allowed": "allowed",
    "aids": "aids allowed",
    "hint": "marks that a hint costs",
    "light": "light",
    "limits": "limits",
    "wins": "won by",
    "lost": "lost by",
    "length": "length",
    "course": "of the course",
}
AUTOPILOT_EXAMPLES: Final = ("depth 80", "course 090", "rudder left 15")
STATION_EXAMPLES: Final = (
    *("stern planes dive 5", "flood depth-control 1", "scope raise", "order course 045"),
    "order depth 80",
)
TEST_DEPTH_ROLES: Final = ("instructor", "diving", "deck", "observer")  # test depth


@dataclass(frozen=True)
class Briefing:
    """The texts of one exercise. All are empty where there is none."""

    name: str = ""  # of its file, which may tell what breaks
    title: str = ""  # the crew's
    text: tuple[str, ...] = ()
    instructor: tuple[str, ...] = ()  # for the instructor alone
    hides: bool = False  # an older file, whose text gives away what will break
    limits: ExerciseLimits = field(default_factory=ExerciseLimits)
    lost: tuple[Loss, ...] = ()
    tasks: tuple[str, ...] = ()
    steps: int = 0  # of a lesson, which nothing wins
    duration: float | None = None  # [s]
    visitors: bool = False  # may begin it again
    aids: tuple[str, ...] = ()  # that are allowed
    way: bool = False  # there is a reference crew to show it
    hint_marks: float = 0.0  # that each hint costs
    light: str = ""  # that the periscope sees by
    course: str = ""  # its place in its class's, how many there are, the marks to reach

    def heading(self, role: Role) -> tuple[str, ...]:
        """Return title and text as a role is told them."""
        if role is INSTRUCTOR_ROLE:
            named = f"{self.title} ({self.name})" if self.title else ""
            return tuple(filter(None, (named, *self.text, *self.instructor)))
        return () if self.hides else tuple(filter(None, (self.title, *self.text)))

    def facts(self, role: Role, seconds: float) -> Iterator[tuple[str, str]]:
        """Yield keys of the exercise and their values, at a time [s] since the start."""
        if not self.title:
            return
        instructs = role is INSTRUCTOR_ROLE
        if instructs:
            yield "name", self.name
        if instructs or not self.hides:
            yield "title", self.title
            yield from (("line", line) for line in self.text)
        if instructs:
            yield from (("line", line) for line in self.instructor)
        every = ((item.name, getattr(self.limits, item.name)) for item in fields(self.limits))
        limits = [f"{name}:{value:g}" for name, value in every if value is not None]
        yield from (("limits", ",".join(limits)) for _ in limits[:1])
        for loss in self.lost:  # the crew may know what its gauges show
            if instructs or OPEN_QUANTITIES.issuperset(each.quantity for each in loss.conditions):
                yield "lost", loss.text
        wins = self.tasks if instructs else (WINNING_TEXT,)[: 0 if self.steps else 1]
        yield from (("wins", each) for each in wins)
        yes = {"visitors": self.visitors, "way": self.way}
        yield from ((key, "yes") for key, given in yes.items() if given)
        yield from (("hint", f"{self.hint_marks:g}") for _ in range(self.way and not self.steps))
        yield from (("aids", ",".join(self.aids)) for _ in self.aids[:1])
        yield from (("light", self.light) for _ in self.light[:1])
        yield from (("course", self.course) for _ in self.course[:1])
        if self.steps:
            yield "steps", str(self.steps)
        if self.duration is not None:
            yield "duration", f"{self.duration:g}"
            yield "left", f"{max(self.duration - seconds, 0.0):g}"


def place_in_words(place: str) -> str:
    """Return the place in a course, as a fact has it, for people."""
    number, of, reach = place.split(", ")
    return f"{number} of {of}" + (f", {reach} marks to go on" if reach else "")


def in_words(facts: Iterable[tuple[str, str]]) -> list[str]:
    """Return the facts of an exercise as lines for people, of at most 79 columns."""
    said: dict[str, list[str]] = {}
    for key, value in facts:
        said.setdefault(key, []).append(value.replace(",", ", "))
    time_left = said.pop("left", [""])[0]
    said["lost"] = [*map(word_loss, said.pop("lost", []))]
    said["length"] = [f"{whole} s, {time_left} s left" for whole in said.pop("duration", [])]
    said["course"] = [*map(place_in_words, said.pop("course", []))]
    said["limits"] = [
        ", ".join(limit_in_words(*limit.split(":")) for limit in limits.split(", "))
        for limits in said.pop("limits", [])
    ]
    lines = [
        f"{word}: {'; '.join(said[key])}" for key, word in BRIEFING_TITLES.items() if said.get(key)
    ]
    return [
        part
        for line in lines
        for part in textwrap.wrap(line, MAX_LINE_LETTERS, subsequent_indent="  ")
    ]


def limit_in_words(name: str, value: str) -> str:
    """Return a limit such as depth_m_max in words."""
    what, unit, end = name.rsplit("_", 2)
    unit = "" if unit == "level" else f" {unit}"
    return f"{LIMIT_NAMES.get(what, what.replace('_', ' '))} {SIDE_WORDS[end]} {value}{unit}"


def hint(role: Role, hand: Collection[str]) -> str:
    """Return some orders that a station may give. ``hand`` has the axes worked by hand.

    An observer gets none, because it may be a screen that is about to say its role.
    """
    if role.name == "observer":
        return NO_ROLE_TEXT
    by_hand = [order for axis, (_, order) in BY_HAND.items() if axis in hand]
    examples = [words for words in (by_hand or AUTOPILOT_EXAMPLES) if may_order(role, words)]
    examples = examples or [words for words in STATION_EXAMPLES if may_order(role, words)]
    repeats = ["aye"] if hand and may_order(role, "aye") else []
    last = "quit" if may_order(role, "quit") else "detach"
    opening = "by hand: " if hand else "type an order, such as: "
    return opening + "   ".join((*examples[: 2 if repeats else 3], *repeats, "help", last))


def may_order(role: Role, words: str) -> bool:
    """Return whether a role may give an order in its typed form."""
    order = parse(words)
    return isinstance(order, Order) and refusal(role, order) is None


def ranges(boat: Boat, role: Role) -> Iterator[tuple[str, str]]:
    """Yield keys and values of the vessel's ranges, without those that the boat lacks."""
    hull, run, c = boat.file.hull, boat.file.run, boat.vessel
    yield "length", f"{hull.length:g}"
    yield "mass", f"{hull.mass / TONNE_KG:g}"
    for surface, letter in SURFACES.items():
        limit = math.degrees(float(c[f"limit_{letter}"])) if boat.toward[surface] else 0.0
        yield from ((surface, f"{limit:g}") for _ in range(limit > 0.0))
    depths = {"depth": hull.max_depth_m, "periscope": run.periscope_depth_m}
    if role.name in TEST_DEPTH_ROLES:
        depths["test-depth"] = hull.test_depth_m
    yield from ((key, f"{depth:g}") for key, depth in depths.items() if depth is not None)
    if boat.file.plant:
        surfaces = boat.file.plant.surfaces
        for mode in surfaces.modes:
            yield f"shift-{mode}", f"{surfaces.man_s if mode == HAND_MODE else surfaces.shift_s:g}"
    yield "speed", f"{float(c.u_c_ahead) / KNOT:g}"
    yield "astern", f"{-float(c.u_c_astern) / KNOT:g}"
    yield "bell", "stop:0"
    for name, speed in boat.file.propulsion.bells_kn.items():
        ahead, _, most = name.partition("_")
        yield "bell", f"{ahead} {most.replace('_', '-')}:{speed:g}"
    for name, whole in zip(TANKS, c.capacity.tolist(), strict=True):
        if whole and name not in COMPARTMENTS:
            yield "tank", f"{name}:{whole / TONNE_KG:g}"
    fore, aft = (TANKS.index(name) for name in ("trim_forward", "trim_aft"))
    if c.capacity[fore] and c.capacity[aft]:
        yield "trim-arm", f"{float(c.x[fore] - c.x[aft]):g}"
