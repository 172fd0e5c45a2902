"""What the pages know of alerts, made of the session's table.

python -m helpers.page_alerts, from the folder of the tests, writes it among the pages' scripts.
"""

import json
from typing import Final

from trainer.session.stations.alert_table import ALERT_TABLE, SOUND_PACES_S
from trainer.web.modules import ASSETS_FOLDER

PAGE: Final = ASSETS_FOLDER / "js" / "model" / "alert-table.js"
HEAD: Final = """\
// Alerts, as the session's own table has them: python -m helpers.page_alerts makes this.
import { say } from "../words.js";

/** How long until an alert of that rank sounds again [s]. @type {Record<string, number>} */
"""
TITLES: Final = """
/** The title of each alert, by its name. @type {Record<string, () => string>} */
export const TITLES = {
"""


def script() -> str:
    """Return the module: the paces of the ranks, and the titles."""
    paces = ", ".join(f"{rank.value}: {pace:g}" for rank, pace in SOUND_PACES_S.items())
    titles = (
        f"  {json.dumps(name)}: () => say({json.dumps(row.title)}),\n"
        for name, row in ALERT_TABLE.items()
    )
    return f"{HEAD}export const PACES = {{ {paces} }};\n{TITLES}{''.join(titles)}}};\n"


if __name__ == "__main__":
    PAGE.write_text(script(), encoding="utf-8")
