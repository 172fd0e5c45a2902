"""The first hour of docs/tutorial.md, walked from nothing in one folder."""

import os
import re
import subprocess
import sys
from dataclasses import dataclass, field
from pathlib import Path

import pytest

pytestmark = pytest.mark.process

ROOT = Path(__file__).parent.parent
PAGE = (ROOT / "docs" / "tutorial.md").read_text(encoding="utf-8")
BLOCK = re.compile(r"```(sh|orders|seen)\n(.*?)```|replace `([^`]*)` by `([^`]*)`", re.DOTALL)
FLIGHT = "--teletype --speed max --orders orders.txt --duration"
LONGEST = 600  # [s] of a flight: that of the exercise


@dataclass
class Walk:
    """What somebody who walks through the page types, and has seen so far."""

    folder: Path
    seen: str = ""
    flights: int = 0
    commands: list[str] = field(default_factory=list)

    def type(self, line: str) -> None:
        """Run a command of the page as its reader does; sessions are told to quit."""
        done = subprocess.run(
            ["sh", "-c", line],
            cwd=self.folder,
            env=os.environ | self._places(),
            input="status\nquit\n" if line.startswith("trainer run") else "",
            capture_output=True,
            text=True,
            timeout=300,
            check=False,
        )
        assert done.returncode == 0, f"{line}: {done.stderr}"
        assert "Traceback" not in done.stderr
        self.commands.append(line)
        self.seen += done.stdout + done.stderr

    def fly(self, orders: str) -> None:
        """Give the orders of the page at their seconds, in a run of the last kind."""
        self.flights += 1
        (self.folder / "orders.txt").write_text(orders, encoding="utf-8")
        run = next(line for line in reversed(self.commands) if line.startswith("trainer run"))
        recording = self.folder / "state/submarine-trainer/recordings" / f"{self.flights}.trainer"
        self.type(f"{run} {FLIGHT} {LONGEST} --record {recording} < /dev/null")
        self.commands.pop()

    def change(self, old: str, new: str) -> None:
        """Change the reader's own file as the page says."""
        file = self.folder / "drill.toml"
        text = file.read_text(encoding="utf-8")
        assert text.count(old) == 1
        file.write_text(text.replace(old, new), encoding="utf-8")

    def _places(self) -> dict[str, str]:
        path = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
        return {"PATH": path, "XDG_STATE_HOME": str(self.folder / "state")}


def missing(shown: str, seen: str) -> list[str]:
    """Return the lines that the page shows and the walk has not seen."""
    return [line for line in shown.splitlines() if line not in seen]


@pytest.mark.slow
def test_the_first_hour_goes_as_its_page_says(tmp_path: Path) -> None:
    walk = Walk(tmp_path)
    for kind, text, old, new in BLOCK.findall(PAGE):
        if kind == "sh":
            for line in text.splitlines():
                walk.type(line)
        elif kind == "orders":
            walk.fly(text)
        elif kind == "seen":
            assert not missing(text, walk.seen)
        else:
            walk.change(old, new)

    assert walk.flights == 3
    assert any("exercise new" in line for line in walk.commands)
    assert walk.commands[-1] == "trainer debrief --last"
