"""The hull and its panels as numbers: sections, the equal spheroid, places, areas.

``coefficients`` computes with them, and ``page`` draws them. [LAMB] Lamb, Hydrodynamics, art. 114,
with Imlay 1961: added masses of a spheroid. x is counted aft from the nose, X forward from the
centre of gravity, as Report 2510 has it.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Final

import numpy as np

from trainer.config.boat.hull import HullFile, HullForm, Panels
from trainer.core.kernel import Numbers

STATION_COUNT: Final = 801  # along the hull, on every machine
NOSE_BREADTHS, TAIL_BREADTHS = 1.5, 3.0  # [-] usual lengths in breadths; own estimate
SECTION_FULLNESS: Final = {"ellipse": 1.0, "box": 1.15}
NEAR_STERN: Final = 0.75  # [-] of the length: surfaces aft of it work in the wake
ROOT_CHORD_SHARE: Final = 0.6  # [-] of the root chord: where the hull's radius is that of the root


def integral(values: Numbers, at: Numbers) -> float:
    """Return the integral of ``values`` over ``at``, by trapezoids."""
    return float(np.sum(0.5 * (values[1:] + values[:-1]) * np.diff(at)))


def smooth(x: Numbers, y: Numbers, at: Numbers) -> Numbers:
    """Return ``y`` between its points by cubics that never overshoot (Fritsch and Carlson)."""
    h, rise = np.diff(x), np.diff(y) / np.diff(x)
    slope = np.zeros_like(y)
    before, after = rise[:-1], rise[1:]
    rising = before * after > 0.0
    w1, w2 = 2.0 * h[1:] + h[:-1], h[1:] + 2.0 * h[:-1]
    safe = np.where(rising, before, 1.0), np.where(rising, after, 1.0)
    slope[1:-1] = np.where(rising, (w1 + w2) / (w1 / safe[0] + w2 / safe[1]), 0.0)
    slope[0] = _end_slope(h[0], h[1], rise[0], rise[1])
    slope[-1] = _end_slope(h[-1], h[-2], rise[-1], rise[-2])
    i = np.clip(np.searchsorted(x, at, side="right") - 1, 0, len(h) - 1)
    t = np.clip((at - x[i]) / h[i], 0.0, 1.0)
    up = t * t * (3.0 - 2.0 * t)
    first, last = t * (1.0 - t) ** 2, t * t * (1.0 - t)
    return np.asarray(
        y[i] * (1.0 - up) + y[i + 1] * up + h[i] * (slope[i] * first - slope[i + 1] * last)
    )


def _end_slope(near: float, far: float, rise: float, further: float) -> float:
    """Return the slope at an end of such a curve."""
    slope = ((2.0 * near + far) * rise - near * further) / (near + far)
    if slope * rise <= 0.0:
        return 0.0
    return 3.0 * rise if rise * further <= 0.0 and abs(slope) > 3.0 * abs(rise) else slope


def profile(form: HullForm, x: Numbers) -> Numbers:
    """Return breadth over the greatest breadth [-] of a hull of nose, middle and tail."""
    breadth = form.breadth or 0.0
    nose = form.nose_length or NOSE_BREADTHS * breadth
    tail = form.tail_length or TAIL_BREADTHS * breadth
    ahead = np.clip((x - nose) / nose, -1.0, 0.0)
    t = np.clip((x - (form.length - tail)) / tail, 0.0, 1.0)
    base = form.base_diameter / breadth
    if form.tail == "myring":
        whole = tail + (form.tail_cut or 0.0)
        tangent = 2.0 * whole * math.tan(math.radians(form.tail_half_angle_deg or 0.0)) / breadth
        t = t * tail / whole
        aft = 1.0 - (3.0 - tangent) * t**2 + (2.0 - tangent) * t**3
    else:
        aft = 1.0 - (1.0 - base) * t ** (form.tail_exponent if form.tail == "parabola" else 1.0)
    return np.asarray((1.0 - ahead**2) ** (1.0 / form.nose_exponent) * np.maximum(aft, 0.0))


@dataclass(frozen=True)
class Spheroid:
    """The spheroid of equal volume and length: factors of added mass [-]."""

    k1: float  # along
    k2: float  # across
    k3: float  # strips of a turning hull, over the strip's own

    @classmethod
    def of(cls, slenderness: float) -> "Spheroid":
        """Return the factors by diameter over length [-]; [LAMB]. A sphere has e = 0."""
        if slenderness > 1.0 - 1e-6:
            return cls(0.5, 0.5, 0.0)
        e2 = 1.0 - slenderness**2
        e = math.sqrt(e2)
        if e < 0.05:  # series: the terms below cancel
            alpha, beta = 2.0 / 3.0 - 4.0 * e2 / 15.0, 2.0 / 3.0 + 2.0 * e2 / 15.0
        else:
            logarithm = math.log((1.0 + e) / (1.0 - e))
            alpha = 2.0 * (1.0 - e2) / e**3 * (0.5 * logarithm - e)
            beta = 1.0 / e2 - (1.0 - e2) * logarithm / (2.0 * e**3)
        lower = (2.0 - e2) * (2.0 * e2 - (2.0 - e2) * (beta - alpha))
        turning = e2 * e2 * (beta - alpha) / lower
        return cls(
            alpha / (2.0 - alpha), beta / (2.0 - beta), turning * (1.0 + slenderness * slenderness)
        )


@dataclass(frozen=True)
class Shape:
    """The bare hull along its length: 801 stations, SI."""

    length: float  # [m] over all
    ell: float  # [m] reference length L
    x: Numbers  # [m] aft of the nose
    breadth: Numbers
    height: Numbers
    centre: Numbers  # [m] of the section, above the axis
    fullness: float  # [-] area over that of the ellipse
    boxy: bool
    x_G: float  # [m] aft of the nose

    @cached_property
    def area(self) -> Numbers:
        """Return the areas of the sections [m2]."""
        return np.asarray(self.fullness * math.pi * self.breadth * self.height / 4.0)

    @cached_property
    def X(self) -> Numbers:
        """Return the places [m] of the sections ahead of the centre of gravity."""
        return np.asarray(self.x_G - self.x)

    @cached_property
    def volume(self) -> float:
        """Return the displaced volume [m3]."""
        return integral(self.area, self.x)

    @cached_property
    def centroid(self) -> float:
        """Return the place [m] of the volume's centre aft of the nose."""
        return integral(self.area * self.x, self.x) / self.volume

    @cached_property
    def diameter(self) -> float:
        """Return the greatest root of breadth times height [m]."""
        return float(np.sqrt(self.breadth * self.height).max())

    @cached_property
    def spheroid(self) -> Spheroid:
        """Return the factors of the equal spheroid."""
        return Spheroid.of(math.sqrt(6.0 * self.volume / (math.pi * self.length)) / self.length)

    @cached_property
    def tail_centroid(self) -> float:
        """Return the centroid [m] of the area that the afterbody loses, aft of the nose."""
        aft = self.x >= 0.5 * self.length
        x, area = self.x[aft], self.area[aft]
        lost = np.diff(area)
        return float(np.sum(0.5 * (x[1:] + x[:-1]) * lost) / np.sum(lost))

    @cached_property
    def wetted(self) -> float:
        """Return the wetted surface [m2], by Ramanujan's girth of an ellipse."""
        a, b = self.breadth / 2.0, self.height / 2.0
        girth = math.pi * (3.0 * (a + b) - np.sqrt((3.0 * a + b) * (a + 3.0 * b)))
        out = np.sqrt(self.breadth * self.height) / 2.0
        slant = np.hypot(np.diff(self.x), np.diff(out))
        return float(np.sum(0.5 * (girth[1:] + girth[:-1]) * slant))

    def at(self, values: Numbers, x: float) -> float:
        """Return one of the hull's numbers at a place [m] aft of the nose."""
        return float(np.interp(x, self.x, values))


def shape_of(file: HullFile) -> Shape:
    """Return the bare hull of a file."""
    form = file.form
    x = np.linspace(0.0, form.length, STATION_COUNT)
    if form.stations:
        rows = np.array(form.stations)
        inside = (x >= rows[0, 0]) & (x <= rows[-1, 0])
        breadth, height = (np.where(inside, smooth(rows[:, 0], rows[:, k], x), 0.0) for k in (1, 2))
        centre = smooth(rows[:, 0], rows[:, 3], x)
    else:
        widest, share = form.breadth or 0.0, profile(form, x)
        breadth, height = widest * share, (form.height or widest) * share
        centre = np.zeros_like(x)
    fullness = form.section_fullness or SECTION_FULLNESS[form.section]
    bare = Shape(
        length=form.length,
        ell=file.length,
        x=x,
        breadth=breadth,
        height=height,
        centre=centre,
        fullness=fullness,
        boxy=form.section == "box",
        x_G=0.0,
    )
    x_G = bare.centroid if file.mass.cg_from_nose is None else file.mass.cg_from_nose
    return replace(bare, x_G=x_G)


@dataclass(frozen=True)
class Panel:
    """One panel: a plane, half a rudder, a sail. SI."""

    name: str
    control: str
    sail: bool
    angle: float  # [rad] 0 starboard, a quarter turn up
    root: float  # [m] radius
    tip: float
    leading: tuple[float, float]  # [m] aft of the nose, at root and tip
    chords: tuple[float, float]
    thickness: float
    axis_up: float
    share: float  # [-] of a whole moving panel's effect
    x_G: float
    aft: bool  # in the hull's wake

    @property
    def span(self) -> float:
        """Return the span [m] of one side."""
        return self.tip - self.root

    @property
    def chord(self) -> float:
        """Return the mean chord [m]."""
        return 0.5 * (self.chords[0] + self.chords[1])

    @property
    def area(self) -> float:
        """Return the area [m2]."""
        return self.span * self.chord

    @property
    def aspect(self) -> float:
        """Return the aspect ratio [-] of both sides joined."""
        return 2.0 * self.span**2 / self.area

    @property
    def normal(self) -> tuple[float, float]:
        """Return the shares [-] of sway and heave in the speed across the panel."""
        ny, nz = math.sin(self.angle), math.cos(self.angle)
        return (ny if abs(ny) > 1e-12 else 0.0, nz if abs(nz) > 1e-12 else 0.0)

    @property
    def arm(self) -> float:
        """Return the lever arm [m] of the panel's load about the roll axis."""
        return self.root + self.span * self.load + self.axis_up * self.normal[0]

    @property
    def load(self) -> float:
        """Return the share [-] of the span at which the load's centre lies."""
        taper = self.chords[1] / self.chords[0]
        return (1.0 + 2.0 * taper) / (3.0 * (1.0 + taper))

    def ahead(self, of_chord: float) -> float:
        """Return how far [m] ahead of the CG a share of the chord lies."""
        return self.x_G - self.station(of_chord)

    def station(self, of_chord: float) -> float:
        """Return the distance [m] aft of the nose of the same point."""
        at = [le + of_chord * c for le, c in zip(self.leading, self.chords, strict=True)]
        return at[0] + self.load * (at[1] - at[0])

    @property
    def sweep(self) -> float:
        """Return the sweep [rad] of the quarter chord."""
        root, tip = (le + 0.25 * c for le, c in zip(self.leading, self.chords, strict=True))
        return math.atan2(tip - root, self.span)

    @property
    def radius_ratio(self) -> float:
        """Return root radius over tip radius [-]."""
        return self.root / self.tip


def panels_of_surface(surface: Panels, shape: Shape) -> Iterator[Panel]:
    """Yield the panels of one surface."""
    tip_leading = surface.le_tip
    if tip_leading is None:
        tip_leading = surface.le_root + surface.root_chord - surface.tip_chord
    th = math.acos(2.0 * surface.flap_ratio - 1.0)
    for degrees in surface.angles_deg:
        angle = math.radians(degrees)
        root = root_radius(surface, shape, angle)
        whole = 0.5 * (surface.root_chord + surface.tip_chord) * (surface.tip_radius - root)
        moving = 1.0 if surface.moving_area is None or whole <= 0.0 else surface.moving_area / whole
        panel = Panel(
            name=surface.name,
            control=surface.control,
            sail=surface.sail,
            angle=angle,
            root=root,
            tip=surface.tip_radius,
            leading=(surface.le_root, tip_leading),
            chords=(surface.root_chord, surface.tip_chord),
            thickness=surface.thickness,
            axis_up=surface.axis_up,
            share=moving * (1.0 - (th - math.sin(th)) / math.pi),  # of a flap; thin aerofoil
            x_G=shape.x_G,
            aft=False,
        )
        aft = panel.station(0.25) > NEAR_STERN * shape.length
        yield replace(panel, aft=aft)


def root_radius(surface: Panels, shape: Shape, angle: float) -> float:
    """Return where a panel begins [m]: at the hull, unless the file says so."""
    if surface.root_radius is not None:
        return surface.root_radius
    x = surface.le_root + ROOT_CHORD_SHARE * surface.root_chord
    a, b = shape.at(shape.breadth, x) / 2.0, shape.at(shape.height, x) / 2.0
    if a <= 0.0 or b <= 0.0 or surface.axis_up:
        return 0.0
    return 1.0 / math.hypot(math.cos(angle) / a, math.sin(angle) / b)
