"""All channels by name, and what else may be subscribed to."""

from collections.abc import Mapping
from typing import Final

from trainer.stations import panels, truth
from trainer.stations.fields import Channel

CHANNELS: Final[Mapping[str, Channel]] = {
    channel.name: channel for channel in (*panels.CHANNELS, *truth.CHANNELS)
}
TELETYPE: Final = "teletype"  # the state in one line of 79 columns, under headings
EVENTS: Final = "events"  # what happens, when it happens


def tables() -> str:
    """Return the Markdown tables of the channels, as docs/stations.md shows them."""
    return "\n".join(f"{table(channel)}\n" for channel in CHANNELS.values())


def table(channel: Channel) -> str:
    """Return the table of one channel."""
    rows = [f"### `{channel.name}`", "", f"{channel.says[0].upper()}{channel.says[1:]}.", ""]
    rows += ["| field | unit |", "|---|---|"]
    return "\n".join(
        [*rows, *(f"| `{field.name}` | {field.unit or 'word'} |" for field in channel.fields)]
    )
