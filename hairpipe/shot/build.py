"""Objects of a scene: bodies, surroundings, the integrator.

Hair led to a density once a step: Petrovic, Henne, Anderson 2005, equation (3), see `volume/targeting.py`.
"""

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from math import ceil
from typing import TypeVar
from warnings import warn

import numpy as np

from hairpipe.contact.body import BodyContacts
from hairpipe.contact.contact_points import USUAL, Scale, scale_of
from hairpipe.contact.hair import REST, HairContacts
from hairpipe.contact.repulsion import no_shear
from hairpipe.contact.stiction import Connections, same_hair_keys
from hairpipe.errors import BadInput
from hairpipe.geometry.proximity import near_pairs
from hairpipe.geometry.segments import key_of, renumbered
from hairpipe.groom.painting import Varied
from hairpipe.groom.strand_arrays import thicknesses
from hairpipe.laws.fold_preservation import turns_of
from hairpipe.laws.settings import BodyContact, Collisions, Stiction, Target, Thickness, Volume
from hairpipe.laws.stretch import SpringForm
from hairpipe.levelset.collider import Collider
from hairpipe.levelset.collider_field import build_collider_field
from hairpipe.levelset.collider_parts import build_collider_parts
from hairpipe.levelset.interpolation import Interpolation
from hairpipe.shot.breeze import Breeze, StillAir
from hairpipe.shot.settings import Scene
from hairpipe.solve.backward_euler import BackwardEuler
from hairpipe.solve.bdf2 import Bdf2
from hairpipe.solve.boundary import WORLD
from hairpipe.solve.integrator import Integrator
from hairpipe.solve.interactions import Interaction, StepEnd
from hairpipe.solve.nine_steps import FullStep, Trapezoid
from hairpipe.solve.stage import Rule
from hairpipe.solve.stretch import StrainFilter
from hairpipe.solve.surroundings import Surroundings
from hairpipe.solve.tr_bdf2 import TrBdf2
from hairpipe.strands.hair_model import HairModel
from hairpipe.strands.interface import StrandModel, kind_of, may_be_lost
from hairpipe.values import Density, LevelSet
from hairpipe.values.body import BodyParts
from hairpipe.values.hair import HairState
from hairpipe.volume.strand_samples import reach_of
from hairpipe.volume.targeting import Hair, TargetGrid, attraction, between, target_grids
from hairpipe.volume.volume_filter import VolumeFilter, rest_density

V = TypeVar("V", bound=Varied)
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
        acting.append(_body_contacts(hair, model, state, bodies, scene))
    if scene.stiction is not None or scene.collisions is not None:
        acting.append(_hair_contacts(hair, state, scene.stiction, scene.collisions, scale))
    if scene.strain is not None:
        acting.append(StrainFilter(model, scene.strain.tolerance))
    if scene.volume is not None:
        acting.append(_volume_filter(hair, scene.volume))
    return Surroundings(model, hair.layout, [*acting, *own_interactions(scene)], began, origin, scale.speed)


def _body_contacts(
    hair: HairModel, model: StrandModel, state: HairState, bodies: Sequence[Collider], scene: Scene
) -> BodyContacts:
    """Make what holds hair out of bodies."""
    contact = scene.contact
    points, offsets = hair.groom.points, hair.layout.offsets
    turns = turns_of(points, offsets) if contact.folds is not None else None
    axial = np.empty(len(offsets) - 1)
    axial[hair.layout.strands] = model.constants[model.first[:-1], 0]
    segments = np.linalg.norm(np.diff(points, axis=0, prepend=points[:1]), axis=1)
    kept = thicknesses(offsets, contact.thickness)
    scale = scale_of(max(contact.thickness, hair.diameter), BodyContact().thickness, scene.gravity)
    return BodyContacts(list(bodies), contact, kept, offsets, segments, axial, turns, scale, state.touching)


def hair_scale(hair: HairModel, scene: Scene) -> Scale:
    """Return the scale of contact between strands, by the largest distance at which they touch, or else stick."""
    if scene.collisions is not None:
        whole = hair if hair.part_of is None else hair.part_of[0]
        thickness, _ = _factored(scene.collisions.thickness, whole, "collisions.thickness")
        return scale_of(thickness.value, Collisions().thickness.value, scene.gravity)
    if scene.stiction is not None:
        return scale_of(scene.stiction.reach, Stiction().reach, scene.gravity)
    return USUAL


def _hair_contacts(
    hair: HairModel, state: HairState, stiction: Stiction | None, collisions: Collisions | None, scale: Scale
) -> HairContacts:
    """Make what hair does to hair pair by pair: of a setting that varies its largest value, and factors of segments."""
    at_rest = pairs_at_rest(hair, stiction, collisions)
    single = np.ones(hair.layout.offsets[-1])
    grips = thick = single
    if stiction is not None:
        force, factors = _factored(stiction.force, hair, "stiction.force")
        stiction = replace(stiction, force=force)
        grips = np.sqrt(factors)
    if collisions is not None:
        thickness, thick = _factored(collisions.thickness, hair, "collisions.thickness")
        collisions = replace(collisions, thickness=thickness)
    stuck = Connections(state.stuck, state.stuck_at)
    widths = single if hair.widths is None else hair.widths
    return HairContacts(
        hair.layout.offsets,
        stiction,
        collisions,
        stuck,
        at_rest,
        widths,
        grips,
        thick,
        scale,
        state.shear or no_shear(),
    )


def _factored(setting: V, hair: HairModel, name: str) -> tuple[V, np.ndarray]:
    """Return the largest value of a setting on segments, as a setting, and the factors of segments on it, (P,)."""
    values = hair.values_of(setting, name)
    if np.ndim(values) == 0:
        return setting, np.ones(hair.layout.offsets[-1])
    largest = float(values[1].max())
    return type(setting)(largest), values[1] / (largest or 1.0)


def _volume_filter(hair: HairModel, volume: Volume) -> VolumeFilter:
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


def pairs_at_rest(
    hair: HairModel, stiction: Stiction | None, collisions: Collisions | None
) -> tuple[np.ndarray, np.ndarray]:
    """Return the keys of pairs that the groom has so near that they do not stick, and that they do not collide."""
    if hair.part_of is not None:
        whole, numbers = hair.part_of
        sticking, colliding = pairs_at_rest(whole, stiction, collisions)
        return renumbered(sticking, numbers), renumbered(colliding, numbers)
    points, offsets = hair.groom.points, hair.layout.offsets
    sticking = colliding = np.empty(0, np.int64)
    if stiction is not None:
        reach = stiction.reach
        sticking = hair.once(("stiction", reach), lambda: same_hair_keys(points, offsets, reach))
    if collisions is not None:
        colliding = hair.once(("at rest", collisions.thickness), lambda: _touching_at_rest(hair, collisions.thickness))
    return sticking, colliding


def _touching_at_rest(hair: HairModel, thickness: Thickness) -> np.ndarray:
    largest, factors = _factored(thickness, hair, "collisions.thickness")
    near = near_pairs(hair.groom.points, hair.layout.offsets, REST * largest.value, None, factors)
    return key_of(near.segments)


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


@dataclass(eq=False)
class VolumeTarget(Interaction):
    """The density target of a frame.

    offsets        offsets of the points of strands, (S+1,) int32
    reach          see `sample_strands` [m], (S,)
    lengths        length of hair at each point, at rest [m], (P,)
    before, after  density at the previous frame and at this one, on all grids
    frame_dt       time between the two [s]
    """

    in_solve = False
    target: Target
    offsets: np.ndarray
    reach: np.ndarray
    lengths: np.ndarray
    before: list[TargetGrid]
    after: list[TargetGrid]
    frame_dt: float

    def correct(self, end: StepEnd) -> None:
        """Change velocities, in place."""
        share = (end.time + end.dt) / self.frame_dt
        still = self.before is self.after
        now = self.after if still else [between(*pair, share) for pair in zip(self.before, self.after, strict=True)]
        hair = Hair(end.points, self.offsets, self.reach, self.lengths)
        change = attraction(hair, now, self.target.rate, end.dt)
        change[np.isinf(end.masses)] = 0.0
        end.push(change)


def volume_target(
    target: Target,
    densities: tuple[Density, Density],
    strands: tuple[np.ndarray, np.ndarray, np.ndarray],
    frame_dt: float,
) -> VolumeTarget:
    """Make a target from offsets, reach and lengths of strands and densities at the previous frame and at this one.

    Raises BadInput as `target_grids` does.
    """
    (before, after), (offsets, reach, lengths) = densities, strands
    grids = target_grids(after, target.cell, target.levels, lengths.sum())
    still = np.array_equal(before.low, after.low) and np.array_equal(before.length, after.length)
    first = grids if still else target_grids(before, target.cell, target.levels, lengths.sum())
    return VolumeTarget(target, offsets, reach, lengths, first, grids, frame_dt)


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
