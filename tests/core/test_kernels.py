"""The rules of the core, read from its syntax trees."""

import ast
import re
from pathlib import Path

import numpy as np
import pytest

import trainer.core
from trainer.core.scheme import SCHEME
from trainer.core.state import SCRATCH, STATE
from trainer.core.vessel import COMPACT, VESSEL

CORE = Path(trainer.core.__file__).parent
KINDS = {"kernel", "inline_kernel", "unlocked"}
BIT_VIEW = re.compile(r"np\.(float64|int64)(\(.*\)\.view)?")  # of one number: allocates nothing
WRITABLE = {
    "state",
    "scratch",
    "out",
    "force",
    "gains",
    "system",
    "s",
    "work",
    "jacobian",
    "change",
}
WRITABLE |= {"acceleration", "eye"}  # the lookout is its caller's


def kernels() -> list[tuple[str, ast.FunctionDef]]:
    """Return every function decorated as a kernel."""
    return [
        (f"{path.stem}.{node.name}", node)
        for path in sorted(CORE.rglob("*.py"))
        for node in ast.parse(path.read_text(encoding="utf-8")).body
        if isinstance(node, ast.FunctionDef)
        and any(isinstance(d, ast.Name) and d.id in KINDS for d in node.decorator_list)
    ]


def written(kernel: ast.FunctionDef) -> set[str]:
    """Return the names whose fields or elements a kernel assigns to."""
    names = set()
    for node in ast.walk(kernel):
        targets = node.targets if isinstance(node, ast.Assign) else []
        targets = [node.target] if isinstance(node, ast.AugAssign) else targets
        for target in targets:
            for part in target.elts if isinstance(target, ast.Tuple) else [target]:
                root = part
                while isinstance(root, ast.Attribute | ast.Subscript):
                    root = root.value
                if root is not part and isinstance(root, ast.Name):
                    names.add(root.id)
    return names


def test_a_kernel_keeps_the_rules() -> None:
    faults = [f"{name}: {fault}" for name, kernel in kernels() for fault in broken_rules(kernel)]

    assert list(kernels())
    assert not faults


def broken_rules(kernel: ast.FunctionDef) -> list[str]:
    """Return the rules that a kernel breaks."""
    arguments = kernel.args
    powers = [n for n in ast.walk(kernel) if isinstance(n, ast.BinOp) and isinstance(n.op, ast.Pow)]
    calls = {ast.unparse(n.func) for n in ast.walk(kernel) if isinstance(n, ast.Call)}
    numpy = [call for call in calls if call.startswith("np.") and not BIT_VIEW.fullmatch(call)]
    library = calls & {"math.sin", "math.cos", "math.exp", "math.log", "math.atan2"}
    returned = ast.unparse(kernel.returns) if kernel.returns else ""
    rules = {
        "says what it returns, in which unit": bool(ast.get_docstring(kernel)),
        "a default hides an input": not arguments.defaults,
        "takes no inputs without a name": not arguments.vararg and not arguments.kwarg,
        "each input has its kind": all(argument.annotation for argument in arguments.args),
        "takes at most 6 inputs": len(arguments.args) <= 6,
        "writes only to what its caller owns": written(kernel) <= WRITABLE,
        "returns or writes, not both": not written(kernel) or returned in {"None", "int"},
        "fits on a screen": len(kernel.body) <= 32,
        "x * x: the library's pow would be in the bits": not powers,
        "no numpy call: it may allocate": not numpy,
        "no function of the library, which would be in the bits": not library,
    }
    return [rule for rule, is_kept in rules.items() if not is_kept]


def test_there_are_kernels_to_check() -> None:
    assert len(kernels()) > 40


@pytest.mark.parametrize("record", [STATE, VESSEL, COMPACT, SCRATCH, SCHEME])
def test_no_field_hides_behind_a_method_of_the_record(record: np.dtype) -> None:
    # without JIT s.sum would be numpy's method, with it the field
    assert not set(record.names or ()) & set(dir(np.record))
