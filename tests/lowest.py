"""``python -m tests.lowest``: the tests of everybody with the lowest versions that are allowed.

A range in `pyproject.toml` is a promise to whoever has an old version of a library. uv installs the
lowest of each range, with all that a user may ask for, into an environment of its own.
"""

import subprocess
import sys
import tempfile
import tomllib
from pathlib import Path
from typing import Final

ROOT: Final = Path(__file__).parents[1]
UV: Final = (sys.executable, "-m", "uv")
NOT_INSTALLED: Final = ("dev", "rerun")  # rerun-sdk is half a gigabyte, and of one version
# an old library warns of the end of what it uses: uvicorn's of a part of websockets
WARNED: Final = ("-W", "ignore::DeprecationWarning")
LANE: Final = ("-q", "-n", "auto", "-m", "not process and not slow and not long", *WARNED)


def run(*words: str) -> int:
    """Run a command in the checkout; return its exit code."""
    return subprocess.run(words, cwd=ROOT, check=False).returncode


def main() -> int:
    """Install the lowest versions, and what tests need beside them; return the tests' exit code."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    extras = ",".join(project["optional-dependencies"].keys() - set(NOT_INSTALLED))
    with tempfile.TemporaryDirectory(prefix="lowest") as folder:
        python = str(Path(folder) / "bin" / "python")
        install = (*UV, "pip", "install", "--quiet", "--python", python)
        return (
            run(*UV, "venv", "--quiet", "--python", sys.executable, "--clear", folder)
            or run(*install, "--resolution", "lowest-direct", f".[{extras}]")
            or run(*install, "--editable", ".[dev]")  # which leaves what is there and allowed
            or run(*UV, "pip", "list", "--quiet", "--python", python)
            or run(python, "-m", "pytest", *LANE)
        )


if __name__ == "__main__":
    sys.exit(main())
