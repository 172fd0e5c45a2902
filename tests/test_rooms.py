"""Rooms: each package names the modules that other packages may use, and nobody uses others.

A room is a package of `trainer/`, or a package in one. The list stands in its `__init__`, as
`__all__`. Who is outside of an inner room is outside of each room around it too, and asks them all.
Only the trainer's own modules count as users: a test may look behind any door, and keeps none open.
"""

import ast
from collections.abc import Collection, Iterable, Iterator, Mapping
from functools import cache
from importlib import import_module
from typing import Final, NamedTuple

import grimp
import pytest
from helpers.places import ROOT
from helpers.syntax import nodes_of

# Its list names what a program of one's own begins with. The boat, the fleet and machine code call
# its kernels one by one, so every module of it is open to every room.
OPEN_ROOM: Final = "trainer.core"
MAX_PLACES: Final = 40  # modules and rooms that lie in a room itself
MAX_FLOORS: Final = 12
GROWN_FLOORS: Final = {
    "trainer.core": 14,
    "trainer.session": 15,
}  # as they were


class Use(NamedTuple):
    """A module uses another, by an import or by its name as a text."""

    user: str
    line: int
    used: str


def is_within(module: str, room: str) -> bool:
    """Return whether a module is a room itself, or lies in it."""
    return module == room or module.startswith(f"{room}.")


def file_of(module: str) -> str:
    """Return the path of a module in the repository."""
    path = ROOT.joinpath(*module.split("."))
    return str(
        (path / "__init__.py" if path.is_dir() else path.with_suffix(".py")).relative_to(ROOT)
    )


def rooms_entered(use: Use, rooms: Iterable[str]) -> Iterator[tuple[str, str]]:
    """Yield each room that a use enters from outside, and the name in it that is used."""
    for room in rooms:
        if use.used.startswith(f"{room}.") and not is_within(use.user, room):
            yield room, use.used[len(room) + 1 :].partition(".")[0]


def nearest(used: str, room: str, uses: Iterable[Use], names: list[str]) -> str:
    """Return the open modules of a room that use a closed one themselves, else all of them."""
    within = (use.user for use in uses if use.used == used and is_within(use.user, room))
    faces = {user[len(room) + 1 :].partition(".")[0] for user in within}
    return ", ".join([name for name in names if name in faces] or names)


def closed_doors(uses: Collection[Use], lists: Mapping[str, list[str]]) -> list[str]:
    """Return the uses of modules that their room does not name, a line each."""
    return [
        f"{file_of(use.user)}:{use.line} uses {use.used}, but {file_of(room)} does not name {name}"
        f" in __all__; what is open and near: {nearest(use.used, room, uses, lists[room])}"
        for use in uses
        for room, name in rooms_entered(use, lists)
        if name not in lists[room] and not is_within(room, OPEN_ROOM)
    ]


def idle_names(uses: Collection[Use], lists: Mapping[str, list[str]]) -> list[str]:
    """Return the modules that a room names though no other room uses them, a line each."""
    entered = {each for use in uses for each in rooms_entered(use, lists)}
    return [
        f"{file_of(room)}: no other room uses {name}, which __all__ names"
        for room, names in lists.items()
        for name in names
        if (room, name) not in entered
    ]


def unknown_names(lists: Mapping[str, list[str]], modules: Collection[str]) -> list[str]:
    """Return the names of rooms that are no modules, a line each."""
    return [
        f"{file_of(room)}: there is no {room}.{name}, which __all__ names"
        for room, names in lists.items()
        for name in names
        if f"{room}.{name}" not in modules
    ]


def arrows_in(room: str, uses: Iterable[Use]) -> set[tuple[str, str]]:
    """Return what lies in a room itself, in pairs of which the first uses the second."""
    within = [use for use in uses if all(each.startswith(f"{room}.") for each in use[::2])]
    pairs = {(place_in(use.user, room), place_in(use.used, room)) for use in within}
    return {(user, used) for user, used in pairs if user != used}


def place_in(module: str, room: str) -> str:
    """Return the name of a module, or of the inner room that it lies in, within a room."""
    return module[len(room) + 1 :].partition(".")[0]


def floors(arrows: Collection[tuple[str, str]]) -> int:
    """Return how many floors a room has: the longest way down, a circle counted as one."""
    below: dict[str, set[str]] = {each: set() for arrow in arrows for each in arrow}
    for user, used in arrows:
        for name in [user, *(each for each, under in below.items() if user in under)]:
            below[name] |= {used, *below[used]}

    @cache
    def height(name: str) -> int:
        return 1 + max((height(each) for each in below[name] if name not in below[each]), default=0)

    return max(map(height, below), default=1)


@cache
def graph() -> grimp.ImportGraph:
    """Return all imports of the trainer, those for type checkers and within functions too."""
    return grimp.build_graph("trainer", include_external_packages=False, cache_dir=None)


def imports() -> Iterator[Use]:
    """Yield each import of one module by another."""
    for user in sorted(graph().modules):
        for used in sorted(graph().find_modules_directly_imported_by(user)):
            for each in graph().get_import_details(importer=user, imported=used):
                yield Use(user, each["line_number"], used)


def starts_by_name() -> Iterator[Use]:
    """Yield each module that another names in a text, to start it, or to import it or of it."""
    for user in sorted(graph().modules):
        for each in nodes_of(ROOT / file_of(user)):
            if isinstance(each, ast.Constant) and isinstance(each.value, str) and "." in each.value:
                named = f"trainer.{each.value.removeprefix('trainer.')}"
                for module in graph().modules & {named, named.rpartition(".")[0]}:
                    yield Use(user, each.lineno, module)


@cache
def names_of_rooms() -> dict[str, list[str]]:
    """Return what each room names in `__all__`, but the names that it gives to users' programs."""
    return {
        room: [name for name in import_module(room).__all__ if name not in names_for_users(room)]
        for path in sorted((ROOT / "trainer").rglob("*/__init__.py"))
        for room in [".".join(path.parent.relative_to(ROOT).parts)]
        if room == OPEN_ROOM or not is_within(room, OPEN_ROOM)
    }


def names_for_users(room: str) -> tuple[str, ...]:
    """Return the names that a room hands out itself, which docs/python-names.md lists."""
    return getattr(import_module(room), "PYTHON_FACE", ())


@cache
def uses() -> tuple[Use, ...]:
    """Return every use of one module by another."""
    return (*imports(), *starts_by_name())


def test_no_room_uses_what_another_keeps_for_itself() -> None:
    assert len(uses()) > 1000
    assert not closed_doors(uses(), names_of_rooms())


def test_no_room_names_what_no_other_uses() -> None:
    assert not idle_names(uses(), names_of_rooms())


def test_no_room_names_what_is_not_there() -> None:
    assert not unknown_names(names_of_rooms(), graph().modules)


def test_no_room_outgrows_what_a_reader_can_keep() -> None:
    for room in names_of_rooms():
        lying = {place_in(each, room) for each in graph().modules if each.startswith(f"{room}.")}
        assert len(lying) <= MAX_PLACES, room
        assert floors(arrows_in(room, uses())) <= GROWN_FLOORS.get(room, MAX_FLOORS), room


@pytest.mark.parametrize(
    ("arrows", "count"),
    [("ab bc ac", 3), ("ab bc cd ca", 2), ("ab cd", 2), ("cd bc ab de", 5), ("", 1)],
)
def test_floors_are_the_longest_way_down(arrows: str, count: int) -> None:
    assert floors([(each[0], each[1]) for each in arrows.split()]) == count


HOUSE: Final = {"trainer.boat": ["helm", "world"], "trainer.boat.world": ["bottom"]}


@pytest.mark.parametrize(
    ("user", "used", "room"),
    [
        ("trainer.session.past.plan", "trainer.boat.entries", "boat"),
        ("trainer.session.past.plan", "trainer.boat.world.swell", "boat/world"),
        ("trainer.boat.limits", "trainer.boat.world.swell", "boat/world"),
        ("trainer", "trainer.boat.entries", "boat"),
        ("trainer.core.kernel", "trainer.boat.entries", "boat"),
    ],
)
def test_a_use_of_what_a_room_keeps_is_seen(user: str, used: str, room: str) -> None:
    face = {"boat": "helm", "boat/world": "bottom"}[room]
    within = Use(f"trainer.{room.replace('/', '.')}.{face}", 3, used)

    (fault,) = closed_doors([Use(user, 31, used), within], HOUSE)
    assert fault.startswith(f"{file_of(user)}:31 uses {used}, but trainer/{room}/__init__.py")
    assert fault.endswith(f"near: {face}")


@pytest.mark.parametrize(
    ("user", "used"),
    [
        ("trainer.session.past.plan", "trainer.boat.helm"),
        ("trainer.session.past.plan", "trainer.boat.world.bottom"),
        ("trainer.boat.world.contacts", "trainer.boat.entries"),
        ("trainer.boat.world.contacts", "trainer.boat.world.swell"),
        ("trainer.session.past.plan", "trainer.boat"),
        ("trainer.session.past.plan", "trainer.core.full"),
    ],
)
def test_a_use_of_what_is_named_or_within_a_room_is_free(user: str, used: str) -> None:
    assert not closed_doors([Use(user, 31, used)], {**HOUSE, OPEN_ROOM: []})


def test_a_name_used_from_within_alone_is_seen_as_idle() -> None:
    within = Use("trainer.boat.limits", 3, "trainer.boat.helm")
    without = Use("trainer.session.past.plan", 3, "trainer.boat.world.bottom")

    (fault,) = idle_names([within, without], HOUSE)
    assert fault == "trainer/boat/__init__.py: no other room uses helm, which __all__ names"


def test_a_name_of_no_module_is_seen() -> None:
    there = ["trainer.boat.helm", "trainer.boat.world"]

    (fault,) = unknown_names(HOUSE, there)
    assert "there is no trainer.boat.world.bottom" in fault
