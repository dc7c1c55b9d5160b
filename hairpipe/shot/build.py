"""Objects of a scene: bodies, surroundings, the integrator."""

from collections.abc import Sequence
from dataclasses import dataclass, fields
from math import ceil
from warnings import warn

import numpy as np

from hairpipe.contact.body import body_contacts_of
from hairpipe.contact.contact_points import USUAL, Scale, scale_of
from hairpipe.contact.hair import factored, hair_contacts_of
from hairpipe.errors import BadInput
from hairpipe.geometry.collider import Collider
from hairpipe.laws.settings import BodyContact, Collisions, Stiction, Volume
from hairpipe.laws.stretch import SpringForm
from hairpipe.levelset.collider_field import build_collider_field
from hairpipe.levelset.collider_parts import build_collider_parts
from hairpipe.levelset.sample import Interpolation
from hairpipe.shot.breeze import Breeze, StillAir
from hairpipe.shot.settings import Scene
from hairpipe.solve.boundary import WORLD
from hairpipe.solve.integrator import Integrator
from hairpipe.solve.integrators import BackwardEuler, Bdf2, FullStep, Trapezoid, TrBdf2
from hairpipe.solve.interactions import Interaction
from hairpipe.solve.stage import Rule
from hairpipe.solve.stretch import StrainFilter
from hairpipe.solve.surroundings import Surroundings
from hairpipe.strands.hair_model import HairModel
from hairpipe.strands.interface import StrandModel, kind_of, may_be_lost
from hairpipe.values import LevelSet
from hairpipe.values.body import BodyParts
from hairpipe.values.groom import reach_of
from hairpipe.values.hair import HairState
from hairpipe.volume.volume_filter import VolumeFilter, rest_density

_SCHEMES = {"tr_bdf2": TrBdf2, "bdf2": Bdf2, "backward_euler": BackwardEuler}
_NINE_STEPS = {"trapezoid": Trapezoid, "full_step": FullStep}
MOST_VOXELS = 64  # of half_width of `bake_levelset`


def bodies_of(
    surfaces: Sequence[tuple[LevelSet, LevelSet]],
    parts: Sequence[tuple[BodyParts, BodyParts]],
    contact: BodyContact,
    frame_dt: float,
) -> list[Collider]:
    """Build colliders of bodies at the previous and at this frame, frame_dt [s] apart; warns of too narrow bands."""
    scheme = Interpolation[contact.interpolation]
    whole = [build_collider_field(*surface, frame_dt, scheme) for surface in surfaces]
    for place, far in enumerate([body.lost for body in whole], start=1):
        if far > 0.0:
            needed = ceil(0.5 * far * whole[place - 1].after.per_metre)
            coarser = f", and voxel = {0.5 * far / MOST_VOXELS:.3g} or more" if needed > MOST_VOXELS else ""
            message = f"level set {place} moves by {far:.2g} m in a frame, beyond its band, and does not stop hair"
            cure = f"half_width = {min(needed, MOST_VOXELS)}{coarser}, of bake_levelset, or bake_parts"
            warn(f"{message} ({cure})", stacklevel=3)
    return [*whole, *(build_collider_parts(*body, frame_dt) for body in parts)]


def surroundings_of(
    hair: HairModel,
    model: StrandModel,
    state: HairState,
    bodies: Sequence[Collider],
    scene: Scene,
    began: float,
    origin: np.ndarray = WORLD,
) -> Surroundings:
    """Collect the interactions of a frame, which is computed about an origin [m], (3,).

    This function defines the order of interactions: wind, bodies, pairs of hair, the strain limit, hair as a volume,
    then those of the scene. They act in this order at the start of a step, in solves, and in the nine steps (5:
    bodies, 6: hair); corrections at the end of a step of the other schemes run in reverse order: strain, then
    crossings of hair, which the strain limit would bring about, then bodies.
    """
    offsets = hair.layout.offsets
    scale = hair_scale(hair, scene)
    acting = list[Interaction]()
    if scene.wind is not None:
        acting.append(Breeze(scene.wind, hair.diameter, offsets, hair.widths, hair.diameters))
    elif scene.air_interacts:
        acting.append(StillAir(hair.masses * hair.values_of(scene.air.drag, "air.drag")[0]))
    if bodies:
        acting.append(body_contacts_of(hair, model, state.touching, bodies, scene.contact, scene.gravity))
    if scene.stiction is not None or scene.collisions is not None:
        acting.append(hair_contacts_of(hair, state, scene.stiction, scene.collisions, scale))
    if scene.strain is not None:
        acting.append(StrainFilter(model, scene.strain.tolerance))
    if scene.volume is not None:
        acting.append(volume_filter_of(hair, scene.volume))
    return Surroundings(model, hair.layout, [*acting, *own_interactions(scene)], began, origin, scale.speed)


def hair_scale(hair: HairModel, scene: Scene) -> Scale:
    """Return the scale of contact between strands, by the largest distance at which they touch, or else stick."""
    if scene.collisions is not None:
        whole = hair if hair.part_of is None else hair.part_of[0]
        thickness, _ = factored(scene.collisions.thickness, whole, "collisions.thickness")
        return scale_of(thickness.value, Collisions().thickness.value, scene.gravity)
    if scene.stiction is not None:
        return scale_of(scene.stiction.reach, Stiction().reach, scene.gravity)
    return USUAL


def volume_filter_of(hair: HairModel, volume: Volume) -> VolumeFilter:
    """Make what hair does to hair through a grid."""
    points = hair.groom.points
    offsets = hair.layout.offsets
    rest = 0.0
    reach = hair.once("reach", lambda: reach_of(points, offsets))
    if volume.pressure is not None:
        dense = volume.pressure.density
        cell = volume.cell
        rest = dense or hair.once(("density", cell), lambda: rest_density(points, offsets, hair.masses, cell))
    return VolumeFilter(volume, offsets, hair.masses, reach, rest)


def check_scheme(model: StrandModel, scene: Scene) -> None:
    """Raise BadInput where a model cannot be computed by a scheme: a rod's twist has no inertia, and must be solved."""
    if not may_be_lost(model):
        return
    name = kind_of(model).name
    if scene.scheme.value == "nine_steps":
        right = '"tr_bdf2", "bdf2" or "backward_euler"'
        raise BadInput(f"scheme nine_steps is for springs, not for a {name}", where="scheme.value", right=right)
    if scene.scheme.spring not in ("multiplier", "tension"):
        message = f'"{scene.scheme.spring}" leaves out stiffness that a {name} needs'
        raise BadInput(message, where="scheme.spring", right='"multiplier" or "tension"')


def integrator_of(scene: Scene) -> Integrator:
    """Build the integrator of a scene."""
    scheme = scene.scheme
    rule = Rule(
        int(SpringForm[scheme.spring]),
        scheme.overdamping,
        scheme.guard,
        scheme.iterations,
        gravity_of(scene),
        0.0 if scene.air_interacts else scene.air.drag.value,
    )
    kinds = _NINE_STEPS if scheme.value == "nine_steps" else _SCHEMES
    return kinds[scheme.velocity if scheme.value == "nine_steps" else scheme.value](rule)


def gravity_of(scene: Scene) -> np.ndarray:
    """Return the acceleration of free fall [m/s^2], (3,)."""
    return np.array([0.0, -scene.gravity, 0.0])


@dataclass(frozen=True)
class ExtendedScene(Scene):
    """A scene with interactions of your own, which no graph file has."""

    interactions: tuple[Interaction, ...] = ()


def with_interactions(scene: Scene, *interactions: Interaction) -> ExtendedScene:
    """Return the scene with interactions of your own besides its; pure."""
    values = {each.name: getattr(scene, each.name) for each in fields(Scene)}
    return ExtendedScene(**values, interactions=(*own_interactions(scene), *interactions))


def own_interactions(scene: Scene) -> tuple[Interaction, ...]:
    """Return the interactions of a scene that are none of the house's."""
    return scene.interactions if isinstance(scene, ExtendedScene) else ()
