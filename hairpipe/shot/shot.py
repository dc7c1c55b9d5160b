"""A shot of any hair model: its first frame, the following frames, and cuts, over which hair moves with its roots.

A hair model provides a `Simulation`; the sequence of a shot is the same for all models.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Protocol, TypeVar
from warnings import warn

from hairpipe.groom.strands import is_bound
from hairpipe.shot.cuts import driver_before, parts_at_cut, pins_at_cut, surfaces_at_cut
from hairpipe.solve.boundary import Driver
from hairpipe.values import BodyParts, Density, Groom, LevelSet, Mesh, Pins

S = TypeVar("S")


@dataclass(frozen=True, eq=False)
class Frame:
    """The surroundings of hair at a frame and the one before it, in this order in all pairs.

    drivers   drivers of the roots: bodies or scripted ends
    surfaces  level sets of whole bodies
    parts     bodies in parts
    began     time of the shot at the previous frame [s]
    frame_dt  time between the two [s]
    cut       whether the shot is cut at this frame: hair is moved with its roots
    target    target densities, if `volume.target` is set
    pins      pinned points of hair
    """

    drivers: tuple[Driver, Driver]
    surfaces: Sequence[tuple[LevelSet, LevelSet]]
    parts: Sequence[tuple[BodyParts, BodyParts]]
    began: float
    frame_dt: float
    cut: bool = False
    target: tuple[Density, Density] | None = None
    pins: Sequence[tuple[Pins, Pins]] = ()

    @property
    def number(self) -> int:
        """The number of the frame in the shot; the first is 0."""
        return round(self.began / self.frame_dt) + 1


class Simulation(Protocol[S]):
    """Hair of one model with its settings; states of type S are never changed in place."""

    @property
    def groom(self) -> Groom:
        """The strands whose roots are led."""
        ...

    def start(self, frame: Frame) -> S:
        """Return the hair at the first frame."""
        ...

    def advance(self, state: S, frame: Frame) -> S:
        """Return the hair at a frame from that at the previous one; the shot is not cut between them."""
        ...

    def move_over_cut(self, state: S, drivers: tuple[Driver, Driver]) -> S:
        """Return the hair moved with its roots, from their driver before a cut to that after it."""
        ...


def next_state(simulation: Simulation[S], previous: S | None, frame: Frame) -> S:
    """Return the hair at a frame from that at the previous one; None: it is the first. Pure."""
    if previous is None:
        return simulation.start(frame)
    if frame.cut:
        before = driver_before(frame.drivers[1], simulation.groom, frame.frame_dt)
        previous = simulation.move_over_cut(previous, (frame.drivers[0], before))
        frame = after_cut(frame, before)
    return simulation.advance(previous, frame)


def warn_of_connections(groom: Groom, frame: Frame, *, contact: bool) -> None:
    """Warn where hair has no contact although it has a body, or does not move although bodies may.

    contact  whether settings of contact are given
    """
    driver = frame.drivers[1]
    if frame.surfaces or frame.parts:
        if driver is None and is_bound(groom):
            message = "bodies without in.body: roots stay at rest, also where the bodies move"
            warn(f"{message} (in.body = the body that the groom was grown on)", stacklevel=3)
    elif isinstance(driver, Mesh) or contact:
        source = "in.body" if isinstance(driver, Mesh) else "contact"
        message = f"{source} without in.surface and in.parts: hair passes through bodies"
        warn(f"{message} (in.surface = a bake_levelset of the body, or in.parts = a bake_parts)", stacklevel=3)


def after_cut(frame: Frame, before: Driver) -> Frame:
    """Return a frame whose bodies come from where the roots come from, after the cut; pure."""
    surfaces = surfaces_at_cut(frame.surfaces, frame.frame_dt)
    parts = parts_at_cut(frame.parts, frame.frame_dt)
    target = None if frame.target is None else (frame.target[1], frame.target[1])
    drivers = before, frame.drivers[1]
    pins = pins_at_cut(frame.pins, frame.frame_dt)
    return replace(frame, drivers=drivers, surfaces=surfaces, parts=parts, target=target, pins=pins, cut=False)
