"""A console attached to the session: lines in, lines out, whatever the port."""

import math
import textwrap
from dataclasses import dataclass

import numpy as np

from trainer import casualty
from trainer.boat import Boat
from trainer.core.tanks import COMPARTMENTS, TANKS
from trainer.fitout import KNOT
from trainer.io.lines import Overlong
from trainer.io.outbox import Inbox, Sender
from trainer.io.teletype import View, course, header, state_line
from trainer.ledger import Summary
from trainer.sea_orders import sea_text

WIDTH = 79  # [characters]
HEADING_EVERY = 20  # [lines]


VIEWED = (
    *("t", "z", "psi", "u", "theta", "phi", "delta_r", "delta_s", "delta_b", "u_c"),
    *("ordered_depth", "ordered_psi", "rudder_by_hand", "stern_by_hand", "bow_by_hand"),
)


def view(boat: Boat, *, frozen: bool) -> View:
    """Return what a console shows of the boat, in display units."""
    now = dict(zip(VIEWED, boat.numbers(VIEWED), strict=True))
    planes_by_hand = now["stern_by_hand"] and now["bow_by_hand"]
    return View(
        time_s=now["t"],
        depth_m=now["z"],
        course_deg=math.degrees(now["psi"]) % 360.0,
        speed_kn=now["u"] / KNOT,
        pitch_deg=math.degrees(now["theta"]),
        heel_deg=math.degrees(now["phi"]),
        rudder_deg=math.degrees(now["delta_r"]) * boat.toward["rudder"],
        stern_deg=math.degrees(now["delta_s"]) * boat.toward["stern"],
        bow_deg=math.degrees(now["delta_b"]) * boat.toward["bow"],
        rpm=now["u_c"] * boat.file.propulsion.rps_per_mps * 60.0,
        ordered_depth_m=None if planes_by_hand else now["ordered_depth"],
        ordered_course_deg=(
            None if now["rudder_by_hand"] else math.degrees(now["ordered_psi"]) % 360.0
        ),
        frozen=frozen,
        rudder_manual=bool(now["rudder_by_hand"]),
        stern_manual=bool(now["stern_by_hand"]),
        bow_manual=bool(now["bow_by_hand"]),
    )


def status_lines(boat: Boat, ledger: Summary) -> list[str]:
    """Return everything about the boat, for the order ``status``."""
    s = boat.state
    seen = view(boat, frozen=False)
    method = boat.method

    def mode(by_hand: float) -> str:
        return "by hand" if by_hand else "automatic"

    turns = f"{seen.rpm:.1f} rpm, turns for {float(s.u_c) / KNOT:.1f} kn"
    return [
        boat.file.name,
        (
            f"{method.equations} set, {method.rates} rates, {method.integrator}, "
            f"step {method.step:g} s, tick {int(s.tick)}"
        ),
        (
            f"depth   {seen.depth_m:8.2f} m   ordered {s.ordered_depth:.1f}   "
            f"rate {s.zdot:+.2f} m/s down"
        ),
        (
            f"course  {course(seen.course_deg, 2):>8}     "
            f"ordered {course(math.degrees(s.ordered_psi), 1)}   "
            f"rate {math.degrees(s.psidot):+.2f} deg/s"
        ),
        (
            f"speed   {seen.speed_kn:8.2f} kn  ordered {s.ordered_speed / KNOT:.1f}   {turns}, "
            f"{mode(s.speed_by_hand)}"
        ),
        f"pitch {seen.pitch_deg:+.2f}   heel {seen.heel_deg:+.2f} degrees",
        (
            f"stern planes {seen.stern_deg:+.2f} {mode(s.stern_by_hand)}, "
            f"bow planes {seen.bow_deg:+.2f} {mode(s.bow_by_hand)} (rise +)"
        ),
        f"rudder {seen.rudder_deg:+.2f} {mode(s.rudder_by_hand)} (right +)",
        f"position {s.x:.0f} m north, {s.y:.0f} m east of the start",
        *sea_lines(boat),
        *(ballast_lines(boat) if boat.vessel.fitted else ()),
        *casualty_lines(boat),
        ledger_line(ledger),
    ]


def ledger_line(ledger: Summary) -> str:
    """Return how the ticks have been kept."""
    return (
        f"ticks {ledger.ticks}, duty cycle {100 * ledger.duty_cycle:.3f} %, "
        f"overruns {ledger.overruns}, gaps {ledger.gaps}"
    )


def casualty_lines(boat: Boat) -> list[str]:
    """Return what a station's instruments show, and the casualties there are."""
    shown = casualty.readings(boat)
    instruments = (
        f"instruments: depth {shown.depth:.1f} m, "
        f"course {course(math.degrees(shown.heading), 1)}, log {shown.speed / KNOT:.1f} kn"
    )
    kinds = ", ".join(f"{each.kind} {each.amount:.3g}" for each in casualty.active(boat))
    if not kinds:
        return [instruments]
    return [instruments, *textwrap.wrap(f"casualties: {kinds}", WIDTH, subsequent_indent="  ")]


def sea_lines(boat: Boat) -> list[str]:
    """Return the sea in force, and the one ordered if it is another."""
    s = boat.state
    coming = [f"sea ordered {sea_text(s.sea_target)}, in {s.sea_ramp:.0f} s"]
    return [f"sea {sea_text(s.sea)}", *(coming if s.sea_ramp > 0.0 else [])]


def ballast_lines(boat: Boat) -> list[str]:
    """Return what is aboard as water and air."""
    s, c = boat.state, boat.vessel
    tonnes = dict(zip(TANKS, s.water / 1000.0, strict=True))
    with np.errstate(all="ignore"):  # a bank or a tank that the boat lacks
        filled = np.nan_to_num(100.0 * s.water / c.capacity)
        pressure = np.nan_to_num(s.bank * c.gas / c.bank_volume) / 1e6
    weight = float(s.weight - c.buoyancy) / float(c.g) / 1000.0
    working = [name for name in ("hover", "compressor") if s[name]]
    lines = [
        (
            f"main ballast forward {filled[0]:.0f}, mid {filled[1]:.0f}, "
            f"aft {filled[2]:.0f}, negative {filled[3]:.0f} %; weight {weight:+.1f} t"
        ),
        (
            f"trim forward {tonnes['trim_forward']:.1f}, aft {tonnes['trim_aft']:.1f}, "
            f"auxiliary {tonnes['auxiliary']:.1f}, depth control {tonnes['depth_control']:.1f} t"
        ),
        (
            f"air banks main {pressure[0]:.1f}, emergency {pressure[1]:.1f} MPa"
            f"{'; on: ' + ', '.join(working) if working else ''}"
        ),
    ]
    flooded = [
        f"{name.removeprefix('compartment_')} {tonnes[name]:.1f} t"
        for name in COMPARTMENTS
        if tonnes[name] > 0.0
    ]
    return [*lines, f"flooded {', '.join(flooded)}"] if flooded else lines


@dataclass
class Console:
    """One teletype: what it types, what it is told, and when the headings are due again."""

    inbox: Inbox | None
    sender: Sender
    lines_since_heading: int = HEADING_EVERY

    def typed(self) -> list[str | Overlong]:
        """Return the lines that have arrived."""
        return self.inbox.take() if self.inbox else []

    @property
    def silent(self) -> bool:
        """Return whether nothing can come from here any more."""
        return self.inbox is None or self.inbox.ended

    def say(self, *lines: str) -> None:
        """Tell the operator something."""
        for line in lines:
            self.sender.send(line)

    def show(self, boat: Boat, *, frozen: bool) -> None:
        """Print the line of state, under headings every so often."""
        if self.lines_since_heading >= HEADING_EVERY:
            self.sender.send(header())
            self.lines_since_heading = 0
        self.sender.send(state_line(view(boat, frozen=frozen)))
        self.lines_since_heading += 1
