"""The door of a boat: its session says whether a word admits.

The class knows no words. So there is one place that judges them, with the waits of its guesses.
"""

import asyncio
import contextlib
from typing import Final

from trainer.io.connection import carried_for
from trainer.io.orders import sentences
from trainer.io.orders.grammar import Refused
from trainer.io.serial_line import LinkError
from trainer.web.bridge import Reach

ANSWER_TIMEOUT_S: Final = 40.0  # longer than the longest wait for the answer to a wrong word


async def ask_role(reach: Reach, machine: str, role: str, word: str) -> Refused | None:
    """Return why a boat refuses a role with a word, None where it admits.

    ``machine`` is the address of whoever asks, by which the session counts wrong words.
    """
    try:
        end = await asyncio.to_thread(reach)
        reader, writer = await asyncio.open_connection(sock=end)
    except (LinkError, OSError):
        return Refused("this boat is not at sea yet; try again in a moment")
    try:
        asked = sentences.order_sentence(f"role {role} {word}".rstrip(), "1")
        writer.write(f"{carried_for(machine)}\n{asked}\n".encode("ascii", "replace"))
        async with asyncio.timeout(ANSWER_TIMEOUT_S):
            return await _answer(reader)
    except (TimeoutError, OSError, ValueError):
        return Refused("this boat does not answer")
    finally:
        writer.close()
        with contextlib.suppress(OSError):
            await writer.wait_closed()


async def _answer(reader: asyncio.StreamReader) -> Refused | None:
    """Return the answer to the first question of a line."""
    while said := await reader.readline():
        sentence = sentences.parse_sentence(said.decode("ascii", "replace").strip())
        if sentence is None or (sentence.kind, sentence.tag) != ("TRA", "1"):
            continue
        if sentence.fields[0] in ("ok", "no"):
            return None if sentence.fields[0] == "ok" else Refused(sentence.fields[1])
    return Refused("this boat has closed the line")
