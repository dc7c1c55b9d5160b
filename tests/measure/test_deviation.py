"""Hair against the same hair in other segments, and patch by patch."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from hairpipe.body.scripted_motion import Track, drive
from hairpipe.engine import Frames
from hairpipe.errors import BadInput
from hairpipe.groom.strands import lay_strands
from hairpipe.measure.deviation import deviation, measure_patches
from hairpipe.measure.motion import measure_root_motion
from hairpipe.values import Ends, Groom, Mesh, Strands


def straight(lengths, segments, shift=0.0, rate=0.0):
    """Strands that hang down, shifted along X, the more the farther from the root at this rate."""
    points, offsets = [], [0]
    for strand, (length, count) in enumerate(zip(lengths, segments, strict=True)):
        share = np.linspace(0.0, 1.0, count + 1)
        points.append(np.stack([shift + rate * share * length, -share * length, np.full(count + 1, strand)], axis=1))
        offsets.append(offsets[-1] + count + 1)
    points = np.concatenate(points).astype(np.float32)
    return Strands(points, np.zeros_like(points), np.array(offsets, np.int32), 8e-5)


def test_straight_hair_is_the_same_in_any_number_of_segments():
    found = deviation(straight([0.1, 0.3], [3, 7]), straight([0.1, 0.3], [10, 4]))
    assert max(found[:5]) == pytest.approx(0.0, abs=1e-5) and not len(found.lost)


def test_lengths_and_shares_of_a_difference_that_is_known():
    reference = straight([0.1, 0.3], [10, 10])
    found = deviation(straight([0.1, 0.3], [2, 5], rate=0.5), reference)
    share = np.arange(1, 11) / 10
    rms = np.sqrt(np.mean(share**2))
    assert found.tip == pytest.approx(0.5 * np.sqrt((0.1**2 + 0.3**2) / 2), rel=1e-5)
    assert found.whole == pytest.approx(rms * found.tip, rel=1e-5)
    assert (found.tip_percent, found.whole_percent) == pytest.approx((50.0, 50.0 * rms), rel=1e-5)
    assert found.largest == pytest.approx(0.15, rel=1e-5)


def test_a_strand_counts_as_one_however_many_points_it_has():
    hair = straight([0.1, 0.1], [4, 4])
    hair.points[:5, 0] += 1e-3
    rms = [deviation(hair, straight([0.1, 0.1], cut)).whole for cut in ([40, 2], [2, 40])]
    assert rms == pytest.approx([1e-3 / np.sqrt(2)] * 2, rel=1e-4)


def test_strands_that_are_not_finite_are_named_and_left_out():
    hair = straight([0.1, 0.2, 0.3], [5, 5, 5], shift=1e-3)
    hair.points[8] = np.nan
    found = deviation(hair, straight([0.1, 0.2, 0.3], [5, 5, 5]))
    assert found.lost.tolist() == [1] and found.tip == pytest.approx(1e-3, rel=1e-3)
    hair.points[:, 1] = np.inf
    found = deviation(hair, straight([0.1, 0.2, 0.3], [5, 5, 5]))
    assert found.lost.tolist() == [0, 1, 2] and np.isnan(found[:5]).all()


def test_some_strands_of_a_head_are_compared_with_themselves():
    head = straight([0.1, 0.2, 0.3], [5, 5, 5])
    some = straight([0.3, 0.1], [5, 5])
    some.points[:, 2] = np.repeat([2, 0], 6)
    assert deviation(some, head, np.array([2, 0])).largest == pytest.approx(0.0, abs=1e-7)
    with pytest.raises(ValueError, match="2 strands against 3 of 3"):
        deviation(some, head)


COUNT, SEGMENTS = 6, 5


@pytest.fixture
def hair() -> Strands:
    groom = lay_strands(COUNT, 0.1, SEGMENTS, (1.0, 0.0, 0.0), (0.0, 0.0, 0.01), None, 0.0)
    return Strands(groom.points.astype(np.float32), np.zeros_like(groom.points, np.float32), groom.offsets, 8e-5)


def test_each_patch_has_its_own_distance(hair):
    points = hair.points.reshape(COUNT, SEGMENTS + 1, 3).copy()
    points[:2, -1, 1] += 0.003
    points[5, -1, 1] += 0.004
    table = measure_patches({7: replace(hair, points=points.reshape(-1, 3))}, {7: hair}, 3)
    assert table["patch"].tolist() == [0, 1, 2] and table["strands"].tolist() == [2, 2, 2]
    assert table["tip [m]"] == pytest.approx([0.003, 0.0, 0.004 / np.sqrt(2)], abs=1e-7)
    assert table["tip [%]"] == pytest.approx([3.0, 0.0, 4.0 / np.sqrt(2)], abs=1e-3)
    assert table["whole [m]"] == pytest.approx(table["tip [m]"] / np.sqrt(SEGMENTS), abs=1e-7)


def test_other_strands_or_too_few_are_refused(hair):
    few = replace(hair, points=hair.points[:12], offsets=hair.offsets[:3])
    with pytest.raises(BadInput, match="2 strands against 6"):
        measure_patches({1: few}, {1: hair}, 1)
    with pytest.raises(BadInput, match="at least 7"):
        measure_patches({1: hair}, {1: hair}, 7)


def test_strands_that_are_lost_are_counted_in_their_patch(hair):
    points = hair.points.copy()
    points[-1] = np.nan
    assert measure_patches({1: replace(hair, points=points)}, {1: hair}, 2)["lost"].tolist() == [0, 1]


def test_roots_on_a_wheel_have_its_speed_and_acceleration():
    groom = lay_strands(2, 0.1, SEGMENTS, (1.0, 0.0, 0.0), (0.0, 0.0, 0.0), None, 0.0)
    groom = replace(groom, points=groom.points + np.array([0.3, 0.0, 0.0]))
    turn = Track((0.0, 1.0), turn=(0.0, 90.0), axis=(0.0, 0.0, 1.0), pivot=(-0.3, 0.0, 0.0), ease="linear")
    fps, rate = 96.0, np.pi / 2
    drivers: dict[int, Mesh | Ends] = {f: drive(groom, f / fps, turn, None, None, None) for f in range(1, 60)}
    table = measure_root_motion(groom, drivers, fps)
    assert table["speed [m/s]"][1:-1] == pytest.approx(0.3 * rate, rel=1e-3)
    assert table["acceleration [m/s^2]"][1:-1] == pytest.approx(0.3 * rate**2, rel=1e-3)
    assert table["acceleration [m/s^2]"][[0, -1]] == pytest.approx(0.0, abs=1e-9)


@pytest.fixture
def falling() -> tuple[Groom, Callable[[int], Ends]]:
    """A groom whose roots are 2 t^2 high, at 25 frames a second."""
    groom = lay_strands(2, 0.1, SEGMENTS, (1.0, 0.0, 0.0), (0.0, 0.0, 0.0), None, 0.0)
    still = drive(groom, 0.0, Track(), None, None, None)

    def at(frame: int) -> Ends:
        roots = still.roots.copy()
        roots[:, 1, 3] += 2.0 * (frame / 25.0) ** 2
        return replace(still, roots=roots)

    return groom, at


@pytest.mark.parametrize("frames", [(1, 3, 5, 7), (1, 2, 5, 6, 11)])
def test_steps_between_frames_may_be_of_any_length(falling, frames):
    """Central differences know a parabola exactly; at the ends it goes on in a straight line."""
    groom, at = falling
    table = measure_root_motion(groom, Frames(frames, at), 25.0)
    ends = [4.0 * (one + other) / 2 / 25.0 for one, other in (frames[:2], frames[-2:])]
    assert table["frame"].tolist() == list(frames)
    assert table["speed [m/s]"] == pytest.approx([ends[0], *(4.0 * f / 25.0 for f in frames[1:-1]), ends[1]])
    assert table["acceleration [m/s^2]"] == pytest.approx([0.0, *[4.0] * (len(frames) - 2), 0.0], abs=1e-9)


def test_roots_do_not_move_over_a_cut(falling):
    groom, at = falling

    def leapt(frame: int) -> Ends:
        roots = at(frame).roots.copy()
        roots[:, 0, 3] += 8.0 * (frame >= 5)
        return replace(at(frame), roots=roots)

    cut = measure_root_motion(groom, Frames(tuple(range(1, 10)), leapt), 25.0, (5,))
    whole = [measure_root_motion(groom, Frames(tuple(run), at), 25.0) for run in (range(1, 5), range(5, 10))]
    for name in ("speed [m/s]", "acceleration [m/s^2]"):
        assert cut[name] == pytest.approx(np.concatenate([table[name] for table in whole]))


@pytest.mark.parametrize("frames", [(7,), (7, 9)])
def test_roots_of_one_frame_are_at_rest_and_those_of_two_go_straight(falling, frames):
    groom, at = falling
    table = measure_root_motion(groom, Frames(frames, at), 25.0)
    assert table["speed [m/s]"] == pytest.approx([0.0] if len(frames) == 1 else [4.0 * 8 / 25.0] * 2)
    assert (table["acceleration [m/s^2]"] == 0.0).all()
