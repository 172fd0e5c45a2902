"""Ships on the screens: those near, on the instructor's, and what the periscope shows."""

from helpers.screens import at_the_console, seen, tape
from textual.pilot import Pilot

from trainer.console.app import Console
from trainer.io.orders import sentences
from trainer.io.orders.grammar import Refused
from trainer.session.stations.channels import CHANNELS

WIDE = (170, 60)
FIELDS = [(field.name, field.unit) for field in CHANNELS["contacts"].fields]
FERRY = {
    "ships": "1",
    "contact_1": "ferry",
    "contact_1_type": "ferry",
    "contact_1_bearing": "45.2",
    "contact_1_range": "2310",
    "contact_1_course": "270.0",
    "contact_1_speed": "12.0",
    "contact_1_cpa": "410",
    "contact_1_tcpa": "188",
}


def test_a_ship_near_is_listed_with_its_closest_approach() -> None:
    talk = tape("instructor")
    talk.say(sentences.names("contacts", FIELDS))
    row = [FERRY.get(name, "") for name, _ in FIELDS]
    talk.say(sentences.state("contacts", 121, 60.5, row))

    async def look(pilot: Pilot[Refused], app: Console) -> None:
        await seen(pilot, app, " ferry     045   2310 270 12   410  188")

    at_the_console(look, talk, "instructor", WIDE)


def test_the_periscope_tells_its_bearing_as_a_course_and_what_is_in_the_view() -> None:
    talk = tape("scope")
    fields = [(field.name, field.unit) for field in CHANNELS["scope"].fields]
    shown = {"bearing": "359.7", "train": "4.0", "power": "6.0", "sighted": "tanker 001"}
    talk.say(sentences.names("scope", fields))
    talk.say(sentences.state("scope", 121, 60.5, [shown.get(name, "") for name, _ in fields]))

    async def look(pilot: Pilot[Refused], app: Console) -> None:
        await seen(pilot, app, "bearing 000  off the bow 4.0 deg  power 6.0 x")
        await seen(pilot, app, "in the view: tanker 001")

    at_the_console(look, talk, "scope", (100, 30))
