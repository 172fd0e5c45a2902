"""The instructor's state at a glance: the boat, her surfaces, tanks, air, the sea, casualties."""

from trainer.screen.drawing.wording import NONE, attitude, bell, course, number, surface
from trainer.screen.ink import Line, Lines, fit, line
from trainer.screen.sight import Sight

LEFT = 27  # [columns] of what she does; the rest is what she is told to
BALLAST = (("forward", "F"), ("mid", "M"), ("aft", "A"), ("negative", "neg"))
TRIM = (
    ("trim_forward", "trim F"),
    ("trim_aft", "A"),
    ("auxiliary", "aux"),
    ("depth_control", "depth-ctl"),
)
APART = 0.5  # [m, deg, kn] from which a gauge is said to be wrong


def state(sight: Sight, width: int, _height: int) -> Lines:
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


def low(sight: Sight) -> Lines:
    """Return tanks, air, the sea and casualties, a line each."""
    return [tanks(sight), air(sight), sea(sight), broken(sight)]


def moved(sight: Sight, name: str) -> float | None:
    """Return a value of the gauges' channel where it is now."""
    return sight.picture.smooth(sight.gauges, name, sight.clock())


def pair(label: str, actual: str, ordered: str, unit: str) -> Line:
    """Return a value and what is ordered."""
    told = ("", "plain") if ordered == NONE else (f" > {ordered}", "ordered")
    return line((f" {label:<7}", "dim"), (f"{actual:>6}", "value"), told, (f" {unit}", "dim"))


def false(sight: Sight, name: str, decimals: int = 1) -> str:
    """Return what a gauge shows, "" where that is the truth."""
    shown, true = sight.picture.number("gauges", name), sight.picture.number("motion", name)
    if shown is None or true is None:
        return ""
    apart = abs(shown - true)
    apart = min(apart, 360.0 - apart) if name == "heading" else apart
    return f" gauge {number(shown, decimals)}" if apart > APART else ""


def depth(sight: Sight) -> Line:
    """Return depth and ordered depth, and what the gauge says if that is another."""
    ordered = number(sight.picture.number("diving", "ordered_depth"))
    wrong = false(sight, "depth")
    shown = pair("depth", number(moved(sight, "depth")), ordered, "" if wrong else "m")
    return (*shown, (wrong.lstrip(), "warning"))


def heading(sight: Sight) -> Line:
    """Return heading and ordered course."""
    ordered = course(sight.picture.number("steering", "ordered_course"))
    wrong = false(sight, "heading", 0)
    return (*pair("course", course(moved(sight, "heading"), 1), ordered, ""), (wrong, "warning"))


def speed(sight: Sight) -> Line:
    """Return speed and ordered speed."""
    ordered = number(sight.picture.number("engine", "ordered_speed"))
    wrong = false(sight, "speed")
    shown = pair("speed", number(moved(sight, "speed")), ordered, "" if wrong else "kn")
    return (*shown, (wrong.lstrip(), "warning"))


def pitch(sight: Sight) -> Line:
    """Return the pitch in words."""
    return line(
        (" pitch  ", "dim"), (f"{attitude(moved(sight, 'pitch'), 'up', 'down'):>9}", "value")
    )


def heel(sight: Sight) -> Line:
    """Return the heel in words."""
    value = attitude(moved(sight, "heel"), "stbd", "port")
    return line((" heel   ", "dim"), (f"{value:>9}", "value"))


def plane(sight: Sight, name: str, channel: str) -> Line:
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


def engine(sight: Sight) -> Line:
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


def weight(sight: Sight) -> Line:
    """Return how heavy or light she is."""
    heavy = sight.picture.number("motion", "heavy")
    if heavy is None:
        return line(("weight ", "dim"), NONE)
    side = "" if abs(heavy) < 0.05 else (" t heavy" if heavy > 0.0 else " t light")
    return line(("weight ", "dim"), (f"{abs(heavy):.1f}{side or ' t, in trim'}", "value"))


def tanks(sight: Sight) -> Line:
    """Return how full the tanks are [%]."""
    if sight.picture.number("tanks", "auxiliary") is None:
        return line((" tanks  ", "dim"), "this boat has none")
    parts = [(" tanks  ", "dim"), ("main ", "dim")]
    for name, says in BALLAST:
        parts += [(f"{says} ", "dim"), (f"{full(sight, name)} ", "plain")]
    for name, says in TRIM:
        parts += [(f" {says} ", "dim"), (full(sight, name), "plain")]
    return line(*parts, (" %", "dim"))


def full(sight: Sight, tank: str) -> str:
    """Return how full a tank is [%]."""
    return number(sight.picture.number("tanks", f"{tank}_full"), 0)


def air(sight: Sight) -> Line:
    """Return the pressures of the banks and what blows."""
    picture = sight.picture
    if not picture.word("air", "main"):
        return line((" air    ", "dim"), "this boat has none")
    main, reserve = picture.number("air", "main"), picture.number("air", "emergency")
    blown = [
        name.removeprefix("blow_")
        for name in picture.rows("valves", "blow_")
        if picture.word("valves", name) != "shut"
    ]
    return line(
        (" air    ", "dim"),
        (f"main {number(main)} MPa  emergency {number(reserve)} MPa", "plain"),
        (f"  compressor {picture.word('air', 'compressor')}", "dim"),
        (f"  BLOWING {' '.join(blown)}" if blown else "", "warning"),
    )


def sea(sight: Sight) -> Line:
    """Return the sea, and the one it is becoming."""
    now, then = swell(sight, ""), swell(sight, "ordered_")
    told = "" if now == then else f" > {then}"
    return line((" sea    ", "dim"), (now, "plain"), (told, "ordered"))


def swell(sight: Sight, which: str) -> str:
    """Return a sea in words."""
    height, period, origin = (
        sight.picture.number("sea", f"{which}{name}") for name in ("height", "period", "from")
    )
    if not height:
        return "calm"
    return f"{height:.1f} m, {number(period, 0)} s, from {course(origin)}"


def broken(sight: Sight) -> Line:
    """Return the names of the casualties."""
    slots = [name for name in sight.picture.rows("casualties", "casualty_") if name[-1].isdigit()]
    names = [sight.picture.word("casualties", name) for name in slots]
    if not names:
        return line((" broken ", "dim"), ("nothing; F4 lists what can be", "plain"))
    return line((" broken ", "dim"), (f" {', '.join(names)} ", "alarm"))
