"""Hair led to a density in simulations."""

import dataclasses
from itertools import pairwise

import numpy as np
import pytest

from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.measure.target import target_table
from hairpipe.laws.settings import Target, Volume
from hairpipe.shot.shot import Frame
from hairpipe.shot.simulate import next_state, strands_of
from hairpipe.values import Strands
from hairpipe.volume.density import density_of

CELL, LEVELS = 0.016, 4


def tuft(straight, lean, side=5, spacing=3e-3):
    """Hairs of 20 cm side by side that lean over by an angle [degrees]."""
    way = np.sin(np.radians(lean)), -np.cos(np.radians(lean)), 0.0
    return [
        straight(0.2, 12, way) + np.array([spacing * a, 0.0, spacing * b]) for a in range(side) for b in range(side)
    ]


def density_at(straight, lean):
    lines = tuft(straight, lean)
    points = np.concatenate(lines)
    offsets = (np.arange(len(lines) + 1) * len(lines[0])).astype(np.int32)
    return density_of(Strands(points, np.zeros(points.shape, np.float32), offsets, 8e-5), 0.006)


def led(scene, straight, densities, target, step=1 / 96, drag=40.0):
    """Lead hair that hangs straight to the second of each two densities; return it frame by frame."""
    shot = scene(tuft(straight, 0.0), gravity=0.0, drag=drag, model="chain", step=step)
    reported, state = dataclasses.replace(shot.scene, volume=Volume(target=target)), shot.state
    found = [strands_of(shot.hair, state)]
    for n, pair in enumerate(densities):
        frame = Frame((shot.body, shot.body), (), (), n / 24, 1 / 24, False, pair)
        state = next_state(shot.hair, state, frame, reported)
        found.append(strands_of(shot.hair, state))
    return found


def energies_of(found, density):
    frames = dict(enumerate(found))
    return target_table(frames, dict.fromkeys(frames, density), CELL, LEVELS)["of the first [1]"]


@pytest.mark.parametrize("step", [1 / 96, 1 / 24])
def test_hair_comes_to_where_the_density_is_and_never_strays_on_the_way(scene, straight, step):
    """In air that takes its speed away; the study of the method wants a tenth of the energy after 36 frames."""
    density = density_at(straight, 50.0)
    found = led(scene, straight, 36 * [(density, density)], Target(CELL, LEVELS), step)
    energies = energies_of(found, density)
    assert np.diff(energies).max() < 1e-5
    assert energies[-1] < 0.1
    lengths = np.linalg.norm(np.diff(found[-1].points.reshape(25, 13, 3), axis=1), axis=2).sum(axis=1)
    np.testing.assert_allclose(lengths, 0.2, rtol=0.02)


def test_hair_follows_a_density_that_moves(scene, straight):
    densities = [density_at(straight, lean) for lean in np.linspace(0.0, 50.0, 25)]
    still = led(scene, straight, 24 * [(densities[0], densities[0])], Target(CELL, LEVELS))
    moved = led(scene, straight, list(pairwise(densities)), Target(CELL, LEVELS))
    off, left = (target_table({0: hair[-1]}, {0: densities[-1]}, CELL, LEVELS) for hair in (moved, still))
    assert off["of no hair [1]"][0] < 0.2 * left["of no hair [1]"][0]


def test_a_target_without_a_group_and_a_group_without_a_target_are_refused(scene, straight):
    density = density_at(straight, 50.0)
    with pytest.raises(BadInput, match=r"requires in\.target"):
        led(scene, straight, [None], Target())
    with pytest.raises(BadInput, match=r"requires \[volume\.target\]"):
        led(scene, straight, [(density, density)], None)
