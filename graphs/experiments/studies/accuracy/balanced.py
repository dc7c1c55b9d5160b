"""A strand over a wire with equal weights at its ends: the balanced fibre method, by which hair is measured.

The distance D between its vertical parts has T D^2 = 8 EI for a force T of each weight. Half of the strand is clamped
level at the wire; it is long in comparison with D, and its own weight is nothing.

Source: Scott and Robbins, Stiffness of Human Hair Fibers, J. Soc. Cosmet. Chem. 29, 469, 1978: equations 1 to 4, and
the table of its shape on page 482, which is TABLE.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from hairpipe.graphs.experiments.studies.accuracy.sample import Sample
from hairpipe.graphs.experiments.studies.accuracy.specimen import straight_specimen
from hairpipe.graphs.experiments.studies.accuracy.statics import balance, motions
from hairpipe.values import Table
from hairpipe.values.table import table_of_rows

TABLE = (
    *((0.025, 0.001232), (0.050, 0.004878), (0.100, 0.019335), (0.200, 0.079170)),
    *((0.300, 0.194416), (0.400, 0.423225), (0.450, 0.664291), (0.475, 0.908362)),
)
"""Distance from the wire aside and down over D."""
_WIDTH = 0.3
"""D over the length of half of the strand: beyond, it is straight up to 1e-4 of D."""
_SHARES = (0.02, 0.1, 0.3)
"""Parts of the weights on the way."""
_FINE = 10_000
"""Places of the curve through the points of a strand."""
SHAPES = ("strand", "segments", "aside over D", "down over D", "error [% of D]")
MODULI = ("strand", "segments", "D [mm]", "theory [mm]", "modulus error [%]")


def balanced_tables(sample: Sample, segments: Sequence[int]) -> tuple[Table, Table]:
    """Tabulate the shape of a balanced strand at the places of TABLE, and the modulus that its width would give."""
    from scipy.interpolate import CubicSpline

    shapes = []
    moduli = []
    for count in segments:
        strand = straight_specimen(sample, count)
        width = _WIDTH * sample.length
        load = strand.nothing()
        load[strand.tip, 0] = 8 * sample.material.bending / width**2
        free = motions(strand)
        pose = strand.rest
        for share in _SHARES:
            pose = balance(strand, pose, share * load, free).pose
        at = balance(strand, pose, load, free)
        points = strand.axis(at.pose) / width
        found = 2 * float(points[-1, 2]) if at.found else np.nan
        name = sample.name(count)
        moduli.append((name, count, 1e3 * found * width, 1e3 * width, 100 * (found**2 - 1)))
        ends: Any = ((1, [1.0 / (_WIDTH * count), 0.0]), "natural")
        curve = CubicSpline(np.arange(count + 1), points[:, [2, 0]], bc_type=ends)
        drawn = curve(np.linspace(0, count, _FINE))
        for place in TABLE:
            nearest = float(np.linalg.norm(drawn - place, axis=1).min()) if at.found else np.nan
            shapes.append((name, count, *place, 100 * nearest))
    return table_of_rows(SHAPES, shapes), table_of_rows(MODULI, moduli)
