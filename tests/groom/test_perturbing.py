"""Members of an ensemble of grooms."""

from dataclasses import replace

import numpy as np
import pytest

from hairpipe.errors import BadInput
from hairpipe.groom.sampling import perturbed
from hairpipe.groom.strands import lay_strands
from hairpipe.values.groom import segment_lengths
from hairpipe.values.strand_arrays import take

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
