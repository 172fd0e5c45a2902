"""What an exported core says about itself: lines of text inside the library.

    trainer-core FORMAT
    KEY VALUE                one line each of version, core, boat, computed, cpu, needs, step,
                             places, work, columns, watched
    order ROW                one line for each wording, see trainer.bare.wording

Lines of other keys, of a later trainer, are passed over.
"""

FORMAT = 1
HEADING = "trainer-core"


class WrongError(Exception):
    """What the user gave cannot be used; the text says what to do. Exit code 2."""


class Card:
    """What a core was made from, and where the numbers that a run needs stand in its state."""

    def __init__(self, text: str) -> None:
        """Read the card; WrongError if it is of another format."""
        heading, _, rest = text.partition("\n")
        name, _, number = heading.partition(" ")
        if name != HEADING or number != str(FORMAT):
            raise WrongError(
                f"its card is of format {number or 'none'}, this trainer reads {FORMAT}: "
                "export again"
            )
        values = {}
        self.orders = []
        for line in rest.splitlines():
            key, _, value = line.partition(" ")
            if key == "order":
                self.orders.append(value)
            else:
                values[key] = value
        self.version = values["version"]
        self.core = values["core"]
        self.boat = values["boat"]
        self.computed = values["computed"]
        self.cpu = values["cpu"]
        self.needs = values["needs"].split()
        self.step = float.fromhex(values["step"])  # [s]
        self.places = int(values["places"])  # [-] numbers in a state
        self.work = int(values["work"])  # [-] numbers in a work space
        self.watched = values["watched"].split()
        pairs = (item.split("=") for item in values["columns"].split())
        self.columns = {name: int(place) for name, place in pairs}  # of the state; t is its step's
