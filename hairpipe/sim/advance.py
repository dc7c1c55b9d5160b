"""One frame of the simulation, in steps: solve, limit strain, collide."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from hairpipe.data import Groom, LevelSet, Mesh, Strands
from hairpipe.data.hair import HairState
from hairpipe.levelset.field import field_of
from hairpipe.levelset.interpolation import Interpolation
from hairpipe.sim.control import next_step
from hairpipe.sim.filters.chain import limit_all, limit_and_collide
from hairpipe.sim.integrators import chain
from hairpipe.sim.integrators.tr_bdf2 import G
from hairpipe.sim.layout import Layout, lay_out
from hairpipe.sim.material import Material
from hairpipe.sim.network import Network, build_network
from hairpipe.sim.roots import between, clamps, place
from hairpipe.sim.scene import Scene


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


@lru_cache(maxsize=2)
def make_hair(groom: Groom, material: Material) -> Hair:
    """Build the network of a groom."""
    layout = lay_out(groom.offsets)
    network, rest = build_network(layout, groom.points, material)
    return Hair(groom, layout, network, rest, material.diameter)


def start(hair: Hair, body: Mesh, scene: Scene) -> HairState:
    """Put the groom on the body, moving with it: its springs are at rest, so it begins to fall freely."""
    strands = np.repeat(hair.layout.strands, np.diff(hair.layout.first), axis=0)
    positions, velocities = place(body, hair.groom, hair.rest, strands)
    accelerations = gravity_of(scene)[:, None] - scene.air.drag * velocities
    return HairState(positions, velocities, accelerations, np.zeros_like(positions))


def gravity_of(scene: Scene) -> np.ndarray:
    """Return the acceleration of free fall [m/s^2], (3,)."""
    return np.array([0.0, -scene.gravity, 0.0])


def advance_frame(
    hair: Hair,
    state: HairState,
    bodies: tuple[Mesh, Mesh],
    surfaces: tuple[LevelSet, LevelSet] | None,
    frame: float,
    scene: Scene,
) -> HairState:
    """Carry hair from the previous frame to this one.

    bodies    at the previous and at this frame
    surfaces  of the bodies, or None where hair passes through
    frame     time between them [s]
    """
    x, v, a, T = (array.copy() for array in (state.positions, state.velocities, state.accelerations, state.tensions))
    begin, end = (clamps(body, hair.groom, hair.rest, hair.layout) for body in bodies)
    contact = scene.contact
    scheme = int(Interpolation[contact.interpolation])
    fields = None if surfaces is None else tuple(map(field_of, surfaces))
    gravity = gravity_of(scene)
    time = 0.0
    while time < frame * (1 - 1e-9):
        dt = next_step(scene.steps, v, begin, end, frame, time)
        ends = np.stack([between(begin, end, frame, time + part * dt) for part in (G, 1.0)])
        before = x.copy()
        chain.advance(hair.network, x, v, a, T, ends, dt, gravity, scene.air.drag)
        if fields is None:
            limit_all(hair.network, x, scene.strain.tolerance)
        else:
            body = (*fields, frame, (time, time + dt), scheme, contact.friction, contact.thickness)
            limit_and_collide(hair.network, x, v, before, scene.strain.tolerance, *body)
        time += dt
    return HairState(x, v, a, T)


def strands_of(hair: Hair, state: HairState) -> Strands:
    """Collect what is shown: the axis of every strand; ArithmeticError naming strands that are not finite."""
    points, velocities = hair.layout.axis(state.positions), hair.layout.axis(state.velocities)
    finite = np.isfinite(points).all(1) & np.isfinite(velocities).all(1)
    if not finite.all():
        strands = np.unique(np.searchsorted(hair.layout.offsets, np.flatnonzero(~finite), side="right") - 1)
        listed = ", ".join(map(str, hair.groom.ids[strands[:10]]))
        raise ArithmeticError(f"{len(strands)} strands are not finite, among them ids {listed}")
    return Strands(points.astype(np.float32), velocities.astype(np.float32), hair.layout.offsets, hair.diameter)
