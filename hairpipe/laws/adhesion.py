"""Adhesion of two hairs that came close, the stiction of Sec. 5.2 of Selle, Lentine, Fedkiw 2008, Fig. 10c.

A spring joins two points at the distance l along d. It resists stretch and compression, and breaks abruptly:

    f = -(T + c d.u) d,   T = k (l - reach),   k = force / (release - reach),   0 at l > release

T d is the gradient of k (l - reach)^2 / 2; a push has its d of the start of the step. c is a fraction of critical
damping of the two alone, 1/m = sum w_i^2 / m_i: c = 2 fraction sqrt(k m). A solve is implicit but for negative terms:

    K = k d d^T + max(T, 0) / l (I - d d^T),   C = c d d^T

A connection that is beyond release at a prediction breaks within the step. Its stiffness is then that of a spring with
the same work over the whole distance, k (release - reach)^2 / (l - reach)^2, and c is multiplied by (release - reach) /
(l - reach). Otherwise its force would grow with the step, and stop the separation of hair.

The force of a connection is the geometric mean of those of its two segments, as the adhesion of unlike surfaces is
that of the adhesions of each to its like (Girifalco and Good 1957): hair without force sticks to nothing.

We differ from the authors' code: it has a modulus without a unit, is explicit, and limits connections of one segment.
"""

import numpy as np

from hairpipe.errors import BadInput
from hairpipe.geometry.compile import inlined
from hairpipe.laws.settings import Stiction


def stiffness_of(stiction: Stiction) -> float:
    """Stiffness of a connection [N/m]; BadInput where it would break before it pulls."""
    if not stiction.release > stiction.reach:
        raise BadInput(
            f"the release distance of stiction, {stiction.release} m, is less than its reach, {stiction.reach} m",
            where="stiction.release",
            right="more than stiction.reach",
        )
    return stiction.force.value / (stiction.release - stiction.reach)


@inlined
def adhesion(stiffness, fraction, longer, slack, inverse_mass):
    """Return k [N/m] and c [kg/s] of a connection at a prediction.

    stiffness     within release [N/m]
    longer        l - reach [m]; slack  release - reach [m]
    inverse_mass  1/m [1/kg]; 0: both points are held, and nothing is damped
    """
    # Beyond release it breaks within the step: a weaker spring that does the same work until then.
    present = min(slack / max(longer, slack), 1.0)
    c = 2.0 * fraction * present * np.sqrt(stiffness / inverse_mass) if inverse_mass > 0.0 else 0.0
    return stiffness * present * present, c
