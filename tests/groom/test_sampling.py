"""Samples, unions and ensembles of grooms."""

from dataclasses import replace

import numpy as np
import pytest

from hairpipe.body.scripted_motion import Track, drive
from hairpipe.errors import BadInput
from hairpipe.groom.growing import grow
from hairpipe.groom.resampling import Cut
from hairpipe.groom.sampling import choose_patches, joined_ends, joined_strands, perturbed, sample_patches
from hairpipe.groom.settings import Style
from hairpipe.groom.strands import lay_strands
from hairpipe.values import Groom
from hairpipe.values.groom import segment_lengths
from hairpipe.values.painting import Canvas
from hairpipe.values.strand_arrays import take


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


def test_strands_and_ends_stay_together():
    one = lay_strands(2, 0.1, 5, (1.0, 0.0, 0.0), (0.0, 0.0, 0.01), None, 0.0)
    two = lay_strands(1, 0.2, 8, (0.0, 1.0, 0.0), (0.0, 0.0, 0.01), None, 0.0)
    both = joined_strands((one, two))
    assert both.offsets.tolist() == [0, 6, 12, 21] and both.ids.tolist() == [0, 1, 2]
    assert both.offsets.dtype == both.ids.dtype == np.int32
    np.testing.assert_array_equal(both.points, np.concatenate([one.points, two.points]))
    np.testing.assert_array_equal(both.root_frames[2], two.root_frames[0])
    led = (
        drive(one, 0.0, Track(), None, None, None),
        drive(two, 0.0, Track((0.0,), ((1.0, 2.0, 3.0),)), None, Track(), None),
    )
    ends = joined_ends(led)
    assert ends.roots.shape == (3, 3, 4) and ends.roots[2, :, 3].tolist() == [1.0, 2.0, 3.0]
    assert np.isnan(ends.tips[:2]).all() and np.isfinite(ends.tips[2]).all()


def test_grooms_become_groups_by_name():
    one, two, three = (lay_strands(n, 0.1, 5, (1.0, 0.0, 0.0), (0.0, 0.0, 0.01), None, 0.0) for n in (2, 1, 3))
    both = joined_strands((one, two, three), ("fringe", "beard", "fringe"))
    assert [both.group_names[group] for group in both.groups] == ["fringe"] * 2 + ["beard"] + ["fringe"] * 3
    with pytest.raises(BadInput, match="2 names for 3 grooms"):
        joined_strands((one, two, three), ("fringe", "beard"))


TIP = 1e-3
GROOM = lay_strands(400, 0.25, 4, (0.0, -1.0, 0.0), (0.001, 0.0, 0.0), None, 0.05)
TIPS = GROOM.offsets[1:] - 1


def test_member_0_is_the_groom_itself():
    assert perturbed(GROOM, 0, TIP) is GROOM


def test_tips_move_across_the_strand_by_as_much_as_is_asked_and_roots_not_at_all():
    moved = perturbed(GROOM, 1, TIP).points - GROOM.points
    assert np.all(moved[GROOM.offsets[:-1]] == 0.0)
    line = GROOM.points[TIPS[0]] - GROOM.points[0]
    along = line / np.linalg.norm(line)
    side = np.array([1.0, 0.0, 0.0])
    for across in (side, np.cross(along, side)):
        offsets = moved[TIPS] @ across
        assert np.std(offsets) == pytest.approx(TIP, rel=0.1) and abs(offsets.mean()) < 3 * TIP / 20
    assert np.abs(moved[TIPS] @ along).max() < 20 * TIP**2 / 0.25


def test_strands_are_turned_rigidly():
    new = perturbed(GROOM, 2, 0.05)
    assert (
        np.abs(segment_lengths(new.points, new.offsets) / segment_lengths(GROOM.points, GROOM.offsets) - 1).max()
        < 1e-12
    )
    shapes = [groom.points.reshape(400, 5, 3) for groom in (GROOM, new)]
    grams = [np.einsum("sic,sjc->sij", p - p[:, :1], p - p[:, :1]) for p in shapes]
    assert np.allclose(*grams, rtol=0.0, atol=1e-15)


def test_perturbation_depends_on_strand_and_member_and_not_on_other_strands():
    few = np.array([7, 3, 250])
    alone, among = perturbed(take(GROOM, few), 1, TIP), take(perturbed(GROOM, 1, TIP), few)
    assert np.array_equal(alone.points, among.points) and np.array_equal(alone.ids, among.ids)
    tips = np.stack([(perturbed(GROOM, member, TIP).points - GROOM.points)[TIPS, 0] for member in (1, 2)])
    assert abs(np.corrcoef(tips)[0, 1]) < 0.2


def test_strands_with_a_held_tip_are_refused():
    held = replace(GROOM, tip_triangles=np.where(GROOM.ids == 5, 0, -1).astype(np.int32))
    with pytest.raises(BadInput, match="the tip is held of strands 5"):
        perturbed(held, 1, TIP)
