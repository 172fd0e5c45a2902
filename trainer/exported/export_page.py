"""What an export is, in words."""

from dataclasses import asdict
from pathlib import Path

from trainer.exported.folder import HOST, LIBRARY, OBJECT, Exported


def render(exported: Exported, folder: Path, files: tuple[str, ...]) -> str:
    """Return the account of an export into ``folder``."""
    words = asdict(exported.words_of_16_bits)
    lines = [
        exported.boat,
        f"compiled for {exported.cpu}",
        *(f"  {folder / name}" for name in files),
        "",
        "16-bit words",
        *(f"  {name:10}{count:8,}" for name, count in words.items()),
        f"  {'together':10}{sum(words.values()):8,}",
        "",
        f"cc -O2 -o host {folder / HOST} {folder / OBJECT}",
    ]
    if LIBRARY in files:
        lines.append(f"trainer run --headless --core {folder / LIBRARY} --duration 1h --speed max")
    return "\n".join(lines)
