"""What kernels pass by place has a name.

A number among others in an array (a gain, a memory of a filter, a column) is looked up by the name
of its place, and scratch is a record whose fields have names. So no kernel of these folders has

- an index that is a whole number but 0: ``gains[3]``, ``row[-1]``, ``terms[j, 1]``;
- an index that is something plus or minus a whole number: ``gains[first + 3]``. What the kernel's
  own loop counts may have a neighbour: ``depths[i + 1]``;
- two indices of whole numbers after one another: ``scratch[1][2]``, 0 among them;
- an input that is a tuple of arrays or of tuples, under a name of its own or not; the records of
  a boat, which ``sail`` takes as ``update`` does, are one.

0 is the one element of a record, or the first of a series. A shape has no names.
"""

import ast
from collections.abc import Iterator
from pathlib import Path
from typing import Final

import pytest

import trainer
from trainer.identify.fitting.nonlinear import BentShip
from trainer.identify.kernels.nonlinear_steering import BENT

PACKAGE: Final = Path(trainer.__file__).parent
FOLDERS: Final = ("core", "identify/kernels", "boat/ship")
KINDS: Final = {"kernel", "inline_kernel", "lean_kernel", "unlocked"}
ARRAYS: Final = ("Numbers", "Entries", "Complexes", "Mask", "Places", "NDArray", "Terms")
NEXT_ROW: Final = "the next row of a table, beside the one that was found"
AS_IN_THE_REPORT: Final = "entries of a matrix, by the numbers that its source gives them"
EXEMPT: Final = {
    "core/sea/forces.strip_sum": NEXT_ROW,
    "core/sea/free_surface.between": NEXT_ROW,
    "core/sea/free_surface.between_depths": NEXT_ROW,
    "core/sea/free_surface.cell": NEXT_ROW,
    "core/sea/free_surface.surface_forces": "the last depth of a table",
    "core/sea/wave_filter.choose_rows": NEXT_ROW,
    "core/sea/wave_filter.left_length": NEXT_ROW,
    "core/sea/filter_1969._powers": "coefficients of polynomials, by their power",
    "core/entry.write_row": "it writes a whole row, once, in the order that it says",
    "core/compact.inertia": AS_IN_THE_REPORT,
    "core/compact.off_centre_inertia": AS_IN_THE_REPORT,
    "core/full.inertia": AS_IN_THE_REPORT,
    "identify/kernels/sensitivity._rows": "the stage that was begun last",
    "identify/kernels/ship_models._start_variances": AS_IN_THE_REPORT,
    "identify/kernels/ship_models._model_1": AS_IN_THE_REPORT,
    "identify/kernels/ship_models._model_1_outputs": AS_IN_THE_REPORT,
    "identify/kernels/ship_models._yaw_outputs": AS_IN_THE_REPORT,
    "identify/kernels/ship_models.model_1": AS_IN_THE_REPORT,
    "identify/kernels/ship_models.model_2": AS_IN_THE_REPORT,
    "identify/kernels/ship_models.model_3": AS_IN_THE_REPORT,
    "identify/kernels/ship_models.nomoto": AS_IN_THE_REPORT,
    "identify/kernels/ship_models.nomoto_first": AS_IN_THE_REPORT,
    "boat/ship/forces.units_of": "the last two of any state: roll rate and roll, where it rolls",
}
MATRICES: Final = {"out", "drift", "noise", "start", "force"}  # of AS_IN_THE_REPORT


def kernels() -> Iterator[tuple[str, ast.FunctionDef]]:
    """Yield every function of the folders that is compiled, by module and name."""
    for folder in FOLDERS:
        for path in sorted((PACKAGE / folder).rglob("*.py")):
            module = path.relative_to(PACKAGE).with_suffix("").as_posix()
            for node in ast.parse(path.read_text(encoding="utf-8")).body:
                if isinstance(node, ast.FunctionDef) and is_kernel(node):
                    yield f"{module}.{node.name}", node


def is_kernel(function: ast.FunctionDef) -> bool:
    """Return whether a function is compiled."""
    return any(isinstance(d, ast.Name) and d.id in KINDS for d in function.decorator_list)


def whole_number(node: ast.expr) -> int | None:
    """Return the whole number that is written there, None if there is none."""
    sign = 1
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
        node, sign = node.operand, -1
    if isinstance(node, ast.Constant) and type(node.value) is int:
        return sign * node.value
    return None


def counted(kernel: ast.FunctionDef) -> set[str]:
    """Return the names that the kernel's own loops count."""
    loops = [node.target for node in ast.walk(kernel) if isinstance(node, ast.For)]
    return {part.id for loop in loops for part in ast.walk(loop) if isinstance(part, ast.Name)}


def indices(subscript: ast.Subscript) -> list[ast.expr]:
    """Return the indices of a subscript, one for each dimension."""
    place = subscript.slice
    return place.elts if isinstance(place, ast.Tuple) else [place]


def is_bare(index: ast.expr, counts: set[str]) -> bool:
    """Return whether an index is a place without a name."""
    if whole_number(index):
        return True
    if not (isinstance(index, ast.BinOp) and isinstance(index.op, ast.Add | ast.Sub)):
        return False
    sides = index.left, index.right
    others = [side for side in sides if whole_number(side) is None]
    return len(others) == 1 and not (isinstance(others[0], ast.Name) and others[0].id in counts)


def is_nested(subscript: ast.Subscript) -> bool:
    """Return whether two indices of whole numbers follow one another."""
    outer = [whole_number(index) for index in indices(subscript)]
    if not isinstance(subscript.value, ast.Subscript) or None in outer:
        return False
    return None not in [whole_number(index) for index in indices(subscript.value)]


def bare_places(kernel: ast.FunctionDef) -> list[str]:
    """Return the subscripts of a kernel whose place has no name."""
    counts = counted(kernel)
    return [
        ast.unparse(node)
        for statement in kernel.body
        for node in ast.walk(statement)
        if isinstance(node, ast.Subscript)
        and not (isinstance(node.value, ast.Attribute) and node.value.attr == "shape")
        and (is_nested(node) or any(is_bare(index, counts) for index in indices(node)))
    ]


def is_unnamed(kind: str) -> bool:
    """Return whether a type is a tuple of arrays or of tuples."""
    return kind.startswith("tuple[") and any(name in kind[6:] for name in (*ARRAYS, "tuple"))


def unnamed_scratch(kernel: ast.FunctionDef) -> list[str]:
    """Return the inputs of a kernel that are tuples of arrays or of tuples."""
    inputs = [ast.unparse(part) for part in kernel.args.args]
    return [part for part in inputs if is_unnamed(part.partition(": ")[2])]


def unnamed_kinds() -> Iterator[str]:
    """Yield the types of the folders that are such tuples under a name of their own."""
    for path in sorted(path for each in FOLDERS for path in (PACKAGE / each).rglob("*.py")):
        for node in ast.parse(path.read_text(encoding="utf-8")).body:
            if isinstance(node, ast.Assign) and is_unnamed(ast.unparse(node.value)):
                yield f"{path.stem}: {ast.unparse(node)}"


def faults(name: str, kernel: ast.FunctionDef) -> list[str]:
    """Return what a kernel passes by place without a name."""
    places = bare_places(kernel)
    reason = EXEMPT.get(name)
    if reason == AS_IN_THE_REPORT:
        places = [place for place in places if place.split("[", 1)[0] not in MATRICES]
    elif reason:
        places = []
    return [f"{name}: {fault}" for fault in (*places, *unnamed_scratch(kernel))]


def test_what_kernels_pass_by_place_has_a_name() -> None:
    found = [fault for name, kernel in kernels() for fault in faults(name, kernel)]

    assert len(list(kernels())) > 200
    assert not found, "\n".join(found)
    assert not list(unnamed_kinds())


def test_no_exemption_has_outlived_its_kernel() -> None:
    bare = {name for name, kernel in kernels() if bare_places(kernel)}

    assert set(EXEMPT) <= bare


@pytest.mark.parametrize(
    "line",
    [
        "x = gains[3]",
        "x = gains[first + 3]",
        "x = gains[3 + first]",
        "x = gains[last - 1]",
        "x = row[-1]",
        "x = terms[first, 1]",
        "x = scratch[0][1]",
        "x = scratch[0][0]",
        "x = scratch[1][2]",
        "x = s.notch[2 * first + 5]",
        "row[2] += x",
        "for i in range(3): x = gains[first + 3]",
    ],
)
def test_a_place_without_a_name_is_found(line: str) -> None:
    assert bare_places(kernel_of(line))


@pytest.mark.parametrize(
    "line",
    [
        "s = state[0]",
        "x = gains[first + PITCH_GAIN]",
        "x = a.shape[1]",
        "for i in range(3): x = depths[i + 1] - depths[i]",
        "x = theta[MODEL.P11 : MODEL.lag]",
    ],
)
def test_a_place_with_a_name_is_none_of_them(line: str) -> None:
    assert not bare_places(kernel_of(line))


@pytest.mark.parametrize(
    "kind", ["tuple[Numbers, Numbers]", "tuple[tuple[float, float], int]", "tuple[Mask, float]"]
)
def test_scratch_in_a_tuple_is_found(kind: str) -> None:
    assert unnamed_scratch(kernel_of("pass", kind))
    assert not unnamed_scratch(kernel_of("pass", "tuple[Record, ...]"))
    assert not unnamed_scratch(kernel_of("pass", "tuple[float, float]"))


def kernel_of(line: str, kind: str = "int") -> ast.FunctionDef:
    """Return a kernel of one line with one input of that kind."""
    function = ast.parse(f"def f(first: {kind}):\n    {line}").body[0]
    assert isinstance(function, ast.FunctionDef)
    return function


def test_a_bent_ship_s_numbers_are_where_its_kernel_looks() -> None:
    ship = BentShip(1.0, 2.0, 3.0, 4.0, delta_0=8.0, H=(5.0, 6.0, 7.0))
    known = {"K": 1.0, "T1": 2.0, "T2": 3.0, "T3": 4.0, "H1": 5.0, "H2": 6.0, "H3": 7.0}

    found = {name: ship.numbers[getattr(BENT, name)] for name in BENT._fields}

    assert found == {**known, "delta_0": 8.0}
