"""What of a scene surrounds its hair in a frame."""

from collections.abc import Sequence

import numpy as np

from hairpipe.data import LevelSet
from hairpipe.data.hair import HairState
from hairpipe.data.parts import BodyParts
from hairpipe.levelset.collider import MovingSurface
from hairpipe.levelset.collider_field import moving_field
from hairpipe.levelset.interpolation import Interpolation
from hairpipe.levelset.parts.moving_parts import moving_parts
from hairpipe.sim.air.breeze import Breeze
from hairpipe.sim.boundary import WORLD
from hairpipe.sim.contact.body.body_contacts import BodyContacts, thicknesses
from hairpipe.sim.contact.body.fold_preservation import turns_of
from hairpipe.sim.contact.hair.exclusions import REST
from hairpipe.sim.contact.hair.hair_contacts import HairContacts
from hairpipe.sim.contact.hair.stiction import Connections, same_hair_keys
from hairpipe.sim.filters.limit_strain import StrainFilter
from hairpipe.sim.hair_model import HairModel
from hairpipe.sim.interactions import Interaction
from hairpipe.sim.settings import BodyContact, Collisions, Scene, Stiction
from hairpipe.sim.strands.interface import StrandModel
from hairpipe.sim.surroundings import Surroundings
from hairpipe.spatial.pairs import key_of
from hairpipe.spatial.proximity import near_pairs


def bodies_of(
    surfaces: Sequence[tuple[LevelSet, LevelSet]],
    parts: Sequence[tuple[BodyParts, BodyParts]],
    contact: BodyContact,
    frame: float,
) -> list[MovingSurface]:
    """Make bodies of what they are at the previous and at this frame, which are frame [s] apart."""
    scheme = Interpolation[contact.interpolation]
    whole = [moving_field(*surface, frame, scheme) for surface in surfaces]
    return [*whole, *(moving_parts(*body, frame) for body in parts)]


def surroundings_of(
    hair: HairModel,
    model: StrandModel,
    state: HairState,
    bodies: Sequence[MovingSurface],
    scene: Scene,
    began: float,
    origin: np.ndarray = WORLD,
) -> Surroundings:
    """Collect what acts on hair in a frame, which is computed about an origin [m], (3,).

    The order of interactions is decided here: wind, bodies, the strain limit, hair, then those of the scene. Where a
    step begins, in solves, and in the nine steps (5: bodies, 6: hair) they act in this order; what puts right at the
    end of a step of the other schemes goes backwards: crossings of hair, then strain, and bodies have the last word.
    """
    offsets, acting = hair.layout.offsets, list[Interaction]()
    if scene.wind is not None:
        acting.append(Breeze(scene.wind, hair.diameter, offsets))
    if bodies:
        acting.append(_body_contacts(hair, model, bodies, scene.contact))
    if scene.strain is not None:
        acting.append(StrainFilter(model, scene.strain.tolerance))
    if scene.stiction is not None or scene.collisions is not None:
        stuck = Connections(state.stuck, state.stuck_at)
        at_rest = pairs_at_rest(hair, scene.stiction, scene.collisions)
        acting.append(HairContacts(offsets, scene.stiction, scene.collisions, stuck, at_rest))
    return Surroundings(model, hair.layout, [*acting, *scene.interactions], began, origin)


def _body_contacts(
    hair: HairModel, model: StrandModel, bodies: Sequence[MovingSurface], contact: BodyContact
) -> BodyContacts:
    """Make what holds hair out of bodies."""
    points, offsets = hair.groom.points, hair.layout.offsets
    turns = turns_of(points, offsets) if contact.folds is not None else None
    axial = np.empty(len(offsets) - 1)
    axial[hair.layout.strands] = model.constants[:, 0]
    segments = np.linalg.norm(np.diff(points, axis=0, prepend=points[:1]), axis=1)
    return BodyContacts(list(bodies), contact, thicknesses(offsets, contact.thickness), offsets, segments, axial, turns)


def pairs_at_rest(
    hair: HairModel, stiction: Stiction | None, collisions: Collisions | None
) -> tuple[np.ndarray, np.ndarray]:
    """Return the keys of pairs that the groom has so near that they do not stick, and that they do not collide."""
    points, offsets = hair.groom.points, hair.layout.offsets
    sticking = colliding = np.empty(0, np.int64)
    if stiction is not None:
        reach = stiction.reach
        sticking = hair.once(("stiction", reach), lambda: same_hair_keys(points, offsets, reach))
    if collisions is not None:
        far = REST * collisions.thickness
        colliding = hair.once(("collisions", far), lambda: key_of(near_pairs(points, offsets, far).segments))
    return sticking, colliding
