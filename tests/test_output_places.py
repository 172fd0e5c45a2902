"""Whatever writes a file goes through ``io/outputs``, so that no input is ever written over."""

import ast
import functools
from collections.abc import Iterator

from helpers.places import ROOT
from helpers.syntax import tree_of

PACKAGE = ROOT / "trainer"
# Calls that write the file they are given, or give a file its name; by their last word, or whole
# fmt: off
WRITERS = frozenset((
    "write_text", "write_bytes", "savefig", "savez", "savetxt", "tofile", "touch", "ParquetWriter",
    "PdfPages", "FileIO", "write_table", "copyfile", "copytree", "rename", "symlink_to",
    "hardlink_to", "rr.save", "np.save", "os.link", "shutil.copy", "shutil.copy2", "shutil.move",
    "sqlite3.connect",
))
# fmt: on
WRITING_WORDS = {"open", "replace", *(each.rpartition(".")[2] for each in WRITERS)}
OWN_FUNCTIONS = frozenset(("write_text", "write_table"))  # of that name here, which go through it
GIVEN_BY = frozenset(("replacing", "renewing"))  # what yields where to write
OUTPUTS = "io/outputs.py"

# What may write past it, and why
REASONS = {
    "boat/compilation.py announce_compiling": "the cache",
    "boat/export/fmu.py link_binary": "a folder of its own, which goes",
    "boat/export/objects.py _lower_room": "a folder of its own, which goes",
    "boat/export/objects.py lower_boat": "a folder of its own, which goes",
    "boat/export/objects.py boat_object": "a folder of its own, which goes",
    "boat/machine_code.py made_object": "the cache",
    "boat/export/wasm.py lower": "a folder of its own, which goes",
    "boat/export/wasm.py _lowered": "a folder of its own, which goes",
    "classroom/fleet.py ClassBoat._launch": "a log in the folder of the class",
    "config/exercise/progress.py add_run": "sets a damaged file of the program's own aside",
    "console/own_session.py Program.__init__": "a folder of its own, which goes",
    "core/cache.py keep_digest": "the cache",
    "core/cache.py check_digest": "the cache",
    "io/file_lock.py holding": "a lock, which is never an input",
    "io/paths.py leave_address": "this user's session",
    "io/recording/durability.py _open": "asks the disk to keep what SQLite wrote",
    "io/recording/file.py connect": "a recording that is there, for reading or to go on with",
    "io/recording/file.py _write_whole": "a folder of its own, then a free name",
    "io/recording/file.py _write_converted": "a folder of its own, then a free name",
    "io/recording/file.py _give_name": "a free name",
    "io/tables.py _write_csv": "is given what replacing yields",
    "io/tables.py _write_parquet": "is given what replacing yields",
    "report/plots.py draw_plot": "pages of what replacing yields",
    "session/rerun/drawing.py Drawing.save": "is opened by open_output first",
    "web/address.py open_page": "a browser",
}


def may_write(call: ast.Call) -> bool:
    """Return whether a call's last word is one of those that write, which is quick to see."""
    return getattr(call.func, "attr", getattr(call.func, "id", "")) in WRITING_WORDS


def writes(call: ast.Call) -> bool:
    """Return whether a call writes a file, or may."""
    name = ast.unparse(call.func)
    last = name.rpartition(".")[2]
    if "os.devnull" in ast.unparse(call):
        return False
    if name == "os.open":
        return ast.unparse(call.args[1]) != "os.O_RDONLY"
    if name == "sqlite3.connect" and isinstance(call.args[0], ast.Constant):
        return False  # in memory
    if last == "open":
        modes = [each.value for each in call.keywords if each.arg == "mode"]
        modes += call.args[1:2] if name in ("open", "io.open") else call.args[:1]
        return any(
            not isinstance(each, ast.Constant) or {*"wax+"} & {*str(each.value)} for each in modes
        )
    if last == "replace" and name != "replace":  # a text's has two arguments, a time's has names
        return len(call.args) == 1 or name == "os.replace"
    return name in WRITERS - OWN_FUNCTIONS or (last in WRITERS and name != last)


def places_past(tree: ast.Module) -> Iterator[str]:
    """Yield the functions that write a file of which ``io/outputs`` has not given the name."""

    def look(node: ast.AST, where: str, given: frozenset[str]) -> Iterator[str]:
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            where = f"{where}.{node.name}".lstrip(".")
        if isinstance(node, ast.With):
            for item in node.items:
                opener = item.context_expr
                known = isinstance(opener, ast.Call) and ast.unparse(opener.func) in GIVEN_BY
                if known and item.optional_vars:
                    given |= {ast.unparse(item.optional_vars)}
        if isinstance(node, ast.Call) and may_write(node) and writes(node):
            names = {each.id for each in ast.walk(node) if isinstance(each, ast.Name)}
            if not given & names:
                yield where
        for child in ast.iter_child_nodes(node):
            yield from look(child, where, given)

    yield from look(tree, "", frozenset())


@functools.cache
def found_past() -> set[str]:
    """Return all functions of the package that write past ``io/outputs``."""
    return {
        f"{path.relative_to(PACKAGE).as_posix()} {where}"
        for path in sorted(PACKAGE.rglob("*.py"))
        if path != PACKAGE / OUTPUTS
        for where in places_past(tree_of(path))
    }


def test_every_output_goes_through_one_module() -> None:
    past = found_past()
    assert sorted(past - REASONS.keys()) == []  # write by io/outputs, or say here why not


def test_every_reason_is_still_needed() -> None:
    assert sorted(REASONS.keys() - found_past()) == []


def test_each_way_to_write_is_known() -> None:
    ways = (
        'path.open("wb")',
        'path.open(mode="a")',
        'open(path, "x")',
        "path.open(mode)",
        "path.write_text(text)",
        "path.write_bytes(data)",
        "figure.savefig(path)",
        "pq.write_table(table, path)",
        "pq.ParquetWriter(path, schema)",
        "PdfPages(path)",
        "sqlite3.connect(path)",
        "shutil.copyfile(source, path)",
        "made.replace(path)",
        "os.replace(made, path)",
        "os.open(path, os.O_RDWR)",
        "rr.save(path)",
    )
    assert [way for way in ways if not list(places_past(ast.parse(f"def f():\n {way}")))] == []
    harmless = ('path.open("rb")', "path.open()", 'text.replace("a", "b")', "replace(record, a=1)")
    assert [way for way in harmless if list(places_past(ast.parse(way)))] == []
    given = "with replacing(path) as made:\n made.write_text(text)"
    assert not list(places_past(ast.parse(given)))
    other = "with replacing(path) as made:\n path.write_text(text)"
    assert list(places_past(ast.parse(other)))
