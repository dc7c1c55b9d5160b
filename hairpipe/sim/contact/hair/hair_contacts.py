"""Hair against hair in one step: what sticks, what is pushed away, and what must not pass through."""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import reduce

import numpy as np

from hairpipe.sim.contact.ccd.collision import collide
from hairpipe.sim.contact.contact_points import REACH, Contacts, find_contacts
from hairpipe.sim.contact.hair.coupling_operator import (
    CouplingRows,
    coupling_rows,
    follow,
    impulses_after,
    multiply_across,
)
from hairpipe.sim.contact.hair.couplings import (
    Incidence,
    Joined,
    couplings_at,
    find_incidence,
    join,
    part_of,
)
from hairpipe.sim.contact.hair.exclusions import intersection, union
from hairpipe.sim.contact.hair.impulses import sweep
from hairpipe.sim.contact.hair.repulsion import linearise as linearise_contacts
from hairpipe.sim.contact.hair.stiction import Connections, connect, no_connections, release, room
from hairpipe.sim.contact.hair.stiction import linearise as linearise_connections
from hairpipe.sim.settings import Collisions, Stiction
from hairpipe.sim.solve import pcg
from hairpipe.spatial.mutual_nearest import closest_pairs
from hairpipe.spatial.pairs import Pairs, empty_pairs, key_of, within
from hairpipe.spatial.proximity import approaches, near_pairs, pairs_about

_TOLERANCE = 6e-2
"""Of what a solve moves points by, see `pcg.solve`: contact that is unequal from step to step hides the rest."""


@dataclass(eq=False)
class HairContacts:
    """Contact between strands within a frame.

    offsets      of the points of strands, (strands+1,) int32
    stiction     what sticks; None: nothing does
    collisions   what is pushed away; None: hair passes through hair
    connections  that there are at the moment
    at_rest      keys of pairs that do not stick, and of those that do not collide, because the groom has them so near
    crossed      pairs a segment that the last step had to keep from passing through each other
    """

    offsets: np.ndarray
    stiction: Stiction | None
    collisions: Collisions | None
    connections: Connections
    at_rest: tuple[np.ndarray, np.ndarray]
    crossed: float = field(default=0.0, init=False)
    _reach: float = field(init=False)
    _never: np.ndarray = field(init=False)
    _ignored: np.ndarray = field(init=False)
    _contacts: Contacts | None = field(default=None, init=False)
    _places: Joined = field(init=False)
    _incidence: Incidence = field(init=False)
    _sides: CouplingRows = field(init=False)
    _change: np.ndarray | None = field(default=None, init=False)

    def __post_init__(self) -> None:
        sought: list[tuple[float, np.ndarray]] = []
        if self.stiction is not None:
            sought.append((self.stiction.reach, self.at_rest[0]))
        if self._coupled is not None:
            sought.append((REACH * self._coupled.thickness, self.at_rest[1]))
        # One search finds both: what is within the longer reach, and not left out by either.
        self._reach = max((reach for reach, _ in sought), default=0.0)
        self._never = reduce(intersection, [keys for _, keys in sought]) if sought else np.empty(0, np.int64)

    def begin(self, points: np.ndarray, speeds: np.ndarray) -> None:
        """Look around at the start of a step: connections break and are made, contacts are found."""
        if self.stiction is not None:
            self.connections = release(self.connections, points, self.stiction.release)
        pairs = self._meet(points)
        if self.collisions is not None:
            self._ignored = union(self.at_rest[1], key_of(self.connections.segments))
        if self._coupled is not None:
            self._contacts = find_contacts(pairs, points, speeds, self._coupled)
        self._places = join(self.connections, *([] if self._contacts is None else [self._contacts]))
        if self._contacts is not None:
            # Not the same twice: it is what most memory goes into.
            stuck = len(self.connections.segments)
            at = {"segments": self._places.segments[stuck:], "fractions": self._places.fractions[stuck:]}
            self._contacts = self._contacts._replace(**at)
        self._incidence = find_incidence(self._places.segments, len(points))

    def _meet(self, points: np.ndarray) -> Pairs:
        """Connect what has come near, and return the pairs that may touch in this step."""
        if not self._reach:
            return empty_pairs()
        count, stuck = len(points), key_of(self.connections.segments)
        near, fresh = pairs_about(points, self.offsets, self._reach, union(self._never, stuck)), empty_pairs()
        if self.stiction is not None:
            may, most = within(near, count, self.stiction.reach, self.at_rest[0]), self.stiction.closest
            fresh = closest_pairs(points, near, may, most, room(self.connections, count, most))
            self.connections = connect(self.connections, fresh)
        if self._coupled is None:
            return empty_pairs()
        aside = union(self.at_rest[1], key_of(fresh.segments))
        return approaches(near, within(near, count, REACH * self._coupled.thickness, aside))

    def linearise(
        self,
        points: np.ndarray,
        speeds: np.ndarray,
        lagged_velocity: np.ndarray,
        masses: np.ndarray,
        weights: np.ndarray,
        span: float,
        active: np.ndarray,
    ) -> None:
        """Linearise what strands do to each other at a prediction; see `couplings.py` for weights, (P,), and span.

        lagged_velocity  velocities that contacts and their friction go by [m/s], (P, 3); see `repulsion.py`
        active  points of strands that are solved, (P,) bool; what the others do to each other is left out
        """
        couplings, stuck = couplings_at(self._places), len(self.connections.segments)
        if self.stiction is not None:
            rest = part_of(couplings, 0, stuck)
            linearise_connections(self.connections, points, speeds, masses, self.stiction, weights, span, active, rest)
        if self._contacts is not None and self._coupled is not None:
            rest = part_of(couplings, stuck, len(couplings.acts))
            linearise_contacts(
                self._contacts, points, speeds, lagged_velocity, masses, self._coupled, weights, span, active, rest
            )
        self._sides, self._change = coupling_rows(couplings, self._incidence), None

    @property
    def own(self) -> tuple[np.ndarray, np.ndarray]:
        """Blocks by which impulses change with the strand's own velocities [kg], two of (P, 6) float32."""
        return self._sides.diagonal, self._sides.following

    def impulses(self, active: np.ndarray, out: np.ndarray) -> None:
        """Set out, (P, 3) [N s], to what active points, (P,) bool, get where solves have left all of them, in place."""
        if self._change is None:
            np.copyto(out, self._sides.push, where=active[:, None])
        else:
            impulses_after(self._sides, self._change, active, out)

    def exchange(
        self, respond: Callable[[np.ndarray, np.ndarray], None], alone: np.ndarray, masses: np.ndarray
    ) -> np.ndarray:
        """Return the impulses that strands exchange [N s], (P, 3) float32; see `pcg.solve`."""

        def multiply(v: np.ndarray, start: np.ndarray, out: np.ndarray) -> None:
            multiply_across(self._sides, v, start, out)

        return pcg.solve(respond, multiply, alone, masses, _TOLERANCE).impulses

    def follow(self, change: np.ndarray, active: np.ndarray, received: np.ndarray) -> None:
        """Take note that a solve changed velocities of active points, (P,) bool, by so much [m/s], (P, 3).

        received  what they got at first, with what was exchanged; out: what they got in the end [N s], (P, 3)

        What was exchanged stands for -O dv: contact is so stiff that the small error left in dv would be a great
        impulse.
        """
        if self._change is None:
            self._change = np.zeros(change.shape)
        follow(self._sides, change, active, self._change, received)

    def let_go(self) -> None:
        """Free what only the solves of a step need."""
        self._places, self._contacts = join(no_connections()), None
        self._incidence = find_incidence(self._places.segments, 0)
        self._sides = coupling_rows(couplings_at(self._places), self._incidence)

    def collide(self, before: np.ndarray, after: np.ndarray, masses: np.ndarray, dt: float) -> np.ndarray | None:
        """Return by how much velocities change so that nothing passes through in a step of dt [s], or None.

        before, after  positions [m], (P, 3)
        """
        if self.collisions is None:
            return None
        outcome = collide(before, after, masses, self.offsets, dt, self.collisions, self._ignored)
        self.crossed = outcome.found / (len(before) - len(self.offsets) + 1)
        return outcome.change if outcome.found else None

    @property
    def _coupled(self) -> Collisions | None:
        """What is pushed away in the system of all strands."""
        return None if self.sweeps else self.collisions

    @property
    def sweeps(self) -> bool:
        """Whether what is near pushes by impulses, as published, and not in the system of all strands."""
        return self.collisions is not None and self.collisions.solver == "sweep"

    def repel(self, points: np.ndarray, speeds: np.ndarray, masses: np.ndarray, dt: float, *, elastic: bool) -> None:
        """Let what is near push by impulses in a step of dt [s], if it `sweeps`; changes speeds, in place."""
        if self.collisions is not None and self.sweeps:
            pairs = near_pairs(points, self.offsets, REACH * self.collisions.thickness, self._ignored)
            sweep(pairs, points, speeds, masses, self.collisions, dt, elastic=elastic)
