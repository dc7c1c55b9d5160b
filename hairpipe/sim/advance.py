"""One frame of the simulation, in steps."""

from dataclasses import dataclass
from functools import lru_cache
from typing import Literal

import numpy as np

from hairpipe.data import Ends, Groom, LevelSet, Mesh, Strands
from hairpipe.data.hair import HairState
from hairpipe.errors import BadInput
from hairpipe.groom.binding import name_strands
from hairpipe.levelset.field import field_of
from hairpipe.sim.control import limits_of, next_step
from hairpipe.sim.filters.filters import Filters
from hairpipe.sim.integrators.catalogue import gravity_of, integrator_of
from hairpipe.sim.integrators.interface import Motion, Step
from hairpipe.sim.layout import Layout, lay_out
from hairpipe.sim.material import Material
from hairpipe.sim.models import chain, network
from hairpipe.sim.models.chain import Chain, build_chain
from hairpipe.sim.models.construction import Construction
from hairpipe.sim.models.network import Network, build_network
from hairpipe.sim.roots import Path, hold, place
from hairpipe.sim.sag_free import stand
from hairpipe.sim.scene import Scene

ModelName = Literal["network", "chain"]
AS_IT_WORKS = Construction()
Lead = Mesh | Ends | None
"""What leads the roots: a body, or ends that are driven; None: they stand still."""


@dataclass(frozen=True, eq=False)
class Hair:
    """What stays the same through a shot: the groom as a model of strands.

    rest  particles of the groom [m], (rows, 3, W)
    """

    groom: Groom
    layout: Layout
    model: Network | Chain
    rest: np.ndarray
    diameter: float


@lru_cache(maxsize=2)
def make_hair(
    groom: Groom, material: Material, name: ModelName = "network", construction: Construction = AS_IT_WORKS
) -> Hair:
    """Build the model of a groom's strands; BadInput naming strands with a segment that has no length."""
    check_segments(groom)
    if name == "chain":
        layout = lay_out(groom.offsets, chain.SHAPE)
        model, rest = build_chain(layout, groom.points, material)
    else:
        layout = lay_out(groom.offsets, network.SHAPE)
        model, rest = build_network(layout, groom.points, material, construction)
    return Hair(groom, layout, model, rest, material.diameter)


def check_segments(groom: Groom) -> None:
    """Refuse strands with a point that is not finite or on the one before it, by BadInput with their ids."""
    lengths = np.linalg.norm(np.diff(groom.points, axis=0), axis=1)
    inside = np.delete(np.arange(len(lengths)), groom.offsets[1:-1] - 1)
    wrong = inside[~(lengths[inside] > 0.0) | ~np.isfinite(lengths[inside])]
    if len(wrong):
        ids = groom.ids[np.unique(np.searchsorted(groom.offsets, wrong, side="right") - 1)]
        raise BadInput(
            f"segments without length, or points that are not finite: {name_strands(ids)}",
            where="groom",
            right="every point away from the one before it",
        )


def leads_of(body: tuple[Mesh, Mesh] | None, ends: tuple[Ends, Ends] | None) -> tuple[Lead, Lead]:
    """Choose what leads the roots at the previous and at this frame; BadInput where two would."""
    if body is not None and ends is not None:
        raise BadInput("both a body and driven ends would lead the roots", right="in.body or in.ends")
    return body or ends or (None, None)


def start(hair: Hair, lead: Lead, scene: Scene) -> HairState:
    """Put the groom where its roots are, moving with them.

    Its springs are at rest, so it begins to fall freely; with a sag-free start they carry it. BadInput as for `stand`.
    """
    positions, velocities = place(lead, hair.groom, hair.rest, hair.layout)
    gravity = gravity_of(scene)
    if scene.sag_free is None:
        tensions = np.zeros_like(hair.model.inverse_lengths)
        return HairState(positions, velocities, gravity[:, None] - scene.air.drag * velocities, tensions, tensions[:0])
    stance = stand(hair.model, hair.layout, hair.groom.ids, positions, gravity, scene.sag_free)
    pull = np.where(stance.rests[:, None], 0.0, gravity[:, None])
    accelerations = pull - scene.air.drag * velocities
    return HairState(stance.positions, velocities, accelerations, stance.tensions, stance.inverse_lengths)


def advance_frame(
    hair: Hair,
    state: HairState,
    leads: tuple[Lead, Lead],
    surfaces: tuple[LevelSet, LevelSet] | None,
    frame: float,
    scene: Scene,
) -> HairState:
    """Carry hair from the previous frame to this one.

    leads     what leads the roots at the previous and at this frame
    surfaces  of the body, or None where hair passes through
    frame     time between them [s]
    """
    model = hair.model if not len(state.inverse_lengths) else hair.model._replace(inverse_lengths=state.inverse_lengths)
    arrays = (state.positions, state.velocities, state.accelerations, state.tensions)
    motion = Motion(*(array.copy() for array in arrays))
    path = Path(*(hold(lead, hair.groom, hair.rest, hair.layout) for lead in leads), frame)
    fields = None if surfaces is None else (field_of(surfaces[0]), field_of(surfaces[1]))
    filters = Filters(model, scene.strain, scene.contact, fields, frame)
    integrator, limits = integrator_of(scene), limits_of(scene.steps, model)
    time = 0.0
    while time < frame * (1 - 1e-9):
        dt = next_step(limits, motion, path, time)
        integrator.advance(model, motion, Step(path, time, dt), filters)
        time += dt
    return HairState(motion.x, motion.v, motion.a, motion.T, state.inverse_lengths)


def strands_of(hair: Hair, state: HairState) -> Strands:
    """Collect what is shown: the axis of every strand; ArithmeticError naming strands that are not finite."""
    points, velocities = hair.layout.axis(state.positions), hair.layout.axis(state.velocities)
    finite = np.isfinite(points).all(1) & np.isfinite(velocities).all(1)
    if not finite.all():
        strands = np.unique(np.searchsorted(hair.layout.offsets, np.flatnonzero(~finite), side="right") - 1)
        listed = ", ".join(map(str, hair.groom.ids[strands[:10]]))
        raise ArithmeticError(f"{len(strands)} strands are not finite, among them ids {listed}")
    return Strands(points.astype(np.float32), velocities.astype(np.float32), hair.layout.offsets, hair.diameter)
