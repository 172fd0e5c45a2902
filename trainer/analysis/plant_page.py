"""What feeds what in a boat's plant, as text and as a picture.

It is made from the vessel file; ``cli/workshop/vessel`` prints and writes it. A feed is a row of
both: a source, what it feeds, and what stands beside it, so that nothing can be in one alone.
"""

from collections.abc import Iterator
from typing import Final, NamedTuple

from trainer.config.boat.plant_records import EMERGENCY_MODE, NORMAL_MODE, Plant
from trainer.config.boat.vessel import VesselFile
from trainer.config.files import ConfigError
from trainer.core.plant.parts import BUS_NAMES
from trainer.core.surfaces import SURFACES
from trainer.report.svg import rect, rule, svg_element, text
from trainer.report.text import wrap

SURFACE_WORDS: Final = {"rudder": "rudder", "stern": "stern planes", "bow": "bow planes"}
CONSUMER_WORDS: Final = {
    "hydraulic_1": "oil pump 1",
    "hydraulic_2": "oil pump 2",
    "hydraulic_vital": "vital oil pump",
    "trim": "trim pump",
    "drain": "drain pump",
    "depth_control": "depth-control pump",
    "sounder": "echo sounder",
    "propulsion": "propulsion's control",
}
HAND_WORDS: Final = "two persons"
BATTERY_WORD: Final = "battery"
ROW_PX, TOP_PX = 21.0, 50.0  # [px] between rows; of the first
COLUMN_PX: Final = (20.0, 150.0, 330.0, 570.0, 770.0)  # [px] their left edges
BOX_PX: Final = (70.0, 110.0, 160.0, 100.0, 110.0)  # [px] their widths
BOX_HEIGHT_PX: Final = 17.0  # [px]
PICTURE_STYLE: Final = (
    "<style>.sheet{fill:#fff}.box{fill:#eef3f7;stroke:#5f6e79}.feed{stroke:#0a5ca8}"
    ".spare{stroke:#8f4200;stroke-dasharray:5 3}"
    "text{font:12px sans-serif;fill:#0d1418}.head{font-weight:600}</style>"
)


class PlantFeed(NamedTuple):
    """What feeds what; ``note`` has the figures, ``is_spare`` is a feed that stands by."""

    source: str
    fed: str
    note: str
    is_spare: bool = False


def named(consumer: str) -> str:
    """Return a consumer in words."""
    return CONSUMER_WORDS.get(consumer, consumer)


def own_plant(file: VesselFile) -> Plant:
    """Return the plant of a vessel file; ConfigError if it has none."""
    if file.plant is None:
        raise ConfigError(
            f"{file.path}: this boat has no plant: add the table [plant] (docs/plant-keys.md), "
            "or name a boat with one, such as bb2"
        )
    return file.plant


def bus_feeds(plant: Plant) -> Iterator[PlantFeed]:
    """Yield what the battery and the buses feed, the small consumers of a bus together."""
    for bus in BUS_NAMES:
        by = "straight" if bus == "dc" else f"breaker, {plant.battery.bus_limit_w / 1e3:g} kW"
        yield PlantFeed(BATTERY_WORD, f"{bus} bus", by)
    yield PlantFeed("port bus", "starboard bus", "tie, either way", is_spare=True)
    for bus in BUS_NAMES:
        for row in plant.consumers:
            if bus in row.buses:
                note = f"{row.power_w / 1e3:g} kW"
                yield PlantFeed(f"{bus} bus", named(row.name), note, row.buses[0] != bus)
        for hotel in plant.hotel:
            if hotel.bus == bus:
                note = f"{hotel.power_w / 1e3:g} kW, {hotel.shed_w / 1e3:g} shed"
                yield PlantFeed(f"{bus} bus", f"{bus} hotel loads", note)


def oil_feeds(file: VesselFile, plant: Plant) -> Iterator[PlantFeed]:
    """Yield what the pumps of oil feed, and what moves each surface."""
    for pump in plant.pumps:
        system = "vital oil" if pump.name == "vital" else "main oil"
        note = f"{pump.rate_l_s:g} L/s below {pump.start_mpa:g} MPa"
        yield PlantFeed(named(f"hydraulic_{pump.name}"), system, note)
    surfaces = plant.surfaces
    notes = {
        NORMAL_MODE: ("main oil", "normal"),
        EMERGENCY_MODE: ("vital oil", f"emergency, {surfaces.emergency_share:.2g} of the rate"),
    }
    hand = (HAND_WORDS, f"hand, {surfaces.hand_deg_s:g} deg/s, after {surfaces.man_s:g} s")
    for name in SURFACES:
        if name == "bow" and not file.surfaces.bow_plane_limit_deg:
            continue
        for mode in surfaces.modes:
            source, note = notes.get(mode, hand)
            yield PlantFeed(source, SURFACE_WORDS[name], note, mode != NORMAL_MODE)


def fire_lines(plant: Plant) -> Iterator[str]:
    """Yield what a fire in each compartment takes away, and after how long."""
    for place in plant.compartments:
        burning = [row for row in plant.burning if row.compartment == place.name]
        taken = [
            f"{named(row.name)}{' bus' if row.name in BUS_NAMES else ''} {row.dose_s:g} s"
            for row in burning
        ]
        bus = f"fought well with the {place.bus} bus dead" if place.bus else "no bus of its own"
        yield f"{place.name}: {bus}; takes {', '.join(taken) or 'nothing'}"


def feed_page(file: VesselFile) -> str:
    """Return what feeds what in words; ConfigError if the boat has no plant."""
    plant = own_plant(file)
    feeds = [*bus_feeds(plant), *oil_feeds(file, plant)]
    sources: dict[str, list[str]] = {}
    for each in feeds:
        spare = ", standing by" if each.is_spare else ""
        sources.setdefault(each.source, []).append(f"{each.fed} ({each.note}{spare})")
    fed = [
        line
        for source, all_fed in sources.items()
        for line in wrap(f"{source}: {', '.join(all_fed)}")
    ]
    fire = [line for each in fire_lines(plant) for line in wrap(each)]
    heading = f"What feeds what: {file.name}"
    return "\n".join([heading, "", *fed, "", "Fire, by compartment:", *fire])


def draw_feeds(file: VesselFile) -> str:
    """Return the picture of it as SVG; ConfigError if the boat has no plant."""
    plant = own_plant(file)
    feeds = [*bus_feeds(plant), *oil_feeds(file, plant)]
    places = box_places(feeds)
    parts = [PICTURE_STYLE]
    height = max(y for _, y, _ in places.values()) + 2 * ROW_PX
    parts.append(rect("sheet", 0.0, 0.0, COLUMN_PX[-1] + BOX_PX[-1] + 20.0, height))
    parts.append(text("head", COLUMN_PX[0], 24.0, f"{file.name}: what feeds what"))
    parts += [feed_line(each, places) for each in feeds]
    for name, (x, y, width) in places.items():
        parts.append(rect("box", x, y - BOX_HEIGHT_PX / 2.0, width, BOX_HEIGHT_PX))
        parts.append(text("name", x + 6.0, y + 4.0, name))
    size = (COLUMN_PX[-1] + BOX_PX[-1] + 20.0, height)
    drawn = str(svg_element(f"What feeds what in {file.name}", size, parts))
    return drawn.replace("<svg ", '<svg xmlns="http://www.w3.org/2000/svg" ', 1)


def box_places(feeds: list[PlantFeed]) -> dict[str, tuple[float, float, float]]:
    """Return where each box stands: its left edge, its middle's height, its width [px]."""
    buses = [f"{bus} bus" for bus in BUS_NAMES]
    fed = [each.fed for each in feeds if each.source in buses and each.fed not in buses]
    oil = ["main oil", "vital oil", HAND_WORDS]
    moved = [each.fed for each in feeds if each.source in oil]
    columns = ([BATTERY_WORD], buses, [*dict.fromkeys(fed)], oil, [*dict.fromkeys(moved)])
    rows = max(len(names) for names in columns)
    return {
        name: (x, TOP_PX + (at + 0.5) * ROW_PX * rows / len(names), width)
        for names, x, width in zip(columns, COLUMN_PX, BOX_PX, strict=True)
        for at, name in enumerate(names)
    }


def feed_line(feed: PlantFeed, places: dict[str, tuple[float, float, float]]) -> str:
    """Return the line of a feed, from edge to edge."""
    x, y, width = places[feed.source]
    to_x, to_y, to_width = places[feed.fed]
    style = "spare" if feed.is_spare else "feed"
    if x == to_x:
        return rule(style, x + width, y, to_x + to_width, to_y)
    return rule(style, x + width, y, to_x, to_y)
