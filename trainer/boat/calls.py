"""What a monitor calls out after a tick, and how urgent it is."""

from enum import Enum
from typing import NamedTuple


class Rank(Enum):
    """How urgent an alert is, by IMO MSC.302(87). The value is the word that programs get."""

    EMERGENCY = "emergency"
    ALARM = "alarm"
    WARNING = "warning"
    CAUTION = "caution"  # a remark, which nobody has to acknowledge


class MonitorCall(NamedTuple):
    """One call of a monitor. With a key it holds until the monitor's ``holding`` lacks that key."""

    text: str
    rank: Rank = Rank.ALARM
    key: str = ""  # the name of its alert, with ``: SHIP`` where each ship has its own
