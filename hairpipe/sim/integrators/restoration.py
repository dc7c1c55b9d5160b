"""States that a frame cannot begin with as they are: strands that are not finite, and another precision."""

from dataclasses import replace

import numpy as np

from hairpipe.data.hair import HairState
from hairpipe.sim.boundary import Driver, place
from hairpipe.sim.hair_model import HairModel
from hairpipe.sim.integrators.integrator import rows_of
from hairpipe.sim.integrators.lost import are_finite
from hairpipe.sim.layout import relaid


def restored(hair: HairModel, state: HairState, driver: Driver) -> tuple[HairState, np.ndarray]:
    """Return a state in which non-finite strands are reset to the groom, at rest relative to their roots; pure.

    driver  of the roots at the frame of the state

    Also returns these strands, (blocks, W) bool. No other valid shape of them is known.
    """
    rows = state.positions, state.velocities, state.accelerations, state.tensions
    finite = np.all([are_finite(hair.model, values) for values in rows], axis=0)
    if finite.all():
        return state, ~finite
    lost = rows_of(hair.model, ~finite)
    numbers = np.arange(hair.layout.offsets[-1])
    for strand in np.unique(hair.layout.strands[~finite]):
        numbers[hair.layout.offsets[strand] : hair.layout.offsets[strand + 1]] = -1
    positions, velocities = place(driver, hair.groom, hair.rest, hair.layout)
    mended = replace(
        state,
        positions=np.where(lost, positions, state.positions),
        velocities=np.where(lost, velocities, state.velocities),
        accelerations=np.where(lost, 0.0, state.accelerations).astype(state.accelerations.dtype),
        fresh=state.fresh | ~finite,
        tensions=np.where(lost, 0.0, state.tensions).astype(state.tensions.dtype),
        touching=state.touching and state.touching.renumbered(numbers),
        shear=state.shear and state.shear.renumbered(numbers),
    )
    return mended, ~finite


def converted(state: HairState, here: HairModel, there: HairModel) -> HairState:
    """Return a state of strands in one precision as one of the same strands in another; pure."""
    names = ("velocities", "accelerations", "tensions", "inverse_lengths")
    kept = {name: getattr(state, name) for name in names if getattr(state, name) is not None}
    cast = {name: relaid(values, here.layout, there.layout).astype(there.layout.dtype) for name, values in kept.items()}
    positions, fresh = (relaid(values, here.layout, there.layout) for values in (state.positions, state.fresh))
    return replace(state, positions=positions, fresh=fresh, **cast)
