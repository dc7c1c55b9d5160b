"""Coulomb's law of dry friction: along a contact |f_t| <= mu N, against what moves there.

    f_t = -c q,   c = min(most, mu N / |q|)

q is what moves along the contact, and c its secant: for a velocity a damping [kg/s], for the elongation of a spring a
stiffness [N/m], for the relative velocity of an impact a mass [kg], or its share of the mass that moves [1]. What
sticks is held by `most`; what slides has the force mu N at any speed. The work f_t . q is never positive. Implicit in q
the derivative is c across and along the motion; exact, it is 0 along it, and friction would turn a motion around.

Contact with bodies (`contact/body_implicit.py`, `body_projection.py`), contact between hairs and the impulses of the
nine steps (`repulsion.py`), swept collisions (`collision.py`) and particles call `coulomb`. It costs a division.

Between hairs q is the elongation e of a spring after Cundall and Strack, A discrete numerical model for granular
assemblies, Geotechnique 29, 1979. The two points of a contact have moved along it by s since it began, u_t is their
relative velocity there, and k and r are stiffness and relaxation of the normal:

    e = s + r u_t

Hair that sticks is held without creep, and hair that slides by mu N, at any speed, mass and step. Without the damping
a heap on a body trembles for long. In a stage of duration t and weight h the spring is implicit. With e_p at the
prediction and e = e_p + (h + r) J dv,

    f_t = -c e,   M_t = t (h + r) c (I - n n^T)

This is the force of Coulomb's law where hair slides as predicted, and less where friction slows it: it never turns a
motion around. A contact that carried nothing at the start of the step begins by an impact. It takes from |e_p| the part
t (h + r) mu N / m by which friction slows two free segments, 1/m = sum w^2 / m_i: the impulse is then that of the law.
"""

import numpy as np
from numba import njit

from hairpipe.geometry.compile import inlined
from hairpipe.geometry.vec3 import dot, length, minus, plus, scaled

_SHORTEST = 1e-12  # [m]; an elongation below it has no direction


@inlined
def coulomb(most, limit, moved):
    """Return c of f = -c q: `most` as long as that is within the limit mu N, otherwise mu N / |q|.

    moved  |q| >= 0
    """
    return min(most, limit / moved) if moved > 0.0 else most


@inlined
def elongated(s, u, lagged, h, stiffness, relaxation, limit, slowed):
    """Return c [N/m] and e [m] of two hairs in contact at a prediction.

    s          elongation there [m]; u  relative velocity along the contact there, and the lagged one [m/s]
    h          weight of the stage [s], by which a solve that is linearised at rest moves on with the lagged velocity
    limit      mu N [N]; slowed  what friction takes from |e_p| [m]
    """
    ahead = length(plus(s, plus(scaled(h, minus(lagged, u)), scaled(relaxation, lagged))))
    return coulomb(stiffness, limit, max(ahead - slowed, _SHORTEST)), plus(s, scaled(relaxation, u))


@njit(cache=True)
def slide(u, n, push, friction):
    """Return relative motion u after a normal push >= 0 and the friction it causes; all (3,) tuples."""
    normal = dot(u, n)
    across = minus(u, scaled(normal, n))
    keep = 1.0 - coulomb(1.0, friction * push, np.sqrt(dot(across, across)))
    return plus(scaled(normal + push, n), scaled(keep, across))


@inlined
def impulse(u, n, dv, friction, mass):
    """Return the impulse that changes n.u by dv > 0 and reduces the sliding u_t by at most friction dv [N s].

    u  relative velocity of first and second point; mass  mass of the pair
    """
    ut = minus(u, scaled(dot(n, u), n))
    return scaled(mass, minus(scaled(dv, n), scaled(coulomb(1.0, friction * dv, np.sqrt(dot(ut, ut))), ut)))
