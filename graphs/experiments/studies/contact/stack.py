"""A stack of rods under both solvers of contact: their convergence, and whether the stack stands."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from scipy.sparse import bsr_matrix, csr_matrix
from scipy.sparse.linalg import cg, spsolve

from hairpipe.contact.repulsion import sheared
from hairpipe.graphs.experiments.studies.contact.rod_pile import (
    GRAVITY,
    MASS,
    Pile,
    opening,
    pile_up,
    resting,
    sweep_over,
    system,
)
from hairpipe.laws.settings import Collisions
from hairpipe.values import Table
from hairpipe.values.table import table_of_rows

DROP = 2e-5
"""Room between the layers of a stack that is let fall [m]."""
SMALLEST = 0.01
"""Error [%] that counts as none."""


def landing_table(law: Collisions, dt: float, layers: Sequence[int], iterations: int) -> Table:
    """Tabulate the error of the approach of pairs after each iteration, when a stack lands that fell for one step.

    dt          step [s]; layers  of each stack
    iterations  sweeps over all pairs, or of conjugate gradients in the coupled system
    """
    rows = []
    for count in layers:
        for name, errors in (("sweep", swept(law, dt, count)), ("coupled", coupled(law, dt, count))):
            for iteration, error in zip(range(iterations + 1), errors, strict=False):
                share = max(100 * error / (GRAVITY * dt), SMALLEST)
                rows.append((f"{name}, {count} layers", count, iteration, share))
                if share == SMALLEST:
                    break
    return table_of_rows(("solver", "layers", "iterations", "error [% of the speed of fall]"), rows)


def standing_table(law: Collisions, dt: float, layers: Sequence[int], sweeps: Sequence[int], seconds: float) -> Table:
    """Tabulate what becomes of stacks whose layers fall by 20 um each and should then stand.

    A top that fell to the bottom is at 0.

    dt       step [s]; layers  of each stack
    sweeps   of the published solver, in addition to the coupled one
    seconds  simulated
    """
    rows = []
    for count in layers:
        for name, rule in [(f"{n} sweeps", replace(law, sweeps=n)) for n in sweeps] + [("coupled", law)]:
            pile = pile_up(np.arange(count + 1) * (law.thickness.value + DROP))
            for _ in range(round(seconds / dt)):
                (fall_coupled if name == "coupled" else fall_swept)(pile, rule, dt)
            height = max(pile.points[-4:, 1].mean(), 0.0)
            speed = np.linalg.norm(pile.velocities, axis=1).max()
            rows.append((name, count, 100 * height / resting(count, law)[-1], 1e3 * speed))
    return table_of_rows(("solver", "layers", "height of the top [%]", "fastest point [mm/s]"), rows)


def swept(law: Collisions, dt: float, layers: int) -> Iterator[float]:
    """Yield the fastest approach of any pair that is left after 0, 1, 2 ... sweeps [m/s]: there should be none."""
    pile = landing(law, dt, layers)
    contacts = pile.contacts(law)
    while True:
        yield max(-float(opening(contacts, pile.velocities).min()), 0.0)
        sweep_over(pile, replace(law, sweeps=1), dt, elastic=False)


def coupled(law: Collisions, dt: float, layers: int) -> list[float]:
    """List the greatest error of any approach after 0, 1, 2 ... conjugate gradients [m/s]: of what is exact."""
    pile = landing(law, dt, layers)
    A, b, contacts, _ = system(pile, law, dt)
    exact = spsolve(A.tocsc(), b)
    found = [np.zeros_like(b)]
    cg(A, b, rtol=1e-10, atol=0.0, M=alone(A, 2 * layers), callback=lambda x: found.append(x.copy()))
    errors = [np.concatenate([np.zeros(12), x - exact]).reshape(-1, 3) for x in found]
    return [float(np.abs(opening(contacts, error)).max()) for error in errors]


def landing(law: Collisions, dt: float, layers: int) -> Pile:
    """Lay down a stack in equilibrium that has fallen freely for a step, as if its support had been away."""
    pile = pile_up(resting(layers, law))
    pile.velocities[4:, 1] = -GRAVITY * dt
    return pile


def alone(A: csr_matrix, count: int) -> bsr_matrix:
    """Invert the blocks of single rods, so many: the preconditioner."""
    rods = np.arange(count + 1)
    whole = A.toarray().reshape(count, 6, count, 6)
    return bsr_matrix((np.linalg.inv(whole[rods[:-1], :, rods[:-1]]), rods[:-1], rods))


def fall_swept(pile: Pile, law: Collisions, dt: float) -> None:
    """Advance by a step with impulses, in place."""
    pile.velocities[4:, 1] -= GRAVITY * dt
    sweep_over(pile, law, dt, elastic=True)
    pile.points += dt * pile.velocities


def fall_coupled(pile: Pile, law: Collisions, dt: float) -> None:
    """Advance by a linearly implicit step, in place."""
    A, b, contacts, anchors = system(pile, law, dt)
    b[1::3] -= MASS * GRAVITY * dt
    pile.velocities[4:] += spsolve(A.tocsc(), b).reshape(-1, 3)
    pile.points += dt * pile.velocities
    pile.shear = sheared(contacts, pile.points, anchors)
