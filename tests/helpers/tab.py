"""A boat of a page, flown by node."""

import json
import os
import subprocess
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

from bench.standard_hour import digest, fly_standard_hour

from helpers.installation import installed
from helpers.loops import in_a_loop
from helpers.places import ROOT
from trainer.boat.assemble import Records
from trainer.boat.export.wasm import SHIPPED_PATH
from trainer.debrief.page.boat_page import state_changes
from trainer.web.modules import ASSETS_FOLDER

HOST: Final = ROOT / "tests" / "web" / "tab.mjs"
PATIENCE: Final = 120.0  # [s]


def fly(boat: dict[str, Any], *deeds: Sequence[Any]) -> list[Any]:
    """Return what each deed has told: see tab.mjs. The test is skipped where there is no node."""
    node = installed("node", "nodejs")
    asked = json.dumps(
        {"boat": {"recording": None, **boat}, "deeds": [list(each) for each in deeds]}
    )
    with tempfile.TemporaryDirectory() as folder:
        scripts = Path(folder) / "tab"
        scripts.mkdir()
        for path in (ASSETS_FOLDER / "js" / "tab").glob("*.js"):
            (scripts / path.name).write_bytes(path.read_bytes())
        (Path(folder) / "package.json").write_text('{"type": "module"}')
        done = subprocess.run(
            [node, str(HOST), str(scripts), str(SHIPPED_PATH)],
            input=asked,
            capture_output=True,
            text=True,
            timeout=PATIENCE,
            check=False,
            env=os.environ.copy(),
        )
    assert done.returncode == 0, done.stderr[-2000:]
    told: list[Any] = json.loads(done.stdout)
    return told


def standard_hour() -> tuple[list[tuple[Any, ...]], str]:
    """Return what a page is to do in the standard hour, and the digest of the hour's end."""
    deeds: list[tuple[Any, ...]] = []
    left: list[Any] = []  # the state at the end of the ticks before

    def take(records: Records, ticks: int) -> int:
        now = records.state["whole"][0]
        if left:
            deeds.append(("write", state_changes(left.pop(), now)))
        deeds.append(("fly", ticks))
        status = in_a_loop(records, ticks)
        left.append(now.copy())
        return status

    end = digest(fly_standard_hour(take))
    return deeds, end
