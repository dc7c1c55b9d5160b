"""Contact with the body inside the solve: held normals, friction, and an active set of pushing contacts.

A point predicted to end a stage nearer to the body than its thickness d is held along the normal n at the velocity
that ends at d, w_n = v_n + (d - phi) / h, by a damper that dominates all other terms of the strand's own system:

    f = c_n n n^T (w - v) + c_t (I - n n^T) (w - v),   c_n = STIFF m / h

Tangentially, Coulomb friction is a damper with the strength of friction at the last computed speed,

    c_t = min(c_n, mu N / |v_t - w_t|),   N = c_n n.(w - v)

so that friction never accelerates hair, sticking hair creeps by no more than force / c_n, and sliding hair has the
friction mu N once its speed is steady. A point that sticks with a force above mu N starts to slide at its speed without
contact, which the next solves reduce. Hair that speeds up from speed u to v would be held by v/u mu N. Where u is less
than a speed s, friction along the motion has its value at u but the smaller slope of a damper at s:

    f_u = -mu N (1 - u/s) - (mu N / s) v

so that a point alone speeds up by 1 / (1 + k mu N h / (m s)) of what Coulomb's law says, with k from 0.41 to 0.5, the
lags of u in the two stages of TR-BDF2. The damper alone lets it begin late, or not at all. The less the slope, the
longer hair that touches other hair goes on in small jumps before it rests, and the more vibrations grow of strands in
tension on a post. A point whose motion this force would turn around is solved again with the damper. Points with
tensile contact forces are released. If the active set changes, or a point begins to touch or to slide, the strand is
solved again, starting from the previous solve.

A new contact is first solved without friction, which gives its load and sliding speed. If it stuck first, the hair
between it and the root would be strained by the whole sliding distance, and the tension would press it on the body:
hair hit by a bar at 1 m/s was flung away at 6 m/s. But a point at rest at the start of a step without a contact state,
as at the first frame, sticks: one solve without friction would let it creep. A frame goes on with the states of the
previous one: with new contacts at every frame sliding hair lost friction there, and moved in jumps. A point that slides
around a body stays held although its prediction, a straight line, leaves the surface: released and caught again in
every stage, it would use up all passes and lose its friction.

We differ from the paper, which moves positions first and holds the normals of the moved points in the velocity solve
(equality, for a whole step): here pushing stretches no hair, and friction and tension are coupled, so that a hair
around a post holds according to Euler and Eytelwein.

Lengths and speeds below are those at the usual `Scale`.
"""

from typing import NamedTuple

import numpy as np
from numba import njit, prange

from hairpipe.contact.contact_points import USUAL, Scale
from hairpipe.geometry.collider import SdfSample
from hairpipe.geometry.compile import inlined
from hairpipe.laws.coulomb import coulomb
from hairpipe.solve.interactions import Prediction
from hairpipe.values.hair import Touching

FREE, TOUCHES, NEW, INSIDE = 0, 1, 2, 3
STIFF = 1e4  # a hair that is pulled onto the body with 1 mN sinks in by less than 5 um in a step of 1/240 s
_NEAR = 1e-5  # [m]; what touches is held up to this far outside, and what is free is caught from this far inside
_ROUGH = 1.5  # friction that comes out so many times too great is solved again; what is less is mended by and by
_STILL = 1e-3  # [m/s]; what is slower against the body, and not known to touch it, begins a step sticking
_SLOW = 0.02  # [m/s]; friction of what slides slower, and speeds up, is in part a constant force
_TURNED = 0.9  # cosine between normals; what turns farther in a step is a shock
PUSH_OUT = 0.5
"""Speed at which points come out that begin a step nearer than they keep [m/s]."""
DEEP = 1e-3
"""Less than this inside counts as on the surface [m]; what begins a step deeper rises, see `body.py`."""
_CHUNK = 512


class ContactState(NamedTuple):
    """Contact states of points on the body; arrays that a stage changes in place.

    state          FREE, TOUCHES, NEW (new contact, still without friction) or INSIDE (rises), (P,) int8
    c_t            tangential damping [kg/s], (P,)
    slid           velocity of sliding to which c_t belongs, where the damper would exceed mu N, else 0 [m/s], (P, 3)
    freed          points released in this stage, (P,) bool
    discontinuous  points whose contact began, ended or reversed its motion in this step: forces jumped, (P,) bool
    normal         (P, 3)
    c_n            normal damping [kg/s], (P,)
    target         w [m/s], (P, 3)
    body           speed of the body along the normal [m/s], (P,)
    length, speed  factors of the scale [1]
    """

    state: np.ndarray
    c_t: np.ndarray
    slid: np.ndarray
    freed: np.ndarray
    discontinuous: np.ndarray
    normal: np.ndarray
    c_n: np.ndarray
    target: np.ndarray
    body: np.ndarray
    length: float
    speed: float

    @classmethod
    def none(cls, count: int, scale: Scale = USUAL) -> "ContactState":
        """Make points that touch nothing."""
        slid, normal, target = (np.zeros((count, 3)) for _ in range(3))
        c_t, c_n, body = (np.zeros(count) for _ in range(3))
        state, freed, discontinuous = np.zeros(count, np.int8), np.zeros(count, np.bool_), np.zeros(count, np.bool_)
        return cls(state, c_t, slid, freed, discontinuous, normal, c_n, target, body, scale.length, scale.speed)

    def recall(self, known: Touching) -> None:
        """Take over what points touched at the end of the previous frame, in place."""
        at = known.points
        self.state[at], self.normal[at], self.slid[at] = known.states, known.normals, known.slid
        self.c_t[at], self.c_n[at] = known.damping.T

    def touching(self) -> Touching:
        """Return what the next frame has to know; pure."""
        at = np.flatnonzero(self.state != FREE)
        damping = np.stack([self.c_t[at], self.c_n[at]], axis=1)
        return Touching(at.astype(np.int32), self.state[at], damping, self.slid[at], self.normal[at])


@njit(cache=True, parallel=True)
def resume(contact: ContactState, probe: SdfSample, v: np.ndarray, thickness: np.ndarray, mass: np.ndarray) -> None:
    """Set the points that begin a step on the body to touching, in place: they rested on it before.

    probe  probe of the body at the points; v  velocities [m/s], (P, 3); thickness  [m], (P,)
    mass   [kg], (P,), inf: held by the root
    """
    for chunk in prange((len(v) + _CHUNK - 1) // _CHUNK):
        for i in range(chunk * _CHUNK, min((chunk + 1) * _CHUNK, len(v))):
            if contact.state[i] == FREE and mass[i] < np.inf:  # The others touched already, and keep their friction.
                _resume(contact, probe, i, v, thickness[i])


@inlined
def _resume(contact, probe, i, v, thickness):
    nx, ny, nz = probe.normal[i, 0], probe.normal[i, 1], probe.normal[i, 2]
    if probe.distance[i] < thickness + _NEAR * contact.length and nx * nx + ny * ny + nz * nz > 0.5:
        sticks = _slip(probe, i, v) < _STILL * contact.speed
        contact.state[i] = TOUCHES if sticks else NEW
        # As strong as what holds the normal: `_aim` makes it the c_n of the stage.
        contact.c_t[i] = contact.c_n[i] = 1.0 if sticks else 0.0
        contact.slid[i] = 0.0
        contact.normal[i, 0], contact.normal[i, 1], contact.normal[i, 2] = nx, ny, nz


@njit(cache=True, parallel=True)
def hold(
    contact: ContactState,
    probe: SdfSample,
    at: Prediction,
    thickness: np.ndarray,
    push: np.ndarray,
    damping: np.ndarray,
    aims: bool,
) -> None:
    """Hold the active points that touch: add their forces, push - damping v, in place.

    probe      probe of the body at the prediction
    aims       decide first which of them touch, and where these are to go; False: all is known
    thickness  contact distance of points [m], (P,)
    push       [N], (P, 3); damping [kg/s], (P, 6)
    """
    for chunk in prange((len(thickness) + _CHUNK - 1) // _CHUNK):
        for i in range(chunk * _CHUNK, min((chunk + 1) * _CHUNK, len(thickness))):
            if at.active[i]:
                if aims and contact.state[i] != INSIDE:  # What rises has its target already (`rise`).
                    _aim(contact, probe, i, at.velocities, thickness[i], at.masses[i], at.weights[i])
                if contact.state[i] != FREE:
                    _add_hold(contact, i, push, damping)


@inlined
def _aim(contact, probe, i, v, thickness, mass, h):
    """Decide whether point i touches, and where it is to go."""
    phi = probe.distance[i]
    # Hysteresis: a point that touches is held a little farther out than where a free one is caught.
    if contact.state[i] == FREE:
        near = -_NEAR * contact.length if contact.freed[i] else 0.0
    else:
        near = _lead(contact, probe, i, v, h)
    nx, ny, nz = probe.normal[i, 0], probe.normal[i, 1], probe.normal[i, 2]
    if not (phi < thickness + near and mass < np.inf and nx * nx + ny * ny + nz * nz > 0.5):
        contact.discontinuous[i] |= contact.state[i] != FREE
        contact.state[i] = FREE
        return
    old = contact.normal[i]
    if contact.state[i] == FREE or old[0] * nx + old[1] * ny + old[2] * nz < _TURNED:
        contact.discontinuous[i] = True
        contact.slid[i] = 0.0
    c_n = STIFF * mass / h
    if contact.state[i] == FREE:
        contact.state[i] = NEW  # The first solve finds its load and its speed without friction.
        contact.c_t[i] = 0.0
    bx, by, bz = probe.velocity[i, 0], probe.velocity[i, 1], probe.velocity[i, 2]
    body = bx * nx + by * ny + bz * nz
    speed = v[i, 0] * nx + v[i, 1] * ny + v[i, 2] * nz + (thickness - phi) / h
    # Bounded, so that hair which begins too near is moved out gently.
    extra = min(speed - body, PUSH_OUT * contact.speed)
    # What sticks, c_t = c_n, goes on sticking though c_n differs in this stage; what slides keeps its damper.
    contact.c_t[i] = c_n if contact.c_t[i] >= contact.c_n[i] > 0.0 else min(contact.c_t[i], c_n)
    contact.c_n[i] = c_n
    contact.body[i] = body
    contact.normal[i, 0], contact.normal[i, 1], contact.normal[i, 2] = nx, ny, nz
    contact.target[i, 0], contact.target[i, 1], contact.target[i, 2] = bx + extra * nx, by + extra * ny, bz + extra * nz


@inlined
def _lead(contact, probe, i, v, h):
    """Return how far outside point i is still held: a straight way leads it off a body that it slides around."""
    return _NEAR * contact.length + h * _slip(probe, i, v)


@inlined
def _slip(probe, i, v):
    """Return how fast point i goes against the body [m/s]."""
    ux, uy, uz = v[i, 0] - probe.velocity[i, 0], v[i, 1] - probe.velocity[i, 1], v[i, 2] - probe.velocity[i, 2]
    return np.sqrt(ux * ux + uy * uy + uz * uz)


@inlined
def _add_hold(contact, i, push, damping):
    c, n, w = contact.c_t[i], contact.normal[i], contact.target[i]
    more = contact.c_n[i] - c
    pull = more * (w[0] * n[0] + w[1] * n[1] + w[2] * n[2])
    for a in range(3):
        push[i, a] += c * w[a] + pull * n[a]
    damping[i, 0] += c + more * n[0] * n[0]
    damping[i, 1] += more * n[0] * n[1]
    damping[i, 2] += more * n[0] * n[2]
    damping[i, 3] += c + more * n[1] * n[1]
    damping[i, 4] += more * n[1] * n[2]
    damping[i, 5] += c + more * n[2] * n[2]
    _ease_start(contact, i, push, damping)


@inlined
def _ease_start(contact, i, push, damping):
    """Replace a part of the damping along the motion of what speeds up by a constant force, in place."""
    u, w = contact.slid[i], contact.target[i]
    squared = u[0] * u[0] + u[1] * u[1] + u[2] * u[2]
    if squared > 0.0 and contact.c_t[i] < contact.c_n[i]:
        c = _constant_part(contact, squared) * contact.c_t[i]
        less = c / squared
        along = less * (w[0] * u[0] + w[1] * u[1] + w[2] * u[2])
        for a in range(3):
            push[i, a] -= (c + along) * u[a]
        damping[i, 0] -= less * u[0] * u[0]
        damping[i, 1] -= less * u[0] * u[1]
        damping[i, 2] -= less * u[0] * u[2]
        damping[i, 3] -= less * u[1] * u[1]
        damping[i, 4] -= less * u[1] * u[2]
        damping[i, 5] -= less * u[2] * u[2]


@inlined
def _constant_part(contact, squared):
    """Return 1 - u/s, the constant part of friction at the square of a speed of sliding [m^2/s^2]."""
    return max(0.0, 1.0 - np.sqrt(squared) / (_SLOW * contact.speed))


@njit(cache=True, parallel=True)
def update_active_set(
    contact: ContactState, probe: SdfSample, at: Prediction, thickness: np.ndarray, friction: float, changed: np.ndarray
) -> None:
    """Update the active set after a solve: set changed, (P,) bool, for active points to solve again, in place.

    probe  probe of the body at the present points; the others as for `hold`
    """
    near = _NEAR * contact.length
    for chunk in prange((len(changed) + _CHUNK - 1) // _CHUNK):
        for i in range(chunk * _CHUNK, min((chunk + 1) * _CHUNK, len(changed))):
            changed[i] = False
            if at.active[i] and at.masses[i] < np.inf:
                if contact.state[i] == FREE:
                    phi = probe.distance[i]
                    moved = probe.normal[i, 0] != 0.0 or probe.normal[i, 1] != 0.0 or probe.normal[i, 2] != 0.0
                    changed[i] = moved and phi < thickness[i] - (2 * near if contact.freed[i] else near)
                elif contact.state[i] != INSIDE:
                    changed[i] = _update_touching(contact, i, at.velocities, friction)


@inlined
def _update_touching(contact, i, v, friction):
    """Update the friction of point i, or let it go; tell whether it must be solved again."""
    c, n, w = contact.c_n[i], contact.normal[i], contact.target[i]
    ux, uy, uz = v[i, 0] - w[0], v[i, 1] - w[1], v[i, 2] - w[2]
    normal = ux * n[0] + uy * n[1] + uz * n[2]
    if normal > 0.0:  # The body would have to pull: the contact opens, and the strand is solved again without it.
        contact.state[i] = FREE
        contact.freed[i] = contact.discontinuous[i] = True
        return True
    limit = -friction * c * normal
    is_new = contact.state[i] == NEW
    contact.state[i] = TOUCHES
    if limit <= 0.0:
        held = contact.c_t[i] > 0.0
        contact.c_t[i] = 0.0
        contact.slid[i] = 0.0
        return held
    tx, ty, tz = ux - normal * n[0], uy - normal * n[1], uz - normal * n[2]
    speed = np.sqrt(tx * tx + ty * ty + tz * tz)
    force = contact.c_t[i] * speed
    if contact.c_t[i] >= c:  # Sticks within the cone of friction, else it slides at the speed it would have alone.
        if force <= limit:
            return False
        contact.c_t[i] = coulomb(c, limit * c, STIFF * (force - limit))
        contact.slid[i] = 0.0
        return True
    speeds_up = force > limit
    u = contact.slid[i]
    squared = u[0] * u[0] + u[1] * u[1] + u[2] * u[2]
    if squared > 0.0:
        along = tx * u[0] + ty * u[1] + tz * u[2]
        if along <= 0.0:  # Friction turns no motion around.
            contact.slid[i] = 0.0
            return True
        force += _constant_part(contact, squared) * contact.c_t[i] * (squared - along) / np.sqrt(squared)
    # A fixed point: the damper that gives mu N at this speed; small errors are mended in later solves.
    contact.c_t[i] = coulomb(c, limit, speed)
    contact.slid[i, 0] = tx if speeds_up else 0.0
    contact.slid[i, 1] = ty if speeds_up else 0.0
    contact.slid[i, 2] = tz if speeds_up else 0.0
    return is_new or force > _ROUGH * limit


@njit(cache=True, parallel=True)
def stop_normals(contact: ContactState, v, distance, change) -> None:
    """Set change, (P, 3), to remove from v the speed that only corrected positions [m/s], in place.

    Contact is inelastic. Rising points keep their speed until they are outside.

    v  [m/s], (P, 3); distance  distance of the final points from the body [m], (P,)
    """
    for chunk in prange((len(v) + _CHUNK - 1) // _CHUNK):
        for i in range(chunk * _CHUNK, min((chunk + 1) * _CHUNK, len(v))):
            change[i] = 0.0
            if contact.state[i] != FREE and not (contact.state[i] == INSIDE and distance[i] < -DEEP * contact.length):
                n = contact.normal[i]
                excess = v[i, 0] * n[0] + v[i, 1] * n[1] + v[i, 2] * n[2] - contact.body[i]
                for a in range(3):
                    change[i, a] = -excess * n[a]
