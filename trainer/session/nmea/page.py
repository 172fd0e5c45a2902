"""The NMEA sentences for people and programs, as ``trainer dev instruments`` prints them.

``cli/listings`` calls it. It is made of the table by which sentences are sent, and has a sample, so
that a user can set up a chart plotter without a session.
"""

from datetime import UTC, datetime
from typing import Any, Final

from trainer.boat.assemble import Method
from trainer.boat.boat import Boat
from trainer.config.boat.vessel import VesselFile
from trainer.io.chart import DEFAULT_CHART
from trainer.session.nmea.sentences import (
    INSTRUMENTS,
    USUAL_NAMES,
    Instrument,
    InstrumentSet,
    choose_instruments,
)
from trainer.session.stations.view import Pace, Picture, StateReader
from trainer.session.time.ledger import Ledger
from trainer.units import KNOT

SAMPLE_TIME: Final = datetime(2026, 1, 1, 12, tzinfo=UTC)  # fixed: docs/nmea-sentences.md stays


def page() -> str:
    """Return the sentences for a terminal, a paragraph each."""
    blocks = []
    for instrument in INSTRUMENTS:
        fields = (f"{number:>4}  {field}" for number, field in enumerate(instrument.fields, 1))
        blocks.append(
            "\n".join([f"{heading(instrument)}: {instrument.says} ({instrument.source})", *fields])
        )
    return "\n\n".join(blocks)


def heading(instrument: Instrument) -> str:
    """Return the address of a sentence, with its first field where that tells two apart."""
    page_letter = f",{instrument.fields[0]}" if instrument.name == "PXSC" else ""
    return f"${instrument.address}{page_letter}"


def as_json() -> list[dict[str, Any]]:
    """Return the table as plain records."""
    return [
        {
            "sentence": heading(instrument),
            "name": instrument.name,
            "tells": instrument.says,
            "fields": list(instrument.fields),
            "source": instrument.source,
        }
        for instrument in INSTRUMENTS
    ]


def sample(file: VesselFile) -> list[str]:
    """Return the sentences of one tick: of a boat in trim, at a fixed time."""
    boat = Boat(file, Method("modified", "lagged", "exact", "adams2", file.run.step_s))
    boat.start(file.run.start_speed_kn * KNOT, file.run.start_depth_m, 0.0)
    reader = StateReader(boat, Ledger(boat.method.step).summary)
    frame = reader.frame(Picture(0, boat.records.state.tobytes(), Pace()))
    return InstrumentSet(choose_instruments(USUAL_NAMES), DEFAULT_CHART, SAMPLE_TIME).lines(frame)
