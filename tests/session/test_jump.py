"""Every object of a session that remembers something follows a jump in time, or says why not."""

import ast
import inspect
import sys
import threading
from collections import deque
from collections.abc import Iterable, Iterator, Mapping, Sequence
from enum import Enum
from functools import cache
from pathlib import Path
from types import MethodType
from typing import Any, Final, NamedTuple

import pytest
from helpers.crewed import Begin, Crewed

from trainer.session.jump import followers
from trainer.session.parts import Parts
from trainer.session.past.options import RunOptions
from trainer.session.past.plan import plan_run
from trainer.session.stations.station import News

CARRIED: Final[Mapping[str, Sequence[str]]] = {  # by the follower that takes them back
    "Monitors": (
        *("LimitMonitor", "EncounterMonitor", "DepthMonitor"),
        *("PilotMonitor", "TailMonitor", "EngineMonitor", "PlantMonitor", "BatteryWatch"),
    ),
    "ExerciseEnd": ("LossMonitor",),
    "DamageWatch": ("GroundMonitor",),
    "OrdersInForce": ("CrewTalk", "HandWork", "WatchBill", "PumpMonitor", "Agenda"),
    "EventLog": ("OwnAlerts", "AlertBook"),
}
LASTING: Final[Mapping[str, Sequence[str]]] = {  # by the reason why they do not follow
    "the jump begins with them": ("Control", "History", "Moments", "Boat"),
    "they obey anew what the world was ordered": (
        *("CurrentAround", "Contacts", "ContactFleet", "Periscope"),
    ),
    "they have all branches": ("Recording", "Checkpointer", "Syncer"),
    "who is attached stays so": (
        *("Station", "WordCounts", "TokenGuesses", "NoiseLog", "CrowdLog", "Command"),
    ),
    "what was sent is sent": ("PromptSender", "Roster", "Subscriptions"),
    "the present moment is shown anew": ("ScreenOutput", "StateReader", "PastReader"),
    "the machine's time goes on": (
        *("Alarm", "FreePacer", "Timekeeping", "SlipJudge", "Ledger", "Histogram", "QuietTicks"),
        "OrderAllowance",
    ),
    "what goes on beside the ticks comes to its end": ("BackgroundTask", "Session"),
    "a jump is barred while it shows the way": ("Demonstration",),
    "the summary has all that was refused": ("Dispatch",),
    "what is kept of who trains stays kept": ("Training",),
}
GROWING: Final = {  # of followers, and kept for all branches
    *(f"EventLog.{name}" for name in ("news", "_branch", "_counts")),
    *("AlertBook.number", "AlertBook.notes"),
    *("OrdersInForce._by_order", "OrdersInForce._latest"),
}
CHANGES: Final = (  # methods that change a container
    *("add", "append", "appendleft", "clear", "discard", "extend", "insert", "pop", "popitem"),
    *("popleft", "remove", "setdefault", "update"),
)
OURS: Final = ("trainer.", __name__)


def is_ours(kind: type) -> bool:
    return kind.__module__.startswith(OURS)


def held_by(thing: Any) -> Iterable[Any]:
    """Return the objects that an object holds."""
    if isinstance(thing, Mapping):
        return thing.values()
    if isinstance(thing, list | tuple | set | frozenset | deque):
        return thing
    if isinstance(thing, MethodType):
        return (thing.__self__,)
    return getattr(thing, "__dict__", {}).values() if is_ours(type(thing)) else ()


def objects_of(session: object) -> list[Any]:
    """Return all objects of this program that a session holds, itself included."""
    seen: dict[int, Any] = {}
    waiting: list[Any] = [session]
    while waiting:
        thing = waiting.pop()
        if id(thing) not in seen:
            seen[id(thing)] = thing
            waiting += held_by(thing)
    return [each for each in seen.values() if is_ours(type(each))]


def kinds_of(session: object) -> set[type]:
    """Return the classes of these objects."""
    return {type(each) for each in objects_of(session)}


def attributes_changed(function: ast.AST) -> Iterator[str]:
    """Yield the attributes of ``self`` that a function changes."""
    for node in ast.walk(function):
        targets: list[ast.expr] = []
        if isinstance(node, ast.Assign | ast.Delete):
            targets = [*node.targets]
        elif isinstance(node, ast.AugAssign | ast.AnnAssign):
            targets = [node.target]
        elif isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute):
            targets = [node.func.value] if node.func.attr in CHANGES else []
        while targets:
            target = targets.pop()
            if isinstance(target, ast.Tuple | ast.List):
                targets += target.elts
            elif isinstance(target, ast.Subscript):
                targets.append(target.value)
            elif isinstance(target, ast.Attribute) and ast.unparse(target.value) == "self":
                yield target.attr


@cache
def classes_of(module: str) -> Mapping[str, ast.ClassDef]:
    """Return the classes of a module, as they are written."""
    tree = ast.parse(Path(inspect.getfile(sys.modules[module])).read_text("utf-8"))
    return {each.name: each for each in ast.walk(tree) if isinstance(each, ast.ClassDef)}


def memory_of(kind: type) -> set[str]:
    """Return the attributes that an object's own methods change after it has been made."""
    memory: set[str] = set()
    for each in filter(is_ours, kind.__mro__):
        for function in ast.iter_child_nodes(classes_of(each.__module__)[each.__name__]):
            if getattr(function, "name", "__init__") not in ("__init__", "__post_init__"):
                memory |= {*attributes_changed(function)}
    return memory


def plainly(value: Any) -> object:
    """Return what an attribute says by itself. Objects with a memory of their own say it there."""
    if isinstance(value, Mapping):
        return {repr(key): plainly(each) for key, each in value.items()}
    if isinstance(value, list | tuple | deque):
        return [plainly(each) for each in value]
    frozen = getattr(value, "__dataclass_params__", None)
    own = is_ours(type(value)) and not isinstance(value, Enum) and not (frozen and frozen.frozen)
    bare = own or callable(value) or isinstance(value, threading.Event)
    return type(value).__name__ if bare else repr(value)


class Said(NamedTuple):
    """What an object said at a moment. It is held, so that no later one gets its identity."""

    thing: object
    attributes: Mapping[str, object]


def remembered(session: object) -> dict[int, Said]:
    """Return what each object of a session says now, by its identity."""
    return {
        id(each): Said(each, {name: plainly(value) for name, value in vars(each).items()})
        for each in objects_of(session)
        if hasattr(each, "__dict__")
    }


def later_than(before: Mapping[int, Said], session: object) -> dict[str, set[str]]:
    """Return which attributes say something else than before, by the names of their classes."""
    found: dict[str, set[str]] = {}
    for identity, (thing, now) in remembered(session).items():
        if identity in before:
            then = before[identity].attributes
            changed = {key for key, value in then.items() if now.get(key) != value}
            found.setdefault(type(thing).__name__, set()).update(changed)
    return found


def listed(session: Parts) -> set[str]:
    """Return the classes that follow a jump, or are taken back by one that does."""
    carried = {name for names in CARRIED.values() for name in names}
    return carried | {type(each).__name__ for each in followers(session)}


def unlisted(session: Parts, before: Mapping[int, Said]) -> set[str]:
    """Return each attribute remembered by an object that nobody has listed.

    It is remembered if a method changes it, or if it has changed since ``before``.
    """
    known = listed(session) | {name for names in LASTING.values() for name in names}
    memory = later_than(before, session)
    for kind in kinds_of(session):
        memory.setdefault(kind.__name__, set()).update(memory_of(kind))
    return {f"{name}.{key}" for name in memory.keys() - known for key in memory[name]}


def let_much_happen(ship: Crewed) -> None:
    helm = ship.comes("helm")
    for words in ("order course 045", "tell hold her", "in 20 s rpm 60", "stern planes dive 20"):
        ship.order(words)
    ship.say(helm, "course 045 aye")
    ship.fly(200)
    ship.order("freeze")


def exercise(crewed: Begin) -> Crewed:
    """Return a crew of an exercise that has a schedule, losses and a reference crew."""
    plan = plan_run(RunOptions(exercise="stern-plane-jam"))
    return crewed(plan=plan, lost=("depth > 400",), seconds=900.0)


@pytest.mark.long
def test_whoever_remembers_something_follows_a_jump_or_says_why_not(crewed: Begin) -> None:
    ship = exercise(crewed)
    before = remembered(ship.session)
    let_much_happen(ship)
    assert not unlisted(ship.session, before), "give it `follow`, and a line in `followers`"


def test_nobody_is_listed_who_remembers_nothing(crewed: Begin) -> None:
    ship = exercise(crewed)
    there = {type(each).__name__: type(each) for each in objects_of(ship.session)}
    assert not {name for names in LASTING.values() for name in names} & listed(ship.session)
    for table in (CARRIED, LASTING):
        assert not {name for names in table.values() for name in names} - there.keys()
    assert CARRIED.keys() <= listed(ship.session)


class Tally:
    """A part that somebody adds to a session: it counts what is told."""

    def __init__(self) -> None:
        self.count = 0

    def hear(self, _news: News) -> None:
        self.count += 1


def test_a_part_that_is_added_and_remembers_is_found(crewed: Begin) -> None:
    ship = exercise(crewed)
    ship.session.event_log.hearers.append(Tally().hear)
    assert unlisted(ship.session, {}) == {"Tally.count"}


def test_a_memory_that_others_write_is_found(crewed: Begin) -> None:
    ship = exercise(crewed)
    before = remembered(ship.session)
    ship.session.attendance.until_left = True
    assert unlisted(ship.session, before) == {"Attendance.until_left"}


def test_whoever_follows_a_jump_is_as_he_was_then(crewed: Begin) -> None:
    ship = exercise(crewed)
    ship.fly(60)
    ship.order("snapshot then")
    ship.order("restore then")
    then, session = remembered(ship.session), ship.session
    let_much_happen(ship)
    ship.order("restore then")
    memory = {kind.__name__: memory_of(kind) for kind in kinds_of(session)}
    later = {
        f"{name}.{key}"
        for name, keys in later_than(then, session).items()
        for key in keys & memory[name]
        if name in listed(session)
    }
    assert later == GROWING


def test_what_was_called_after_a_moment_is_called_again_after_a_jump_to_it(ship: Crewed) -> None:
    ship.order("snapshot then")
    for calls in (1, 2):
        ship.order("stern planes dive 25")
        ship.fly(100)
        heard = ship.events(ship.instructor, "watch")
        assert sum("EQUATIONS EXTRAPOLATED" in each for each in heard) == calls
        ship.order("restore then")
