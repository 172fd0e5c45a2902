"""The worked diff of docs/recipes.md, and whether it still applies.

python -m helpers.worked_diff, from the folder of the tests, makes it anew: in a copy of the
repository as it stands, by what the diff and the repository have both changed. Where the two meet
in one line, the copy stays to be mended, and python -m helpers.worked_diff FOLDER takes the diff
from there.
"""

import re
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Final

from helpers.places import ROOT

PAGE: Final = ROOT / "docs" / "recipes.md"
BLOCK: Final = re.compile(r"(?<=^```diff\n).*?(?=^```$)", re.MULTILINE | re.DOTALL)


def worked_diff() -> str:
    """Return the diff as it stands in the page."""
    (diff,) = BLOCK.findall(PAGE.read_text(encoding="utf-8"))
    return str(diff)


def git(folder: Path, *words: str, says: str = "") -> subprocess.CompletedProcess[str]:
    """Run git in a folder; return what it did."""
    return subprocess.run(
        ("git", *words), cwd=folder, input=says, capture_output=True, text=True, check=False
    )


def changed_copy() -> Path:
    """Return a copy with the diff in it; end with what git says where it has to be mended."""
    copy = Path(tempfile.mkdtemp()) / "copy"
    revision = git(ROOT, "stash", "create").stdout.strip() or "HEAD"
    commit = git(ROOT, "rev-parse", revision).stdout.strip()
    git(ROOT, "clone", "--quiet", "--shared", "--no-checkout", str(ROOT), str(copy))
    git(copy, "checkout", "--quiet", "--detach", commit)
    applied = git(copy, "apply", "--3way", "--index", says=worked_diff())
    if applied.returncode:
        again = f"python -m helpers.worked_diff {copy}"
        sys.exit(f"{applied.stderr}Mend these files in {copy}, then: {again}")
    return copy


def renew(copy: Path) -> None:
    """Write what a copy has changed into the page."""
    git(copy, "add", "--all")
    diff = git(copy, "diff", "--cached", "HEAD").stdout
    page = PAGE.read_text(encoding="utf-8")
    PAGE.write_text(BLOCK.sub(lambda _: diff, page), encoding="utf-8")


if __name__ == "__main__":
    renew(Path(sys.argv[1]) if sys.argv[1:] else changed_copy())
