"""The time from the helm's serial line to an NMEA 0183 instrument at another.

``python -m tests.bench --helm`` measures it: the time runs from the first byte of the order to the
last byte of the sentence that shows the rudder on its way.
"""

import re
import subprocess
import time
from typing import Final

from bench.terminal import TerminalLine, line
from trainer.analysis.bench.delays import TRAINER_COMMAND, OrderDelays, order_lines, time_orders
from trainer.config.boat.vessel import VesselFile

SENTENCE_RATE_HZ: Final = "20"  # [Hz] of the sentences, at most: there is one for each tick
START_TIMEOUT_S: Final = 600.0  # [s] a first start, on a machine that is busy with other work
RUDDER_SENTENCE: Final = re.compile(rb"\$INRSA,(-?[0-9]+\.[0-9]+),A[^\n]*\n")


def time_helm(file: VesselFile, seconds: float) -> OrderDelays:
    """Return the delays of orders given for ``seconds`` [s]; ConfigError if none acts."""
    with line() as helm, line() as instrument:
        words = ("serve", "--vessel", str(file.path), "--line", f"helm={helm.name}")
        nmea = ("--nmea", instrument.name, "--nmea-sentences", "RSA")
        alone = ("--nmea-rate", SENTENCE_RATE_HZ, "--listen", "none", "--socket", "none")
        with subprocess.Popen(
            [*TRAINER_COMMAND, *words, *nmea, *alone, "--no-record"],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        ) as process:
            try:
                shown_rudder(instrument, time.monotonic() + START_TIMEOUT_S)
                return time_orders(
                    file, seconds, helm.say, lambda until: shown_rudder(instrument, until)
                )
            finally:
                process.terminate()


def shown_rudder(instrument: TerminalLine, until: float) -> float | None:
    """Return the rudder's next angle [deg] to starboard. None: none by ``until`` [s]."""
    match = instrument.find(RUDDER_SENTENCE, until)
    return float(match[1]) if match else None


def lines(figures: OrderDelays) -> list[str]:
    """Return the figures as lines of a page."""
    return order_lines(figures, "AN INSTRUMENT (two serial lines")
