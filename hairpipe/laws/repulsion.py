"""Repulsion of two hairs that overlap: a one-sided spring and damper along the normal of their contact.

    f_n = max(0, k o - c n.u),   o = thickness - g,   g = n.J x,   u = J v,   c = k r

For resting hair it is the gradient of k o^2 / 2. In a stage of weight h and duration t it is implicit, with

    M_n = t (h k + c) n n^T

r is the time in which two hairs that overlap and carry nothing come apart. Without it they separate within one step,
at a speed inversely proportional to it, and stacks keep trembling. It costs a few multiplications.

We differ from Selle, Lentine, Fedkiw 2008, who adapt the impulses of Bridson, Fedkiw, Anderson 2002: these are `sweep`
in `contact/repulsion.py`.
"""

from hairpipe.geometry.compile import inlined

RELAXATION = 5e-3
"""r at the usual scale [s]: viscosity over stiffness."""


@inlined
def repulsion(stiffness, viscosity, overlap, opening):
    """Return f_n [N] before it is limited to pushing; overlap  o [m]; opening  n.u [m/s]."""
    return stiffness * overlap - viscosity * opening


@inlined
def repulsion_slope(stiffness, viscosity, h):
    """Return h k + c [kg/s]: how much less f_n is for a velocity at the end of a stage of weight h [s]."""
    return h * stiffness + viscosity
