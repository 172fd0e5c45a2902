"""Commands of ``trainer`` in a process that cannot import numba.

A kernel that the machine code lacks would import it: so whatever runs is the machine code.
``python -m helpers.without_numba FILE.json`` runs the commands of a file, a list of words each,
with what is typed to this process. It writes a line of JSON for each: its exit code, its output,
and what was raised.
``python -m helpers.without_numba WORD...`` is the command ``trainer WORD...``.
"""

import json
import sys
import traceback
from collections.abc import Sequence
from importlib.machinery import ModuleSpec
from importlib.metadata import version
from pathlib import Path


class NumbaRefusal:
    """A finder of modules that refuses numba."""

    @staticmethod
    def find_spec(name: str, _path: object = None, _target: object = None) -> ModuleSpec | None:
        """Raise ImportError for numba and all within it; find nothing else."""
        if name.partition(".")[0] == "numba":
            raise ImportError(f"{name}: numba cannot be imported in this process")
        return None


def refuse_numba() -> None:
    """Let this process import no numba, which is installed and was not imported."""
    assert version("numba")
    assert "numba" not in sys.modules
    sys.meta_path.insert(0, NumbaRefusal)


def run_commands(commands: Sequence[Sequence[str]]) -> None:
    """Run commands one after another, and write what became of each."""
    from click.testing import CliRunner  # noqa: PLC0415  numba is refused first

    from trainer.cli.main import cli  # noqa: PLC0415

    typed = sys.stdin.read()
    for words in commands:
        done = CliRunner().invoke(cli, list(words), input=typed)
        raised = done.exception
        told = "" if raised is None or isinstance(raised, SystemExit) else repr(raised)
        where = "".join(traceback.format_exception(raised)) if told else ""
        line = {"words": words, "code": done.exit_code, "said": done.output, "raised": where}
        sys.stdout.write(json.dumps(line) + "\n")


if __name__ == "__main__":
    refuse_numba()
    if sys.argv[1].endswith(".json"):
        run_commands(json.loads(Path(sys.argv[1]).read_text("utf-8")))
    else:
        from trainer.cli.main import cli

        cli(sys.argv[1:])
