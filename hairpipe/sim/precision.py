"""When hair may be computed in single precision.

The matrix of an implicit step has stiffness beside mass, h^2 k to m, and what is lost when one is eliminated from the
other grows with that: with the square of how many explicit steps there are in a step,

    N = dt sqrt(max_p sum_s 4 k_s / (m_p l_s)),

the sum running over the springs s at a particle p. `graphs/experiments/speed_accuracy_hair.toml` has two hairs that are
allowed: single precision changes their errors by 0.001 % of the length. At N = 4,000, rounding, 6e-8 N^2, is as great
as mass is. What is exchanged between strands, and their factors there, are in single precision whatever
this says: nothing is eliminated any more.
"""

import numpy as np

from hairpipe.errors import BadInput
from hairpipe.sim.control import highest_frequency
from hairpipe.sim.hair import Hair
from hairpipe.sim.scene import Scene

MOST = 400.0
"""Of N, in single precision."""


def check_precision(hair: Hair, scene: Scene) -> None:
    """Refuse, by BadInput, hair in single precision at steps for which that is too little."""
    if hair.layout.dtype != np.float32:
        return
    if scene.sag_free is not None:
        raise BadInput("a start without sag needs double precision", where="precision", right='"double"')
    longest = MOST / highest_frequency(hair.model)
    if scene.steps.longest > longest:
        raise BadInput(
            f"single precision is too little for steps of {scene.steps.longest:.3g} s of hair so stiff and light",
            where="precision",
            right=f'"double", steps.longest of at most {longest:.2g} s, or fewer segments',
        )
