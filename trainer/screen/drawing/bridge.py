"""The first line: what session this is, the time, how it runs, and whether the line holds."""

from trainer.screen.ink import Line, Lines, beside, line
from trainer.screen.journal import clock
from trainer.screen.sight import Sight


def top(sight: Sight, width: int, _height: int) -> Lines:
    """Return the first line, or what is wrong with the line to the session."""
    if not sight.joined:
        words = f" NO LINE {sight.trouble}; trying again "
        return [beside(line((words, "alarm")), line(), width, "alarm")]
    if sight.over:
        return [
            beside(line((" THE SESSION IS OVER: F10 leaves ", "alarm")), line(), width, "alarm")
        ]
    left = line((f" {sight.role} ", "bright"), (f"{clock(sight.picture.seconds)} ", "bright"))
    return [beside((*left, *pace(sight)), line((title(sight), "bar")), width, "bar")]


def pace(sight: Sight) -> Line:
    """Return how time runs."""
    picture = sight.picture
    factor = picture.word("time", "speed")
    speed = "as fast as it goes" if factor == "max" else f"x{picture.pace:g}"
    parts = [(" FROZEN ", "alarm")] if picture.frozen else [("RUNNING", "running")]
    parts.append((f" {speed}", "bar"))
    if picture.word("time", "replay") == "yes":
        parts.append(("  REPLAY", "key"))
    held = picture.word("time", "held")
    if held:
        parts.append((f"  HELD: {held}", "key"))
    if sight.instructs and picture.pace:
        parts.append((f"  branch {picture.word('time', 'branch')}", "bar"))
    return line(*parts)


def title(sight: Sight) -> str:
    """Return what the session calls itself."""
    return f" {sight.briefing[0]} " if sight.briefing else ""


def foot(keys: tuple[tuple[str, str], ...], width: int) -> Lines:
    """Return the keys that there is room for, the first ones first."""
    parts: list[tuple[str, str]] = [(" ", "bar")]
    room = width - 1
    for label, says in keys:
        taken = len(label) + len(says) + 3
        if taken > room + 1:
            break
        parts += [(label, "key"), (f" {says}  ", "bar")]
        room -= taken
    return [beside(line(*parts), line(), width, "bar")]
