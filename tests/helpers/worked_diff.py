"""The worked diffs of docs/recipes.md, and whether they still apply.

python -m helpers.worked_diff, from the folder of the tests, makes them anew: each in a copy of the
repository as it stands, by what the diff and the repository have both changed. Where the two meet
in one line, the copy stays to be mended, and python -m helpers.worked_diff FOLDER takes the diff
from there: the folder's name says which.
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
RECIPES: Final = ("order", "gauge")  # that have a worked diff, in the order of the page


def worked_diff(recipe: str) -> str:
    """Return the diff of a recipe as it stands in the page."""
    diffs = BLOCK.findall(PAGE.read_text(encoding="utf-8"))
    return str(dict(zip(RECIPES, diffs, strict=True))[recipe])


def git(folder: Path, *words: str, says: str = "") -> subprocess.CompletedProcess[str]:
    """Run git in a folder; return what it did."""
    return subprocess.run(
        ("git", *words), cwd=folder, input=says, capture_output=True, text=True, check=False
    )


def changed_copy(recipe: str) -> Path:
    """Return a copy with the diff in it; end with what git says where it has to be mended."""
    copy = Path(tempfile.mkdtemp()) / recipe
    revision = git(ROOT, "stash", "create").stdout.strip() or "HEAD"
    commit = git(ROOT, "rev-parse", revision).stdout.strip()
    git(ROOT, "clone", "--quiet", "--shared", "--no-checkout", str(ROOT), str(copy))
    git(copy, "checkout", "--quiet", "--detach", commit)
    applied = git(copy, "apply", "--3way", "--index", says=worked_diff(recipe))
    if applied.returncode:
        again = f"python -m helpers.worked_diff {copy}"
        sys.exit(f"{applied.stderr}Mend these files in {copy}, then: {again}")
    return copy


def renew(copy: Path) -> None:
    """Write what a copy has changed into the page."""
    git(copy, "add", "--all")
    diff = git(copy, "diff", "--cached", "HEAD").stdout
    page = PAGE.read_text(encoding="utf-8")
    PAGE.write_text(page.replace(worked_diff(copy.name), diff), encoding="utf-8")


if __name__ == "__main__":
    for copy in [Path(sys.argv[1])] if sys.argv[1:] else list(map(changed_copy, RECIPES)):
        renew(copy)
