"""Hair against hair in one step: what sticks, what is pushed away, and what must not pass through."""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from hairpipe.sim.contact import conjugate
from hairpipe.sim.contact.collision import collide
from hairpipe.sim.contact.contacts import REACH, Contacts, find_contacts
from hairpipe.sim.contact.couplings import (
    Couplings,
    Incidence,
    add_push,
    exchanged,
    find_incidence,
    joined,
    multiply_across,
    own_blocks,
)
from hairpipe.sim.contact.ignored import keys_of
from hairpipe.sim.contact.near import near_pairs
from hairpipe.sim.contact.nearest import closest_pairs
from hairpipe.sim.contact.repulsion import linearise as linearise_contacts
from hairpipe.sim.contact.stiction import Connections, connect, release, room
from hairpipe.sim.contact.stiction import linearise as linearise_connections
from hairpipe.sim.contact.sweep import sweep
from hairpipe.sim.scene import Collisions, Stiction

_TOLERANCE = 3e-2
"""Of the velocities that coupling changes, in the norm of the mass: half the iterations of 1e-3."""


@dataclass(eq=False)
class HairContacts:
    """Contact between strands within a frame.

    offsets      of the points of strands, (strands+1,) int32
    stiction     what sticks; None: nothing does
    collisions   what is pushed away; None: hair passes through hair
    connections  that there are at the moment
    at_rest      keys of pairs that do not stick, and of those that do not collide, because the groom has them so near
    """

    offsets: np.ndarray
    stiction: Stiction | None
    collisions: Collisions | None
    connections: Connections
    at_rest: tuple[np.ndarray, np.ndarray]
    _ignored: np.ndarray = field(init=False)
    _contacts: Contacts | None = field(default=None, init=False)
    _couplings: Couplings = field(init=False)
    _incidence: Incidence = field(init=False)
    _exchanged: np.ndarray = field(init=False)

    def begin(self, points: np.ndarray, speeds: np.ndarray, masses: np.ndarray) -> None:
        """Look around at the start of a step: connections break and are made, contacts are found."""
        if self.stiction is not None:
            count, most = len(points), self.stiction.closest
            self.connections = release(self.connections, points, self.stiction.release)
            free = room(self.connections, count, most)
            taken = np.union1d(self.at_rest[0], keys_of(self.connections.segments))
            near = closest_pairs(points, self.offsets, self.stiction.reach, most, taken, free)
            self.connections = connect(self.connections, near)
        if self.collisions is not None:
            self._ignored = np.union1d(self.at_rest[1], keys_of(self.connections.segments))
        if self.collisions is not None and self.collisions.solver == "coupled":
            pairs = near_pairs(points, self.offsets, REACH * self.collisions.thickness, self._ignored)
            self._contacts = find_contacts(pairs, points, speeds, self.collisions)
        segments = [self.connections.segments] + ([self._contacts.segments] if self._contacts is not None else [])
        self._incidence = find_incidence(np.concatenate(segments), len(points))

    def linearise(
        self,
        points: np.ndarray,
        speeds: np.ndarray,
        masses: np.ndarray,
        h: float,
        span: float,
        push: np.ndarray,
        diagonal: np.ndarray,
        following: np.ndarray,
    ) -> None:
        """Linearise what strands do to each other at a prediction, and add each strand's own part of it, in place.

        h, span  weight of the stage's end, and the time that the stage covers [s]: what strands do to each other is no
                 part of accelerations, so in a stage it acts all that time
        push     [N s], (P, 3); diagonal, following  [kg], (P, 6): see `own_blocks`
        """
        sets = []
        if self.stiction is not None:
            sets.append(linearise_connections(self.connections, points, speeds, masses, self.stiction, h))
        if self._contacts is not None and self.collisions is not None:
            sets.append(linearise_contacts(self._contacts, points, speeds, masses, self.collisions, h))
        all_of_it = joined(sets)
        share = span / h
        self._couplings = all_of_it._replace(push=share * all_of_it.push, matrix=share * all_of_it.matrix)
        add_push(self._couplings, self._incidence, push)
        own_blocks(self._couplings, self._incidence, diagonal, following)

    def part(self) -> None:
        """Let strands exchange nothing in the next solve."""
        self._exchanged = np.zeros((self.offsets[-1], 3))

    def exchange(
        self, respond: Callable[[np.ndarray, np.ndarray], None], alone: np.ndarray, masses: np.ndarray
    ) -> np.ndarray:
        """Return the impulses that strands exchange [N s], (P, 3); see `conjugate.solve`."""

        def multiply(v: np.ndarray, out: np.ndarray) -> None:
            multiply_across(self._couplings, self._incidence, v, out)

        self._exchanged = conjugate.solve(respond, multiply, alone, masses, _TOLERANCE).impulses.copy()
        return self._exchanged

    def impulses(self, change: np.ndarray) -> np.ndarray:
        """Return the impulses that points got from other strands in a solve which changed velocities so, (P, 3).

        What was exchanged replaces -O dv: contact is so stiff that the small error left in dv would be a great impulse.
        """
        out = self._exchanged.copy()
        add_push(exchanged(self._couplings, change), self._incidence, out)
        multiply_across(self._couplings, self._incidence, change, out)
        return out

    def collide(self, before: np.ndarray, after: np.ndarray, speeds: np.ndarray, masses: np.ndarray, dt: float) -> None:
        """Bring back what passed through each other in a step of dt [s]; changes after and speeds, in place."""
        if self.collisions is not None:
            collide(before, after, speeds, masses, self.offsets, dt, self.collisions, self._ignored)

    def repel(self, points: np.ndarray, speeds: np.ndarray, masses: np.ndarray, dt: float, *, elastic: bool) -> None:
        """Let what is near push by impulses, as published, in a step of dt [s]; changes speeds, in place."""
        if self.collisions is not None and self.collisions.solver == "sweep":
            pairs = near_pairs(points, self.offsets, REACH * self.collisions.thickness, self._ignored)
            sweep(pairs, points, speeds, masses, self.collisions, dt, elastic=elastic)
