"""The reference of the Python face, a page made of its docstrings.

python -m helpers.python_reference, from the folder of the tests, writes the page.
"""

import inspect
from collections.abc import Iterator

import trainer
from helpers.places import ROOT
from trainer import identify

PAGE = ROOT / "docs" / "python-names.md"
HEAD = """\
# Python: every name

After this page you know what each public name takes and returns. [Python](python.md) has examples.
"""


def reference() -> str:
    """Return the reference as Markdown, the whole page."""
    own = [(f"trainer.{name}", getattr(trainer, name)) for name in trainer.__all__]
    own += [(f"trainer.identify.{name}", getattr(identify, name)) for name in identify.PYTHON_FACE]
    return "\n".join([HEAD, *(line for each in own for line in _entry(*each))]).rstrip() + "\n"


def _entry(name: str, found: object) -> Iterator[str]:
    """Yield the lines about one public name."""
    yield f"## {name}{_signature(found)}\n"
    yield _text(found) + "\n"
    if found is trainer.TrainerError or not inspect.isclass(found):
        return
    for member, value in vars(found).items():
        if not member.startswith("_") and (callable(value) or isinstance(value, property)):
            of = "" if isinstance(value, property) else _signature(value)
            yield f"- `{member}{of}`: {' '.join(_text(value).split())}"
    yield ""


def _signature(found: object) -> str:
    """Return the arguments of a function, or of a boat, without their types."""
    if not callable(found) or (inspect.isclass(found) and found is not trainer.Boat):
        return ""  # what is only handed out
    signature = inspect.signature(found)
    shown = [
        each.replace(annotation=inspect.Parameter.empty)
        for each in signature.parameters.values()
        if each.name != "self" and not each.name.startswith("_")
    ]
    bare = signature.replace(parameters=shown, return_annotation=inspect.Signature.empty)
    return str(bare).replace("**options", "**keywords")


def _text(found: object) -> str:
    """Return a docstring as Markdown has it."""
    return inspect.cleandoc(getattr(found, "__doc__", None) or "").replace("``", "`")


def write() -> None:
    """Renew the page."""
    PAGE.write_text(reference(), encoding="utf-8")


if __name__ == "__main__":
    write()
