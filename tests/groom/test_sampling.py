"""A sample of a groom: patches of neighbours."""

import numpy as np
import pytest

from hairpipe.errors import BadInput
from hairpipe.groom.growing import grow
from hairpipe.groom.resampling import Cut
from hairpipe.groom.sampling import choose_patches, sample_patches
from hairpipe.groom.settings import Style
from hairpipe.values import Groom
from hairpipe.values.painting import Canvas


@pytest.fixture(scope="module")
def groom(ball) -> Groom:
    return grow(Canvas(ball, lambda path: None, 0), Style(), None, 400, Cut(6))


def test_strands_are_those_of_the_groom(groom):
    sample = sample_patches(groom, 40, 4, 0)
    assert len(sample.ids) == 40 and len(sample.offsets) == 41
    for name in ("ids", "root_triangles", "root_barycentrics", "root_frames", "root_uv"):
        places = np.searchsorted(groom.ids, sample.ids)
        assert np.array_equal(getattr(sample, name), getattr(groom, name)[places])
    for strand, place in enumerate(places):
        mine = sample.points[sample.offsets[strand] : sample.offsets[strand + 1]]
        assert np.array_equal(mine, groom.points[groom.offsets[place] : groom.offsets[place + 1]])


def test_a_patch_is_made_of_neighbours_and_patches_are_all_over():
    roots = np.random.default_rng(3).uniform(size=(900, 3)) * (1.0, 1.0, 0.0)
    patches = choose_patches(roots, 16, 4, 0)
    centres = roots[patches].mean(axis=1)
    widest = max(np.linalg.norm(roots[p] - c, axis=1).max() for p, c in zip(patches, centres, strict=True))
    assert widest < 0.16  # a disc of 16 of 900 on the unit square has a radius of 0.075
    apart = np.linalg.norm(centres[:, None] - centres, axis=2)[np.triu_indices(4, 1)]
    assert apart.min() > 0.3


def test_samples_of_other_numbers_share_no_strand(groom):
    samples = [set(sample_patches(groom, 96, 4, number).ids) for number in range(3)]
    assert all(len(ids) == 96 for ids in samples) and len(set.union(*samples)) == 3 * 96


def test_a_small_groom_is_given_as_it_is_and_too_many_samples_are_refused(groom):
    assert sample_patches(groom, 400, 4, 0) is groom
    with pytest.raises(BadInput, match="too few for 5 samples of 96"):
        sample_patches(groom, 96, 4, 4)


def test_it_depends_on_roots_alone(groom, ball):
    finer = grow(Canvas(ball, lambda path: None, 0), Style(), None, 400, Cut(9))
    assert np.array_equal(sample_patches(groom, 40, 4, 1).ids, sample_patches(finer, 40, 4, 1).ids)
