"""A shot of hair, frame by frame: it starts, goes on, or is carried across a cut."""

from collections.abc import Sequence
from dataclasses import replace

from hairpipe.data import BodyParts, LevelSet
from hairpipe.data.hair import HairState
from hairpipe.sim.advance import Lead, advance_frame, start
from hairpipe.sim.build import bodies_of
from hairpipe.sim.cut import carry_state
from hairpipe.sim.diagnostics import warn_of_deep_roots, warn_of_stretch
from hairpipe.sim.hair_model import HairModel
from hairpipe.sim.settings import Scene


def next_state(
    hair: HairModel,
    previous: HairState | None,
    leads: tuple[Lead, Lead],
    bodies: tuple[Sequence[tuple[LevelSet, LevelSet]], Sequence[tuple[BodyParts, BodyParts]]],
    scene: Scene,
    seconds: float,
    frame: float,
    cut: bool,
) -> HairState:
    """Return the hair at a frame from that at the previous one; there is none at the first. Pure.

    leads    what leads the roots at the previous and at this frame
    bodies   level sets of whole bodies and of bodies in parts, at both frames
    seconds  time of the shot at the previous frame [s]
    frame    time between the two [s]
    cut      the shot begins anew at this frame
    """
    if previous is not None and cut:
        return carry_state(previous, hair.groom, hair.layout, *leads)
    surfaces = bodies_of(*bodies, scene.contact, frame)
    if previous is None:
        state = start(hair, leads[1], scene)
        warn_of_deep_roots(hair, state.positions, surfaces)
        return state
    state = advance_frame(hair, previous, leads, surfaces, frame, scene, seconds)
    number = round(seconds / frame) + 1
    return replace(state, stretched=warn_of_stretch(hair, state.positions, scene, number, previous.stretched))
