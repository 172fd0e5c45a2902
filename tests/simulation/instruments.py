"""A plotter at a cable, and a display at datagrams, hear the boat's instruments.

The plotter steers too, as an autopilot ashore would. What they hear has to be whole, and often.
Ships near are heard too, see ``traffic``.
"""

from dataclasses import dataclass, field
from typing import Final

from simulation.laws import Docket, Law
from simulation.machine import SECOND_NS, Machine
from simulation.traffic import Air, Receiver
from simulation.wires import Wires
from trainer.io.nmea import MAX_SENTENCE_LETTERS, NmeaSentence, parse_sentence, sentence

CABLE: Final = "cable of the plotter"
DATAGRAMS: Final = "udp://127.0.0.1"
NMEA_OPTIONS: Final = {"nmea": (CABLE, DATAGRAMS)}
LOOK_PERIOD_S: Final = 0.5
MAX_SILENCE_NS: Final = 3 * SECOND_NS  # of a session that nobody ends: three times the product's
ORDERS: Final = (
    sentence("AGHTC", "V", "10.0", "R", "M", "N", "", "", "", "", "", "", "", "T"),
    sentence("AGHSC", "45.0", "T", "", ""),
    sentence("IIROR", "-5.0", "A", "", "V"),
    "$IIROR,-5.0,A,,V*00",
)


@dataclass
class Plotter:
    """What listens, and orders the rudder now and then."""

    machine: Machine
    wires: Wires
    docket: Docket
    air: Air
    _cable: Receiver = field(init=False)
    _display: Receiver = field(init=False)
    _rest: bytes = b""
    _heard_at: int = 0  # [ns] the last sentence

    def __post_init__(self) -> None:
        self._cable, self._display = (
            Receiver(f"nmea {url}", self.air, self.docket) for url in (CABLE, DATAGRAMS)
        )

    def run(self) -> None:
        """Listen for as long as the process lives."""
        machine = self.machine
        while True:
            asked_at = machine.now
            machine.sleep(LOOK_PERIOD_S)
            if machine.now - asked_at > 2 * LOOK_PERIOD_S * SECOND_NS:  # the machine slept
                self._heard_at = machine.now
            self._listen()
            for line in self.wires.sent:
                self._hear(line, self._display)
            self.wires.sent.clear()

    def _listen(self) -> None:
        """Take what has come by the cable; then order something, seldom."""
        machine, end = self.machine, self.wires.cable(CABLE).far
        if end is None or end.reset:
            self._rest, self._heard_at = b"", 0
            self._cable.lose()
            return
        came = end.recv(len(end.came)) if end.came else b""
        *lines, self._rest = (self._rest + came).split(b"\r\n")
        for line in lines:
            self._hear(line.decode("ascii", "replace"), self._cable)
            self._heard_at = machine.now
        self._heard_at = self._heard_at or machine.now
        if machine.now - self._heard_at > MAX_SILENCE_NS:
            self.docket.enter(Law.INSTRUMENTS, "the plotter has heard nothing for 3 s")
        if machine.dice.random() < 0.1:
            order = f"{machine.dice.choice(ORDERS)}\r\n".encode()
            while order and end.writable:
                order = order[end.send(order) :]

    def _hear(self, line: str, receiver: Receiver) -> None:
        whole = isinstance(parse_sentence(line), NmeaSentence)
        if not whole or len(line) > MAX_SENTENCE_LETTERS - 2:
            self.docket.enter(Law.INSTRUMENTS, f"a damaged sentence: {line!r}")
        else:
            receiver.hear(line)
