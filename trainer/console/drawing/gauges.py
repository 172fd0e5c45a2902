"""The instructor's state at a glance: the boat, her surfaces, tanks, air, the sea, casualties."""

from trainer.console.drawing.values import NONE, attitude, bell, course, number, surface, without
from trainer.console.model import SessionModel
from trainer.console.pane import Line, Lines, fit, line

LEFT = 27  # [columns] of what she does; the rest is what she is told to
TANKS = (
    ("main", ("forward", "mid", "aft")),
    ("neg", ("negative",)),
    ("trim", ("trim_forward", "trim_aft")),
    ("aux", ("auxiliary",)),
    ("dc", ("depth_control",)),
)
APART = 0.5  # [m, deg, kn] from which a gauge is said to be wrong


def state(sight: SessionModel, width: int, _height: int) -> Lines:
    """Return the state in nine lines."""
    rows = [
        (depth(sight), plane(sight, "rudder", "steering")),
        (heading(sight), plane(sight, "stern", "diving")),
        (speed(sight), plane(sight, "bow", "diving")),
        (pitch(sight), engine(sight)),
        (heel(sight), weight(sight)),
    ]
    lines = [(*fit(left, LEFT), *right) for left, right in rows]
    return [*(fit(each, width) for each in (*lines, *low(sight)))]


def low(sight: SessionModel) -> Lines:
    """Return tanks, air, the sea and casualties, a line each."""
    return [tanks(sight), air(sight), sea(sight), broken(sight)]


def moved(sight: SessionModel, name: str) -> float | None:
    """Return a value of the gauges' channel where it is now."""
    return sight.picture.smooth(sight.gauges, name, sight.clock())


def pair(label: str, actual: str, ordered: str, unit: str) -> Line:
    """Return a value and what is ordered."""
    told = ("", "plain") if ordered == NONE else (f" > {ordered}", "ordered")
    return line((f" {label:<7}", "dim"), (f"{actual:>6}", "value"), told, (f" {unit}", "dim"))


def false(sight: SessionModel, name: str) -> str:
    """Return what a gauge shows, "" where that is the truth."""
    shown, true = sight.picture.number("gauges", name), sight.picture.number("motion", name)
    if shown is None or true is None:
        return ""
    apart = abs(shown - true)
    apart = min(apart, 360.0 - apart) if name == "heading" else apart
    return f"  GAUGE {number(shown)}" if apart > APART else ""


def depth(sight: SessionModel) -> Line:
    """Return depth and ordered depth."""
    ordered = number(sight.picture.number("diving", "ordered_depth"))
    told = pair("depth", number(moved(sight, "depth")), ordered, "m")
    return misread(sight, "depth", told)


def heading(sight: SessionModel) -> Line:
    """Return heading and ordered course."""
    ordered = course(sight.picture.number("steering", "ordered_course"))
    told = pair("course", course(moved(sight, "heading"), 1), ordered, "")
    return misread(sight, "heading", told)


def speed(sight: SessionModel) -> Line:
    """Return speed and ordered speed."""
    ordered = number(sight.picture.number("engine", "ordered_speed"))
    told = pair("speed", number(moved(sight, "speed")), ordered, "kn")
    return misread(sight, "speed", told)


def misread(sight: SessionModel, name: str, told: Line) -> Line:
    """Return a value with what the crew's gauge shows in place of the order, if that is false."""
    wrong = false(sight, name)
    return (*told[:2], (wrong, "warning")) if wrong else told


def pitch(sight: SessionModel) -> Line:
    """Return the pitch in words."""
    return line(
        (" pitch  ", "dim"), (f"{attitude(moved(sight, 'pitch'), 'up', 'down'):>9}", "value")
    )


def heel(sight: SessionModel) -> Line:
    """Return the heel in words."""
    value = attitude(moved(sight, "heel"), "stbd", "port")
    return line((" heel   ", "dim"), (f"{value:>9}", "value"))


def plane(sight: SessionModel, name: str, channel: str) -> Line:
    """Return a surface, what it is told, and by whom."""
    picture = sight.picture
    actual = picture.smooth(channel, name, sight.clock())
    ordered = surface(name, picture.number(channel, f"ordered_{name}"))
    mode = picture.word(channel, f"{name}_mode") if actual is not None else "none"
    return line(
        (f"{name:<7}", "dim"),
        (surface(name, actual), "value"),
        (f" > {ordered}", "ordered"),
        (f" {mode}", "warning" if mode == "hand" else "dim"),
    )


def engine(sight: SessionModel) -> Line:
    """Return bell, or that speed is kept, and revolutions."""
    picture = sight.picture
    rung = bell(picture.word("engine", "bell"))
    kept = "auto" if picture.word("engine", "speed_mode") == "auto" else "turns"
    rpm, ordered = (picture.number("engine", name) for name in ("rpm", "ordered_rpm"))
    return line(
        ("bell   ", "dim"),
        (rung or kept, "value"),
        ("  rpm ", "dim"),
        (number(rpm, 0), "value"),
        (f" > {number(ordered, 0)}", "ordered"),
    )


def weight(sight: SessionModel) -> Line:
    """Return how heavy or light she is."""
    heavy = sight.picture.number("motion", "heavy")
    if heavy is None:
        return line(("weight ", "dim"), NONE)
    side = "" if abs(heavy) < 0.05 else (" t heavy" if heavy > 0.0 else " t light")
    return line(("weight ", "dim"), (f"{abs(heavy):.1f}{side or ' t, in trim'}", "value"))


def tanks(sight: SessionModel) -> Line:
    """Return how full the tanks are [%]."""
    if sight.picture.number("tanks", "auxiliary") is None:
        return line((" tanks  ", "dim"), without(sight.picture, "tanks", "this boat has none"))
    parts = [(" tanks ", "dim")]
    for says, names in TANKS:
        shares = "/".join(full(sight, name) for name in names)
        parts += [(f" {says} ", "dim"), (shares, "plain")]
    return line(*parts, (" %", "dim"))


def full(sight: SessionModel, tank: str) -> str:
    """Return how full a tank is [%]."""
    return number(sight.picture.number("tanks", f"{tank}_full"), 0)


def air(sight: SessionModel) -> Line:
    """Return the pressures of the banks and what blows."""
    picture = sight.picture
    if not picture.word("air", "main"):
        return line((" air    ", "dim"), without(picture, "air", "this boat has none"))
    main, reserve = picture.number("air", "main"), picture.number("air", "emergency")
    blown = [
        name.removeprefix("blow_")
        for name in picture.rows("valves", "blow_")
        if picture.word("valves", name) != "shut"
    ]
    return line(
        (" air    ", "dim"),
        (f"main {number(main)}  emergency {number(reserve)} MPa", "plain"),
        (f"  BLOWING {' '.join(blown)}", "warning")
        if blown
        else (f"  compressor {picture.word('air', 'compressor')}", "dim"),
    )


def sea(sight: SessionModel) -> Line:
    """Return the sea, and the one it is becoming."""
    now, then = swell(sight, ""), swell(sight, "ordered_")
    told = "" if now == then else f" > {then}"
    return line((" sea    ", "dim"), (now, "plain"), (told, "ordered"))


def swell(sight: SessionModel, which: str) -> str:
    """Return a sea in words."""
    height, period, origin = (
        sight.picture.number("sea", f"{which}{name}") for name in ("height", "period", "from")
    )
    if not height:
        return without(sight.picture, "sea", "calm")
    return f"{height:.1f} m, {number(period, 0)} s, from {course(origin)}"


def broken(sight: SessionModel) -> Line:
    """Return the names of the casualties."""
    slots = [name for name in sight.picture.rows("casualties", "casualty_") if name[-1].isdigit()]
    names = [sight.picture.word("casualties", name) for name in slots]
    if not names:
        told = without(sight.picture, "casualties", "nothing; F4 lists what can be")
        return line((" broken ", "dim"), (told, "plain"))
    return line((" broken ", "dim"), (f" {', '.join(names)} ", "alarm"))
