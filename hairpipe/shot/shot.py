"""A shot of any hair model: its first frame, the following frames, and cuts, over which hair moves with its roots.

A hair model provides a `Simulation`; the sequence of a shot is the same for all models.

Cuts of a shot: hair moves rigidly with its roots to the new place of the body, and is then simulated for the frame.

The place of the body one frame before the cut is unknown: it is extrapolated backwards with the body's present
velocities. Hair is moved there rigidly with its roots, and simulated from there.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Protocol, TypeVar
from warnings import warn

import numpy as np

from hairpipe.geometry.compile import threads_for
from hairpipe.solve.boundary import apply_rigid, follow, motion_of_roots
from hairpipe.strands.hair_model import HairModel
from hairpipe.values import BodyParts, Density, Ends, Groom, LevelSet, Mesh, Pins
from hairpipe.values.groom import Driver
from hairpipe.values.hair import HairState
from hairpipe.values.strand_arrays import is_bound


def driver_before(driver: Driver, groom: Groom, dt: float) -> Driver:
    """Return the driver of the roots, dt [s] earlier in uniform motion; pure."""
    if isinstance(driver, Mesh):
        return replace(driver, points=driver.points - dt * driver.rates, velocities=driver.rates)
    if isinstance(driver, Ends):
        first = groom.points[groom.offsets[:-1]]
        last = groom.points[groom.offsets[1:] - 1]
        return Ends(
            *steady(driver.roots, driver.roots_rate, first, dt), *steady(driver.tips, driver.tips_rate, last, dt)
        )
    return driver


def _surface_before(surface: LevelSet, dt: float) -> LevelSet:
    """Return a level set dt [s] earlier on a steady way, without a turn; pure."""
    samples = surface.velocity.reshape(-1, 3)
    way = dt * samples.mean(axis=0, dtype=np.float64) if len(samples) else 0.0
    return replace(surface, origin=surface.origin - way)


def _parts_before(body: BodyParts, dt: float) -> BodyParts:
    """Return a body in parts dt [s] earlier on a steady way; pure."""
    poses, rates = steady(body.poses, body.rates, np.zeros((len(body.poses), 3)), dt)
    return replace(body, poses=poses, rates=rates)


def steady(motions: np.ndarray, rates: np.ndarray, points: np.ndarray, dt: float) -> tuple[np.ndarray, np.ndarray]:
    """Return rigid motions x -> R x + t, (n, 3, 4), and their rates, dt [s] earlier at constant velocity; pure.

    points  unmoved points with straight paths, the centres of rotation [m], (n, 3)

    R_ = (I + dt/2 W)^-1 (I - dt/2 W) R with W = R' R^T, which is exp(-dt W) R up to the third power of dt.
    """
    turns = motions[:, :, :3]
    spin = rates[:, :, :3] @ turns.transpose(0, 2, 1)
    spin = 0.5 * (spin - spin.transpose(0, 2, 1))
    one = np.eye(3)
    before = np.linalg.solve(one + 0.5 * dt * spin, (one - 0.5 * dt * spin) @ turns)
    velocities = np.einsum("nij,nj->ni", rates[:, :, :3], points) + rates[:, :, 3]
    places = np.einsum("nij,nj->ni", turns, points) + motions[:, :, 3] - dt * velocities
    turning = spin @ before
    return (
        np.concatenate([before, (places - np.einsum("nij,nj->ni", before, points))[:, :, None]], axis=2),
        np.concatenate([turning, (velocities - np.einsum("nij,nj->ni", turning, points))[:, :, None]], axis=2),
    )


def rigid_over_cut(drivers: tuple[Driver, Driver], groom: Groom) -> tuple[np.ndarray, np.ndarray]:
    """Return the rigid motions of roots over a cut, x -> Q x + d, and their rotations, (strands, 3, 4) each; pure.

    drivers  of the roots before and after the cut

    With the motion x = R X + t of a root before the cut and R_, t_ after it, Q = R_ R^T and d = t_ - Q t.
    """
    (here, _), (there, _) = (motion_of_roots(driver, groom) for driver in drivers)
    turn = there[:, :, :3] @ here[:, :, :3].transpose(0, 2, 1)
    shift = there[:, :, 3] - np.einsum("sij,sj->si", turn, here[:, :, 3])
    moved = np.concatenate([turn, shift[:, :, None]], axis=2)
    return moved, np.concatenate([turn, np.zeros_like(shift)[:, :, None]], axis=2)


def move_over_cut(hair: HairModel, state: HairState, drivers: tuple[Driver, Driver]) -> HairState:
    """Move hair from the pose and motion of the body before a cut to those after it; pure.

    drivers  of the roots before and after the cut

    With Q and d of `rigid_over_cut`, and the velocities u and u_ of points rigidly attached to the root at x before the
    cut and at x_ after it,

        x_ = Q x + d,   v_ = Q (v - u) + u_,   a_ = Q a

    so that the shape of a strand and its motion relative to the root are kept. Tensions and other scalars are
    unchanged. No time passes. Gravity does not rotate with the roots: hanging hair falls from its rotated position.
    """
    before, after = drivers
    groom, layout = hair.groom, hair.layout
    moved, turned = rigid_over_cut(drivers, groom)
    strands = np.repeat(layout.strands, np.diff(layout.first), axis=0)
    relative = state.velocities - follow(before, groom, state.positions, layout)
    positions = apply_rigid(moved, state.positions, strands)
    return replace(
        state,
        positions=positions,
        velocities=apply_rigid(turned, relative, strands) + follow(after, groom, positions, layout),
        accelerations=apply_rigid(turned, state.accelerations, strands),
        touching=None,
        shear=None,
    )


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
    with threads_for(len(simulation.groom.points)):
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
    dt = frame.frame_dt
    surfaces = [(_surface_before(after, dt), after) for _, after in frame.surfaces]
    parts = [(_parts_before(after, dt), after) for _, after in frame.parts]
    pins = [(replace(after, positions=after.positions - dt * after.velocities), after) for _, after in frame.pins]
    target = None if frame.target is None else (frame.target[1], frame.target[1])
    drivers = before, frame.drivers[1]
    return replace(frame, drivers=drivers, surfaces=surfaces, parts=parts, target=target, pins=pins, cut=False)
