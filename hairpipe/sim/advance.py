"""One frame of the simulation, in steps: solve, limit strain, collide."""

from dataclasses import dataclass

import numpy as np

from hairpipe.data import Groom, LevelSet, Mesh, Strands
from hairpipe.data.hair import HairState
from hairpipe.sim.control import StepControl
from hairpipe.sim.filters.collide_body import BodyContact, collide_body
from hairpipe.sim.filters.limit_strain import limit_strain
from hairpipe.sim.integrators import tr_bdf2
from hairpipe.sim.layout import Layout, lay_out
from hairpipe.sim.material import Material
from hairpipe.sim.network import Network, build_network
from hairpipe.sim.roots import between, clamps, place


@dataclass(frozen=True, eq=False)
class Hair:
    """What stays the same through a shot: the groom as a network of springs.

    rest  particles of the groom [m], (rows, 3, WIDTH)
    """

    groom: Groom
    layout: Layout
    network: Network
    rest: np.ndarray
    diameter: float


@dataclass(frozen=True)
class Surroundings:
    """What acts on hair from outside.

    gravity           downwards, along -Y [m/s^2]
    drag              of still air [1/s]
    strain_tolerance  of the limiter
    """

    gravity: float
    drag: float
    strain_tolerance: float


def make_hair(groom: Groom, material: Material) -> Hair:
    """Build the network of a groom."""
    layout = lay_out(groom.offsets)
    network, rest = build_network(layout, groom.points, material)
    return Hair(groom, layout, network, rest, material.diameter)


def start(hair: Hair, body: Mesh) -> HairState:
    """Put the groom on the body, moving with it."""
    strands = np.repeat(hair.layout.strands, np.diff(hair.layout.first), axis=0)
    positions, velocities = place(body, hair.groom, hair.rest, strands)
    return HairState(positions, velocities, np.zeros_like(positions), np.zeros_like(positions))


def advance_frame(
    hair: Hair,
    state: HairState,
    bodies: tuple[Mesh, Mesh],
    surfaces: tuple[LevelSet, LevelSet] | None,
    frame: float,
    control: StepControl,
    contact: BodyContact,
    surroundings: Surroundings,
) -> HairState:
    """Carry hair from the previous frame to this one.

    bodies    at the previous and at this frame
    surfaces  of the bodies, or None where hair passes through
    frame     time between them [s]
    """
    x, v, a, T = (array.copy() for array in (state.positions, state.velocities, state.accelerations, state.tensions))
    begin, end = (clamps(body, hair.groom, hair.rest, hair.layout) for body in bodies)
    fields = None if surfaces is None else (make_field(surfaces[0]), make_field(surfaces[1]))
    gravity = np.array([0.0, -surroundings.gravity, 0.0])
    time = 0.0
    while time < frame * (1 - 1e-9):
        dt = control.next_step(v, begin, end, frame, time)
        ends = np.stack([between(begin, end, frame, time + part * dt) for part in (tr_bdf2.G, 1.0)])
        before = x.copy()
        tr_bdf2.advance(hair.network, x, v, a, T, ends, dt, gravity, surroundings.drag)
        limit_strain(hair.network, x, surroundings.strain_tolerance)
        if fields is not None:
            scheme = SCHEMES[contact.interpolation]
            collide_body(
                hair.network,
                x,
                v,
                before,
                fields,
                frame,
                (time, time + dt),
                scheme,
                contact.friction,
                contact.thickness,
            )
        time += dt
    return HairState(x, v, a, T)


def strands_of(hair: Hair, state: HairState) -> Strands:
    """Collect what is shown: the axis of every strand; BadInput naming strands that are not finite."""
    points, velocities = hair.layout.axis(state.positions), hair.layout.axis(state.velocities)
    finite = np.isfinite(points).all(1) & np.isfinite(velocities).all(1)
    if not finite.all():
        strands = np.unique(np.searchsorted(hair.layout.offsets, np.flatnonzero(~finite), side="right") - 1)
        listed = ", ".join(map(str, hair.groom.ids[strands[:10]]))
        raise ArithmeticError(f"{len(strands)} strands are not finite, among them ids {listed}")
    return Strands(points.astype(np.float32), velocities.astype(np.float32), hair.layout.offsets, hair.diameter)
