"""The couplings of strands in one stage, from all interactions, as one operator.

Strands exchange impulses until convergence, `pcg.py`; the own blocks of the couplings are part of each strand's
system. Strands that are solved again use the resulting positions of the others.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from hairpipe.sim.contact.hair.coupling_operator import (
    CouplingRows,
    coupling_rows,
    follow,
    impulses_after,
    multiply_across,
)
from hairpipe.sim.contact.hair.couplings import NOWHERE, Incidence, Places, couplings_at, find_incidence, join, part_of
from hairpipe.sim.interactions import Interaction, Prediction
from hairpipe.sim.solve import pcg
from hairpipe.sim.solve.external_terms import copy_active

_TOLERANCE = 6e-2
"""Relative, of the change of velocity, see `pcg.solve`: step-to-step noise of contact exceeds the remaining error."""


@dataclass(eq=False)
class StrandCoupling:
    """The couplings of a step; `begin` is called first, and `linearise` before the other methods.

    interactions  that couple strands, in the order of their couplings
    speed         factor on the speed of what rests [1], see `Scale`
    """

    interactions: Sequence[Interaction]
    speed: float = 1.0
    _places: Places = field(init=False)
    _bounds: np.ndarray = field(init=False)
    _incidence: Incidence = field(init=False)
    _rows: CouplingRows = field(init=False)
    _change: np.ndarray | None = field(default=None, init=False)

    def __bool__(self) -> bool:
        """Whether anything couples strands."""
        return len(self.interactions) > 0

    def begin(self, points: int) -> None:
        """Collect what a step couples, of so many points."""
        places = [interaction.places for interaction in self.interactions]
        self._places = places[0] if len(places) == 1 else join(*places)
        self._bounds = np.cumsum([0, *(len(some.segments) for some in places)])
        self._incidence = find_incidence(self._places.segments, points)

    def linearise(self, at: Prediction) -> None:
        """Linearise all couplings at a prediction."""
        couplings = couplings_at(self._places)
        for interaction, (first, last) in zip(self.interactions, pairwise(self._bounds.tolist()), strict=True):
            interaction.couple(at, part_of(couplings, first, last))
        self._rows = coupling_rows(couplings, self._incidence)
        self._change = None  # No solve has moved strands since these were linearised.

    @property
    def own(self) -> tuple[np.ndarray, np.ndarray]:
        """Blocks by which impulses change with the strand's own velocities [kg], two of (P, 6) float32."""
        return self._rows.diagonal, self._rows.following

    def impulses(self, active: np.ndarray, out: np.ndarray) -> None:
        """Set out, (P, 3) [N s], to what active points, (P,) bool, get where solves have left all of them, in place."""
        if self._change is None:
            copy_active(active, self._rows.push, out)
        else:
            impulses_after(self._rows, self._change, active, out)

    def exchange(
        self, respond: Callable[[np.ndarray, np.ndarray], None], alone: np.ndarray, masses: np.ndarray
    ) -> np.ndarray:
        """Return the impulses that strands exchange [N s], (P, 3) float32; see `pcg.solve`."""

        def multiply(v: np.ndarray, start: np.ndarray, out: np.ndarray) -> None:
            multiply_across(self._rows, v, start, out)

        return pcg.solve(respond, multiply, alone, masses, _TOLERANCE, pcg.STILL * self.speed).impulses

    def follow(self, change: np.ndarray, active: np.ndarray, received: np.ndarray) -> None:
        """Update for a solve that changed velocities of active points, (P,) bool, by a change [m/s], (P, 3).

        received  in: their first impulses with those exchanged; out: their final impulses [N s], (P, 3)

        The exchanged impulses replace -O dv: contact is so stiff that the small error of dv would be a large impulse.
        """
        if self._change is None:
            self._change = np.zeros(change.shape)
        follow(self._rows, change, active, self._change, received)

    def release(self) -> None:
        """Free what only the solves of a step need."""
        self._places = NOWHERE
        self._incidence = find_incidence(NOWHERE.segments, 0)
        self._rows = coupling_rows(couplings_at(NOWHERE), self._incidence)
