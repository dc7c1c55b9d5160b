"""Hair against hair in one step: what sticks, what is pushed away, and what must not pass through.

Pairs excluded from contact: connected by stiction, or close to each other in the groom.

A set of pairs is a sorted array of keys without duplicates, see `key_of`.
"""

from dataclasses import dataclass, field, replace
from functools import partial, reduce
from typing import ClassVar, TypeVar

import numpy as np
from numba import njit, prange

from hairpipe.contact.collision import collide
from hairpipe.contact.contact_points import REACH, USUAL, Contacts, Scale, find_contacts
from hairpipe.contact.repulsion import anchor, no_shear, sheared, sweep
from hairpipe.contact.repulsion import linearise as linearise_contacts
from hairpipe.contact.stiction import Connections, connect, no_connections, release, room, same_hair_keys, stiffest
from hairpipe.contact.stiction import linearise as linearise_connections
from hairpipe.geometry.proximity import approaches, closest_pairs, near_pairs
from hairpipe.geometry.segments import Pairs, empty_pairs, key_of, renumbered, within
from hairpipe.laws.settings import Collisions, Stiction, Thickness
from hairpipe.solve.couplings import Couplings, Joined, join, part_of
from hairpipe.solve.interactions import Interaction, Prediction, Start, StepEnd
from hairpipe.strands.hair_model import HairModel
from hairpipe.values.hair import HairState, Shear
from hairpipe.values.painting import Varied

V = TypeVar("V", bound=Varied)
_PART = 1 << 15
"""Keys that one thread merges at a time."""
REST = 1.5
"""Pairs that the groom has within so many thicknesses are ignored for ever, as in the authors' code."""


def union(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return the union of two sets of pairs, (n,) and (m,) int64; pure."""
    many, few = (a, b) if len(a) >= len(b) else (b, a)
    if not len(few):
        return many
    out = np.empty(len(a) + len(b), np.int64)
    parts = len(out) // _PART + 1
    of_many = len(many) * np.arange(parts + 1) // parts
    of_few = np.concatenate([[0], np.searchsorted(few, many[of_many[1:-1]]), [len(few)]])  # Equal keys: in one part.
    ends = np.empty(parts, np.int64)
    _unite(many, few, of_many, of_few, out, ends)
    begins = of_many + of_few
    if (ends == begins[1:]).all():
        return out
    return np.concatenate([out[begin:end] for begin, end in zip(begins.tolist(), ends.tolist(), strict=False)])


@njit(cache=True, parallel=True)
def _unite(a, b, of_a, of_b, out, ends):
    """Merge parts of a and of b, which begin where stated, to out, each up to its end, in place."""
    for part in prange(len(ends)):
        i, j = of_a[part], of_b[part]
        i_end, j_end = of_a[part + 1], of_b[part + 1]
        place = i + j
        while i < i_end or j < j_end:
            from_a = j == j_end or (i < i_end and a[i] <= b[j])
            from_b = i == i_end or (j < j_end and b[j] <= a[i])
            out[place] = a[i] if from_a else b[j]
            i, j = i + from_a, j + from_b  # A key in both sets moves both on: written once.
            place += 1
        ends[part] = place


@dataclass(eq=False)
class HairContacts(Interaction):
    """Contact between strands within a frame.

    offsets      offsets of the points of strands, (strands+1,) int32
    stiction     settings of stiction; None: none
    collisions   settings of repulsion; None: hair passes through hair
    connections  present connections
    at_rest      keys of pairs close in the groom: those that do not stick, and those that do not collide
    widths       widths of segments: two of widths a and b have (a + b) / 2 times the distances of single hairs, (P,)
    grips        square roots of the forces of stiction of segments over that of the settings, (P,)
    thick        thicknesses of segments over that of the settings, (P,); two segments collide at their mean
    scale        factors on times and speeds of contact
    shear        tangential elongations of present contacts
    """

    couples: ClassVar[bool] = True
    offsets: np.ndarray
    stiction: Stiction | None
    collisions: Collisions | None
    connections: Connections
    at_rest: tuple[np.ndarray, np.ndarray]
    widths: np.ndarray
    grips: np.ndarray
    thick: np.ndarray
    scale: Scale = USUAL
    shear: Shear = field(default_factory=no_shear)
    _crossed: float = field(default=0.0, init=False)
    _reach: float = field(init=False)
    _near: np.ndarray = field(init=False)
    _apart: np.ndarray = field(init=False)
    _never: np.ndarray = field(init=False)
    _ignored: np.ndarray = field(init=False)
    _began: Start = field(init=False)
    _contacts: Contacts | None = field(default=None, init=False)
    _anchors: np.ndarray = field(init=False)
    _places: Joined = field(init=False)

    def __post_init__(self) -> None:
        self._apart = self.widths * self.thick
        sought: list[tuple[float, np.ndarray, np.ndarray]] = []
        if self.stiction is not None:
            sought.append((self.stiction.reach, self.widths, self.at_rest[0]))
        if self._coupled is not None:
            sought.append((REACH * self._coupled.thickness.value, self._apart, self.at_rest[1]))
        # One search finds both: what is within the longer reach, and not left out by either.
        self._reach = max((reach for reach, *_ in sought), default=0.0)
        near = [widths * (reach / self._reach) for reach, widths, _ in sought]
        self._near = reduce(np.maximum, near, np.zeros_like(self.widths))
        both = partial(np.intersect1d, assume_unique=True)
        self._never = reduce(both, [keys for *_, keys in sought]) if sought else np.empty(0, np.int64)

    def begin(self, start: Start) -> None:
        """Update connections and find contacts at the start of a step."""
        self._began = start
        points, velocities = start.points, start.velocities
        if self.stiction is not None:
            self.connections = release(self.connections, points, self.stiction.release, self.widths)
        pairs, shares = self._meet(points)
        if self.collisions is not None:
            self._ignored = union(self.at_rest[1], key_of(self.connections.segments))
        if self._coupled is not None:
            self._contacts = find_contacts(pairs, points, velocities, self._coupled, self._apart, self.scale, shares)
            self._anchors = anchor(self._contacts, points, self.shear, self._coupled)
        self._places = join(self.connections, *([] if self._contacts is None else [self._contacts]))
        if self._contacts is not None:
            # Not the same twice: it is what most memory goes into.
            stuck = len(self.connections.segments)
            at = {"segments": self._places.segments[stuck:], "fractions": self._places.fractions[stuck:]}
            self._contacts = self._contacts._replace(**at)

    def _meet(self, points: np.ndarray) -> tuple[Pairs, np.ndarray]:
        """Connect what has come near, and return the pairs that may touch in this step."""
        if not self._reach:
            return empty_pairs(), np.empty(0)
        count = len(points)
        stuck = key_of(self.connections.segments)
        known = union(self._never, stuck)
        fresh = empty_pairs()
        near = near_pairs(points, self.offsets, self._reach, known, self._near, exact=False)
        if self.stiction is not None:
            may = within(near, count, self.stiction.reach, self.at_rest[0], self.widths)
            if not self.grips.all():  # What does not stick takes no place among the closest.
                may &= self.grips[near.segments].all(axis=1)
            most = self.stiction.closest
            fresh = closest_pairs(points, near, may, most, room(self.connections, count, most))
            self.connections = connect(self.connections, fresh)
        if self._coupled is None:
            return empty_pairs(), np.empty(0)
        aside = union(self.at_rest[1], key_of(fresh.segments))
        return approaches(near, within(near, count, REACH * self._coupled.thickness.value, aside, self._apart), points)

    @property
    def places(self) -> Joined:
        """Pairs of segments of connections, then those of contacts."""
        return self._places

    def couple(self, at: Prediction, couplings: Couplings) -> None:
        """Linearise what strands do to each other at a prediction, in place."""
        stuck = len(self.connections.segments)
        if self.stiction is not None:
            own = part_of(couplings, 0, stuck)
            linearise_connections(self.connections, self._began, at, self.stiction, own, self.widths, self.grips)
        if self._contacts is not None and self._coupled is not None:
            rest = part_of(couplings, stuck, len(couplings.acts))
            linearise_contacts(self._contacts, self._anchors, at, self._coupled, rest, self.scale)

    def finish_solves(self, end: StepEnd) -> None:
        """Note how far contacts have slid in a step, and free what only its solves need."""
        if self._contacts is not None:
            self.shear = sheared(self._contacts, end.points, self._anchors)
        self._places = join(no_connections())
        self._contacts = None

    def correct(self, end: StepEnd) -> None:
        """Bring back hair that passed through hair in a step, in place."""
        if self.collisions is not None:
            before, after = end.points_before, end.points
            rules = self.collisions, self._ignored, self.thick
            outcome = collide(before, after, end.masses, self.offsets, end.dt, *rules)
            self._crossed = outcome.found / (len(before) - len(self.offsets) + 1)
            if outcome.found:
                end.move(outcome.change, end.dt)
                end.push(outcome.change)

    @property
    def crossed(self) -> float:
        """Pairs a segment that the last step had to keep from passing through each other."""
        return self._crossed

    def stiffness_bound(self, masses: np.ndarray) -> float:
        """Bound what stiction adds to the square of the highest frequency [1/s^2]."""
        return 0.0 if self.stiction is None else stiffest(self.connections, masses, self.stiction, self.grips)

    def remember(self, state: HairState) -> HairState:
        """Return the state with the connections and contacts that there are; pure."""
        return replace(state, stuck=self.connections.segments, stuck_at=self.connections.fractions, shear=self.shear)

    @property
    def _coupled(self) -> Collisions | None:
        """Contacts in the system of all strands."""
        return None if self.sweeps else self.collisions

    @property
    def sweeps(self) -> bool:
        """Whether what is near pushes by impulses, as published, and not in the system of all strands."""
        return self.collisions is not None and self.collisions.solver == "sweep"

    def repel(self, end: StepEnd, *, elastic: bool) -> None:
        """Apply impulses between near segments, if the solver `sweeps`, in place."""
        if self.collisions is not None and self.sweeps:
            points, velocities = end.points, end.velocities
            slowed = velocities.copy()
            reach = REACH * self.collisions.thickness.value
            pairs = near_pairs(points, self.offsets, reach, self._ignored, self.thick)
            sweep(pairs, points, slowed, end.masses, self.collisions, end.dt, self.thick, elastic=elastic)
            end.push(slowed - velocities)


def hair_contacts_of(
    hair: HairModel, state: HairState, stiction: Stiction | None, collisions: Collisions | None, scale: Scale
) -> HairContacts:
    """Make what hair does to hair pair by pair: of a setting that varies its largest value, and factors of segments."""
    at_rest = pairs_at_rest(hair, stiction, collisions)
    single = np.ones(hair.layout.offsets[-1])
    grips = thick = single
    if stiction is not None:
        force, factors = factored(stiction.force, hair, "stiction.force")
        stiction = replace(stiction, force=force)
        grips = np.sqrt(factors)
    if collisions is not None:
        thickness, thick = factored(collisions.thickness, hair, "collisions.thickness")
        collisions = replace(collisions, thickness=thickness)
    stuck = Connections(state.stuck, state.stuck_at)
    widths = single if hair.widths is None else hair.widths
    shear = state.shear or no_shear()
    return HairContacts(hair.layout.offsets, stiction, collisions, stuck, at_rest, widths, grips, thick, scale, shear)


def factored(setting: V, hair: HairModel, name: str) -> tuple[V, np.ndarray]:
    """Return the largest value of a setting on segments, as a setting, and the factors of segments on it, (P,)."""
    values = hair.values_of(setting, name)
    if np.ndim(values) == 0:
        return setting, np.ones(hair.layout.offsets[-1])
    largest = float(values[1].max())
    return type(setting)(largest), values[1] / (largest or 1.0)


def pairs_at_rest(
    hair: HairModel, stiction: Stiction | None, collisions: Collisions | None
) -> tuple[np.ndarray, np.ndarray]:
    """Return the keys of pairs that the groom has so near that they do not stick, and that they do not collide."""
    if hair.part_of is not None:
        whole, numbers = hair.part_of
        sticking, colliding = pairs_at_rest(whole, stiction, collisions)
        return renumbered(sticking, numbers), renumbered(colliding, numbers)
    points, offsets = hair.groom.points, hair.layout.offsets
    sticking = colliding = np.empty(0, np.int64)
    if stiction is not None:
        reach = stiction.reach
        sticking = hair.once(("stiction", reach), lambda: same_hair_keys(points, offsets, reach))
    if collisions is not None:
        colliding = hair.once(("at rest", collisions.thickness), lambda: _touching_at_rest(hair, collisions.thickness))
    return sticking, colliding


def _touching_at_rest(hair: HairModel, thickness: Thickness) -> np.ndarray:
    largest, factors = factored(thickness, hair, "collisions.thickness")
    near = near_pairs(hair.groom.points, hair.layout.offsets, REST * largest.value, None, factors)
    return key_of(near.segments)
