"""The words of the command line that a run on an exported core takes."""

from trainer.bare.card import WrongError

TAKING = ("--core", "--duration", "--speed", "--csv", "--orders", "--state")
UNITS = {"h": 3600.0, "m": 60.0, "s": 1.0}


class Options:
    """What was asked for."""

    def __init__(self, words: list[str]) -> None:
        """Read the words after ``trainer run``; WrongError naming the one that is wrong."""
        given = _given(words)
        if "--headless" not in given:
            raise WrongError("--core: such a run has no console; add --headless")
        if not given.get("--core"):
            raise WrongError("--core: give the path of an exported library")
        self.core = given["--core"]
        self.duration = seconds(given["--duration"]) if "--duration" in given else None  # [s]
        self.speed = speed(given.get("--speed", "1"))  # [-] inf: as fast as can be
        self.csv = given.get("--csv", "")
        self.orders = given.get("--orders", "")
        self.state = given.get("--state", "")


def _given(words: list[str]) -> dict[str, str]:
    """Return the values of the options by name."""
    given = {}
    left = iter(words)
    for word in left:
        name, equals, value = word.partition("=")
        if name == "--headless" and not equals:
            given[name] = ""
        elif name not in TAKING:
            raise WrongError(
                f"{word}: a run on an exported core, whose boat, sea and step are settled, takes "
                f"--headless and {', '.join(TAKING)}"
            )
        elif not equals and (value := next(left, "")) == "":
            raise WrongError(f"{name}: a value is missing")
        else:
            given[name] = value
    return given


def seconds(text: str) -> float:
    """Return a time [s] written as 90, 10m or 1h30m; WrongError if it is none."""
    total, digits, units = 0.0, "", "hms"
    for letter in text.strip().lower():
        place = units.find(letter)
        if letter in "0123456789.":
            digits += letter
        elif place < 0 or not _plain(digits):
            break
        else:
            total += float(digits) * UNITS[letter]
            digits, units = "", units[place + 1 :]
    else:
        bare_number = _plain(digits) and units == "hms"
        total += float(digits) if bare_number else 0.0
        if total > 0.0 and (bare_number or not digits):
            return total
    raise WrongError(f"--duration {text}: give a time such as 90, 10m or 1h30m")


def _plain(digits: str) -> bool:
    """Return whether this is a number of digits and at most one point."""
    return digits.replace(".", "", 1).isdecimal() and digits[0] != "."


def speed(text: str) -> float:
    """Return a speed of time, infinite for max; WrongError if it is none."""
    if text.lower() in ("max", "inf"):
        return float("inf")
    if _plain(text.removeprefix("x")) and 0.1 <= float(text.removeprefix("x")) <= 100.0:
        return float(text.removeprefix("x"))
    raise WrongError(f"--speed {text}: give 0.1 to 100, or max")
