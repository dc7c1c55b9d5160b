"""Stacks: coupled contact carries them, impulses pair by pair need ever more sweeps."""

import numpy as np
import pytest

from hairpipe.graphs.experiments.studies.contact.rod_pile import GRAVITY, MASS, opening, pile_up, relative, resting
from hairpipe.graphs.experiments.studies.contact.stack import coupled, fall_coupled, landing_table, standing_table
from hairpipe.laws.settings import Collisions

LAW, DT = Collisions(), 1 / 800


def test_springs_of_a_resting_stack_carry_what_is_above_them_and_nothing_moves():
    pile = pile_up(resting(12, LAW))
    contacts = pile.contacts(LAW)
    touching = contacts.loads > 0
    assert touching.sum() == 12 * 4
    forces = relative(contacts, len(pile.points)).T @ (contacts.normals * contacts.loads[:, None]).ravel()
    np.testing.assert_allclose(forces.reshape(-1, 3)[4:], np.tile([0, MASS * GRAVITY, 0], (48, 1)), atol=1e-12)
    before = pile.points.copy()
    for _ in range(80):
        fall_coupled(pile, LAW, DT)
    np.testing.assert_allclose(pile.points, before, atol=1e-10)


def test_a_stack_that_lands_stands_if_contact_is_coupled_and_not_after_three_sweeps():
    table = standing_table(LAW, DT, (8,), (3,), 0.3)
    heights = dict(zip(table["solver"], table["height of the top [%]"], strict=True))
    assert heights["coupled"] == pytest.approx(100.0, abs=0.1) and heights["3 sweeps"] < 80
    assert table.numbers["fastest point [mm/s]"][list(table["solver"]).index("coupled")] < 0.01


def test_it_does_not_tremble_or_slide_when_disturbed():
    pile = pile_up(resting(8, LAW))
    rng = np.random.default_rng(2)
    pile.velocities[4:] += 0.02 * rng.normal(size=(32, 3))
    for _ in range(400):
        fall_coupled(pile, LAW, DT)
    assert np.linalg.norm(pile.velocities, axis=1).max() < 1e-4
    assert np.abs(opening(pile.contacts(LAW), pile.velocities)).max() < 1e-5


def test_sweeps_grow_with_the_square_of_the_height_and_iterations_with_the_height():
    table = landing_table(LAW, DT, (4, 8), 1000)
    needed = {}
    for name in dict.fromkeys(table["solver"]):
        mine = np.array([other == name for other in table["solver"]])
        error = table.numbers["error [% of the speed of fall]"][mine]
        needed[name] = int(np.flatnonzero(error < 1.0)[0])
    assert needed["coupled, 8 layers"] <= 8 + 1 and needed["coupled, 4 layers"] <= 4 + 1
    assert needed["sweep, 8 layers"] > 2.8 * needed["sweep, 4 layers"] > 2.8 * 4


def test_iterations_do_not_depend_on_a_stiffer_spring():
    assert len(coupled(Collisions(stiffness=50.0), DT, 6)) <= 8
