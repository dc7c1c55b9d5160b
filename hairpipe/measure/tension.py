"""Tension along strands."""

import numpy as np

from hairpipe.data import Groom
from hairpipe.data.hair import HairState
from hairpipe.errors import BadInput
from hairpipe.sim.layout import Layout, lay_out
from hairpipe.sim.strands.registry import strand_models


def layout_of(groom: Groom, state: HairState) -> Layout:
    """Return the layout of a state, of the model with as many particles; BadInput where there is none."""
    dtype = state.velocities.dtype
    layouts = [lay_out(groom.offsets, kind.shape, dtype) for kind in strand_models().values()]
    found = next((layout for layout in layouts if layout.first[-1] == len(state.positions)), None)
    if found is None:
        raise BadInput("hair and groom are not the same strands", right="in.groom: the groom that is simulated")
    return found


def tensions(layout: Layout, state: HairState) -> list[tuple[int, np.ndarray, np.ndarray]]:
    """Return every strand with its points [m], (n+1, 3), and the tension of its segments [N], (n,).

    The force across a section of a segment is sum T d, over the linear springs that it cuts; the tension is its
    component along the segment. Altitude springs are excluded: they separate tetrahedra and have no force along a
    hanging or pulled strand.
    """
    shape = layout.shape
    found = []
    for block, segments in enumerate(layout.segments):
        rows = slice(layout.first[block], layout.first[block + 1])
        x, T = state.positions[rows], state.tensions[rows]
        total = np.zeros_like(x)
        for offset in range(1, (min(T.shape[1], shape.reach) if shape.unknowns == 3 else 1) + 1):
            span = x[offset:] - x[:-offset]
            pull = T[:-offset, None, offset - 1] * span / np.linalg.norm(span, axis=1, keepdims=True)
            for cut in range(offset):
                total[cut : cut + len(pull)] += pull
        axis = x[shape.axis]
        edges = np.diff(axis, axis=0)
        cuts = total[shape.axis][:segments]
        along = np.sum(cuts * edges, axis=1) / np.linalg.norm(edges, axis=1)
        lanes = np.flatnonzero(~layout.idle[block])
        found += [(int(layout.strands[block, lane]), axis[:, :, lane], along[:, lane]) for lane in lanes]
    return found
