"""Bars, rods, tubes and tines that bend, across their length and sideways, and twist."""

import math
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from . import acceleration
from .acceleration import Click
from .bending import Motion, Section, bending
from .choices import ENDS
from .cords import nodes, require_resistance
from .heard import Loaded, heard, loaded
from .material import Array, Material
from .modes import Indices, Modes, audible, path, require_choice, require_positive
from .radiation import line
from .radiation.board import BOARDS
from .radiation.twist import Twist
from .resonator_tube import GAP, Tube, bar_flow, with_tube
from .ritz import quadrature
from .shearing import rectangles_shear, tubes_shear
from .torsion import torsion
from .unheard import FINER, Felt, completed, with_unheard

_SIGN_AT = 0.03  # of the length: whose sign a mode's sound has
UNDERCUT_SPAN = 0.6
"""Share of the length that is carved by default."""
FAN_DEPTH = 0.5
"""Share of a tube's sound that a fan takes away at most, by default."""
ACROSS, TILT = 0.2, 5.0
"""Place of a blow across the bar's width, and its angle (degrees): as a hand strikes unless it takes care."""


def bar(
    material: Material,
    *,
    length: float,
    top: float,
    width: float | None = None,
    thickness: float | None = None,
    undercut: float = 0.0,
    undercut_span: float = UNDERCUT_SPAN,
    across: float = ACROSS,
    tilt: float = TILT,
    diameter: float | None = None,
    wall: float | None = None,
    split: float = 0.0,
    imperfection: float = 20.0,
    ends: str = "free",
    board: str | None = None,
    tube_diameter: float | None = None,
    tube_length: float | None = None,
    tube_gap: float = GAP,
    tube_detuning: float = 0.0,
    tube_flow: float = 0.0,
    fan: float = 0.0,
    fan_depth: float = FAN_DEPTH,
    cords: float = 0.0,
) -> Modes:
    """Return the modes of a Timoshenko bar, struck along its length.

    Parameters
    ----------
    material : Material
        Material of the body.
    length : float
        Length, m, which is the strike path.
    top : float
        Highest frequency of a mode, Hz.
    width, thickness : float, optional
        Section of a rectangular bar, m. Give these or `diameter`.
    undercut : float, default 0
        Share of the thickness carved away at the middle, as in tuned bars, 0 to 1.
    undercut_span : float, default 0.6
        Share of the length that is carved.
    across : float, default 0.2
        Offset of the strike from the middle line, in half widths, -1 to 1; it makes the bar twist.
    tilt : float, default 5
        Tilt of the force towards an edge, degrees; it makes the bar bend along its width.
    diameter : float, optional
        Outer diameter of a round bar, m.
    wall : float, optional
        Thickness of a tube's wall, m. Default: a solid bar.
    split : float, default 0
        Difference between the frequencies of a round bar's two planes of bending, as a share.
    imperfection : float, default 20
        Angle between the blow and the plane of the lower one, degrees.
    ends : {"free", "cantilever"}, default "free"
        Ends: both free, or clamped at position 0.
    board : str, optional
        Sounding board in which a cantilever is clamped: "piano", "box", "cello" or "guitar".
    tube_diameter : float, optional
        Inner diameter of a resonator tube under the middle of a free rectangular bar, m. Default: no tube.
    tube_length : float, optional
        Length of the tube, m. Default: in tune with the lowest mode.
    tube_gap : float, default 0.012
        Gap between bar and tube, m.
    tube_detuning : float, default 0
        Detuning of a tube in tune, as a share of the frequency.
    tube_flow : float, default 0
        Speed of the air in the mouth at which vortices cost energy, m/s; 0: none.
    fan : float, default 0
        Turns per second of a vibraphone's disc, which closes the tube twice a turn.
    fan_depth : float, default 0.5
        Largest share of the tube's sound that the disc takes away, 0 to 1.
    cords : float, default 0
        Resistance of either cord that holds a free rectangular bar, kg/s.

    Returns
    -------
    Modes
        The modes from 1 Hz up to `top`.

    Raises
    ------
    ValueError
        An argument is out of range, or the body has no such mode; the text names it.

    Notes
    -----
    A rectangular bar bends in both directions and twists. The axis of a carved bar counts as straight: its frequencies
    are within 1.5 % of the solid body's (a test checks it). A board takes energy from the bar by the force on the
    clamp.
    """
    require_positive(length=length, width=width, thickness=thickness, diameter=diameter, wall=wall)
    require_choice("ends", ends, ENDS)
    if board is not None:
        require_choice("board", board, tuple(BOARDS))
        if ends != "cantilever":
            raise ValueError(f"board = {board}, ends = {ends}: expected a cantilever, clamped in the board")
    under = (tube_length, tube_gap, fan, fan_depth, tube_detuning, tube_flow)
    tube = None if tube_diameter is None else tube_of(tube_diameter, *under)
    for name, value in (("tube_diameter", tube_diameter), ("cords", cords)):
        if value and (ends != "free" or diameter is not None):
            raise ValueError(f"{name} = {value}: expected a bar with width and thickness and free ends")
    require_resistance(cords)
    if not 0 <= undercut < 1 or not 0 < undercut_span <= 1:
        raise ValueError(f"undercut = {undercut}, undercut_span = {undercut_span}: expected in [0, 1) and (0, 1]")

    span = _Span(material, length, ends == "cantilever", top)
    if width is not None and thickness is not None and diameter is None:
        carving = _Carving(width, thickness, undercut, undercut_span)
        parts = _rectangular(span, carving, across, math.radians(tilt))
    elif diameter is not None and width is None and thickness is None:
        section = _tube(diameter, wall, material)
        parts = _round(span, section, split, math.radians(imperfection))
    else:
        raise ValueError("section: expected width and thickness, or diameter")

    air = [part.air(part.motion) for part in parts]
    frequency = np.concatenate([each.frequency for each in air])
    keep = audible(frequency, top)

    def shapes(positions: Array) -> Array:
        columns = [
            part.along(positions)[:, None] * part.motion.shape(positions) * each.shrinking
            for part, each in zip(parts, air, strict=True)
        ]
        return np.concatenate(columns, axis=1)[:, keep]

    resistance = np.concatenate([each.resistance for each in air])[keep]
    lost = np.concatenate([_into(board, span, part) for part in parts])[keep]
    share = BOARDS[board].radiated_share(frequency[keep]) if board else 0.0
    positions = path(length * FINER * max(part.motion.wavenumber for part in parts))
    strike = shapes(positions)
    sign = shapes(np.array([_SIGN_AT]))[0]
    area = _area(material, width, thickness, 2 / 3 * undercut * undercut_span, diameter, wall)
    mass = material.density * area * length
    made = heard(material, frequency[keep], resistance + share * lost, (strike, sign), mass, resistance + lost)
    if cords:
        made = replace(made, decay=made.decay + cords * _on_cords(parts, air)[keep])
    made = with_unheard(made, _beyond(parts, positions, 2 * top), material.decay, top)
    if tube is not None and width is not None and thickness is not None:
        upright = np.flatnonzero(keep < parts[0].motion.frequency.size)
        made = over_tube(made, upright, shapes, tube, (length, width, thickness * (1 - undercut)), top)
    return replace(made, clicks=_clicks(mass, length, area, width, diameter, ends))


def tube_of(
    tube_diameter: float, tube_length: float | None = None, tube_gap: float = GAP, fan: float = 0.0,
    fan_depth: float = FAN_DEPTH, tube_detuning: float = 0.0, tube_flow: float = 0.0,
) -> Tube:  # fmt: skip
    """Return the tube that stands under a bar; arguments as of `bar`."""
    return Tube(tube_diameter, tube_length, tube_gap, fan, fan_depth, tube_detuning, tube_flow)


def over_tube(
    modes: Modes,
    upright: Indices,
    shapes: Callable[[Array], Array],
    tube: Tube,
    sides: tuple[float, float, float],
    top: float,
) -> Modes:
    """Return a bar's modes with a tube under its middle, up to `top` (Hz).

    upright: those that move it up and down; shapes: positions (p,) in 0..1 -> all shapes there (p, n); sides: length,
    width, and thickness at the middle (m).
    """
    if not upright.size:
        return modes
    along, aside = tube.mouth
    flow = bar_flow(sides[1:], aside, tube.gap, tube.end) @ shapes(0.5 + along / sides[0])[:, upright] / along.size
    return with_tube(modes, upright, flow, tube.tuned(float(modes.frequency[upright[0]])), top)


def bar_clicks(material: Material, *, length: float, ends: str = "free", **section: Any) -> tuple[Click, ...]:
    """Return the clicks of a bar; arguments as of `bar`."""
    width, thickness, diameter, wall = map(section.get, ("width", "thickness", "diameter", "wall"))
    carved = 2 / 3 * section.get("undercut", 0.0) * section.get("undercut_span", UNDERCUT_SPAN)
    area = _area(material, width, thickness, carved, diameter, wall)
    return _clicks(material.density * area * length, length, area, width, diameter, ends)


def _area(
    material: Material, width: float | None, thickness: float | None, carved: float, diameter: float | None,
    wall: float | None,
) -> float:  # fmt: skip
    """Return the mean area (m^2) of a bar's section; carved: the share of a rectangle that is carved away."""
    if width is not None and thickness is not None:
        return width * thickness * (1 - carved)
    assert diameter is not None
    return float(_tube(diameter, wall, material).area)


def _clicks(
    mass: float, length: float, area: float, width: float | None, diameter: float | None, ends: str
) -> tuple[Click, ...]:
    """Return the clicks of a bar of a mass (kg), and a section's mean area (m^2)."""
    if ends == "cantilever":
        return ()
    if width is not None:
        return (acceleration.rectangle(mass, length, width, area * length),)
    assert diameter is not None
    return (acceleration.cylinder(mass, length, diameter),)


class _Span(NamedTuple):
    """A bar but for its section: its length (m), whether it is clamped at 0, and the highest frequency (Hz) wanted."""

    material: Material
    length: float
    clamped: bool
    top: float


class _Part(NamedTuple):
    """A kind of motion; what of it lies along the blow where it strikes, a factor (p,) at positions in 0..1; what the
    air does to it; the mass (kg/m) that it moves to and fro at points in -1..1, if it does; by what factor its square
    is, in the mean over the width, that of what moves up and down; and whether it goes along a board that it is clamped
    in."""

    motion: Motion
    along: Callable[[Array], Array]
    air: Callable[[Motion], Loaded]
    swayed: Callable[[Array], Array] | None = None
    lifted: float = 0.0
    aside: bool = False


def _beyond(parts: list[_Part], positions: Array, highest: float) -> Felt:
    """Return the residual of the parts' motions at positions (p,) in 0..1: as modes up to `highest` (Hz) and above."""
    found = []
    for part in parts:
        along, motion, more = part.along(positions)[:, None], part.motion, part.motion.beyond
        every = np.append(motion.frequency, more.frequency)
        # Their number grows with the frequency, and so above: for bending as its root, where waves are long.
        growth = math.log2(every.size / max(int((every <= every[-1] / 2).sum()), 1)) - 1
        heard = Felt(motion.frequency, along * motion.shape(positions))
        higher = Felt(more.frequency, along * more.shape(positions))
        found.append(completed(heard, higher, more.last, highest, min(max(growth, -0.5), 0.0)))
    return Felt(*(np.concatenate([each[i] for each in found], axis=-1) for i in (0, 1)))


class _Carving(NamedTuple):
    """A rectangular section, in m, whose thickness is carved away by a fraction, in a parabola over a span."""

    width: float
    thickness: float
    undercut: float
    span: float

    def depth(self, x: Array) -> tuple[Array, Array]:
        """Return the thickness (m) at points in -1..1, and its derivative."""
        inside = np.maximum(0, 1 - (x / self.span) ** 2)
        slope = np.where(inside > 0, 2 * self.thickness * self.undercut * x / self.span**2, 0.0)
        return self.thickness * (1 - self.undercut * inside), slope

    @property
    def kinks(self) -> tuple[float, ...]:
        """Points between which it is smooth."""
        return (-self.span, self.span) if self.undercut and self.span < 1 else ()

    def upright(self, material: Material, x: Array) -> Section:
        """Return the section at x for bending along the thickness."""
        depth = self.depth(x)[0]
        shear = rectangles_shear(material, self.width / depth)
        return Section(self.width * depth, self.width * depth**3 / 12, shear, self.width + 0 * depth, depth)

    def sideways(self, material: Material, x: Array) -> Section:
        """Return the section at x for bending along the width."""
        depth = self.depth(x)[0]
        shear = rectangles_shear(material, depth / self.width)
        return Section(self.width * depth, self.width**3 * depth / 12, shear, depth, self.width + 0 * depth)


def _rectangular(span: _Span, carving: _Carving, across: float, tilt: float) -> list[_Part]:
    """Return the motions that a blow excites at a point off the middle line, and half the thickness above the axis."""
    width = carving.width

    def swayed(x: Array) -> Array:
        return span.material.density * width * carving.depth(x)[0]

    def face(x: Array) -> line.Outline:
        return line.rectangular(width, carving.depth(x)[0])

    def edge(x: Array) -> line.Outline:
        return line.on_edge(width, carving.depth(x)[0])

    upright = bending(*span, partial(carving.upright, span.material), carving.kinks)
    parts = [_Part(upright, partial(_everywhere, math.cos(tilt)), partial(_swaying, span, face), swayed, 1.0)]
    if tilt:
        sideways = bending(*span, partial(carving.sideways, span.material), carving.kinks)
        air = partial(_swaying, span, edge)
        parts.append(_Part(sideways, partial(_everywhere, math.sin(tilt)), air, swayed, aside=True))
    if across or tilt:
        arm = across * width / 2 * math.cos(tilt)

        def along(positions: Array) -> Array:
            return np.asarray(arm - math.sin(tilt) * carving.depth(2 * positions - 1)[0] / 2)

        twisted = torsion(*span, width, carving.depth, carving.kinks)
        parts.append(_Part(twisted, along, partial(_twisting, span, carving), lifted=width**2 / 12))
    return parts


def _round(span: _Span, section: Section, split: float, imperfection: float) -> list[_Part]:
    motion = bending(*span, lambda x: Section(*(each + 0 * x for each in section[:3])))
    area, moment = float(section.area), float(section.moment)
    bore = math.sqrt(max(8 * moment / area - 2 * area / math.pi, 0.0))  # of A = pi/4 (D^2 - d^2), I = pi/64 (D^4 - d^4)
    outline = partial(line.tubular, math.sqrt(bore**2 + 4 * area / math.pi), bore)
    air = partial(_swaying, span, outline)
    swayed = partial(_everywhere, span.material.density * area)
    if split == 0:
        return [_Part(motion, partial(_everywhere, 1.0), air, swayed)]
    lower, upper = (motion._replace(frequency=motion.frequency * (1 + sign * split / 2)) for sign in (-1, 1))
    return [
        _Part(lower, partial(_everywhere, math.cos(imperfection)), air, swayed),
        _Part(upper, partial(_everywhere, -math.sin(imperfection)), air, swayed),
    ]


def _everywhere(factor: float, positions: Array) -> Array:
    return np.full(positions.shape, factor)


def _on_cords(parts: list[_Part], air: list[Loaded]) -> Array:
    """Return how cords under the lowest mode's nodes raise the decays of all motions, over their resistance (1/kg);
    not at all where even the lowest is too high to be heard."""
    if not parts[0].motion.frequency.size:
        return np.zeros(sum(part.motion.frequency.size for part in parts))
    at = nodes(parts[0].motion.shape)
    moved = [part.lifted * (part.motion.shape(at) * each.shrinking) ** 2 for part, each in zip(parts, air, strict=True)]
    raised: Array = np.concatenate(moved, axis=1).sum(axis=0) / 2
    return raised


def _into(board: str | None, span: _Span, part: _Part) -> Array:
    """Return the loss of a motion (1/s) to the board in which the bar is clamped: its shear force there moves the
    board, or turns it."""
    motion = part.motion
    if board is None or part.swayed is None:
        return np.zeros_like(motion.frequency)
    nodes, weights = quadrature(2 * motion.terms)
    at = (nodes + 1) / 2
    along = 1.0 if part.aside else part.along(at)
    moved = along * part.swayed(nodes) * weights @ motion.shape(at) * span.length / 2
    under = BOARDS[board].conductance_aside if part.aside else BOARDS[board].conductance
    lost: Array = (2 * np.pi * motion.frequency * moved) ** 2 * under(motion.frequency)
    return lost


def _swaying(span: _Span, outline: Callable[[Array], line.Outline], motion: Motion) -> Loaded:
    """Return the air's load on a motion across the bar."""
    nodes, weights = quadrature(2 * motion.terms)
    at = (nodes + 1) / 2
    half = span.length / 2
    bent = line.Bar(nodes, weights, motion.terms, motion.shape(at), motion.slope(at), half, outline(nodes))
    return loaded(motion.frequency, partial(line.load_of, bent), line.mass_of(bent, motion.frequency))


def _twisting(span: _Span, carving: _Carving, motion: Motion) -> Loaded:
    """Return the air's load on a twist; the air's mass is left out."""
    nodes, weights = quadrature(2 * motion.terms)
    sides = span.length / 2, carving.width / 2
    twist = Twist(sides, nodes, weights, motion.shape((nodes + 1) / 2), carving.depth(nodes)[0])
    return Loaded(motion.frequency, twist.resistance(motion.frequency), np.ones_like(motion.frequency))


def _tube(diameter: float, wall: float | None, material: Material) -> Section:
    """Return the section of a rod or tube."""
    bore = 0.0 if wall is None else diameter - 2 * wall
    if bore < 0:
        raise ValueError(f"wall = {wall}: expected at most half the diameter, {diameter / 2}")
    area = math.pi / 4 * (diameter**2 - bore**2)
    moment = math.pi / 64 * (diameter**4 - bore**4)
    return Section(np.array(area), np.array(moment), np.array(tubes_shear(material, bore / diameter)))
