"""The worked diff of docs/recipes.md, and whether it still applies.

python -m helpers.worked_diff, from the folder of the tests, makes it anew: it goes onto the last
commit, by what both have changed since, and what came of it stands in the page.
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


def renew() -> None:
    """Write the diff anew; end with what git says where it has to be mended by hand."""
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder) / "copy"
        git(ROOT, "clone", "--quiet", str(ROOT), str(copy))
        applied = git(copy, "apply", "--3way", "--index", says=worked_diff())
        if applied.returncode:
            sys.exit(f"{applied.stderr}Mend these files by hand, and put the diff into {PAGE}.")
        diff = git(copy, "diff", "--cached").stdout
    page = PAGE.read_text(encoding="utf-8")
    PAGE.write_text(BLOCK.sub(lambda _: diff, page), encoding="utf-8")


if __name__ == "__main__":
    renew()
