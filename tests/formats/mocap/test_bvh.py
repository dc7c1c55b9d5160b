import numpy as np
import pytest

from hairpipe.errors import BadInput
from hairpipe.formats import bvh as bvh_hierarchy
from hairpipe.formats.bvh import read_bvh, recall_bvh
from hairpipe.graphs.assets.bvh_writing import write_bvh
from hairpipe.values.body import Clip

PLAIN = """HIERARCHY
ROOT Hips
{
	OFFSET 0.0 1.0 0.0
	CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
	JOINT Left Arm
	{
		OFFSET 0.5 0.25 1e-5
		CHANNELS 3 Yrotation Xrotation Zrotation
		End Site
		{
			OFFSET 0.25 0 0
		}
	}
	JOINT Fixed
	{
		OFFSET -0.5 0 0
		CHANNELS 0
	}
}
MOTION
Frames: 2
Frame Time: 0.04
0 1 0 10 20 30 1 2 3
0 1 0.5 -10 -20 -30 4 5 6"""


def read_text_as_bvh(folder, text: str) -> Clip:
    path = folder / "clip.bvh"
    path.write_bytes(text.encode())
    return read_bvh(path)


def assert_is_plain(clip: Clip) -> None:
    assert clip.names == ("Hips", "Left Arm", "Fixed")
    np.testing.assert_array_equal(clip.parents, [-1, 0, 0])
    np.testing.assert_array_equal(clip.offsets, [[0, 1, 0], [0.5, 0.25, 1e-5], [-0.5, 0, 0]])
    np.testing.assert_array_equal(clip.ends, [[np.nan] * 3, [0.25, 0, 0], [np.nan] * 3])
    assert clip.channels[0] == ("Xposition", "Yposition", "Zposition", "Zrotation", "Xrotation", "Yrotation")
    assert clip.channels[1:] == (("Yrotation", "Xrotation", "Zrotation"), ())
    np.testing.assert_array_equal(clip.values, [[0, 1, 0, 10, 20, 30, 1, 2, 3], [0, 1, 0.5, -10, -20, -30, 4, 5, 6]])
    assert clip.frame_time == 0.04


@pytest.mark.parametrize(
    "change",
    [
        lambda t: t,
        lambda t: t + "\n\n \n",
        lambda t: t.replace("\n", "\r\n"),
        lambda t: t.replace("\t", "    "),
        lambda t: t.replace(" ", "\t").replace("Left\tArm", "Left Arm"),
        lambda t: t.replace("\n", "\n\n"),
        lambda t: t.replace("\n{", " {").replace("\n\t{", " {"),
        lambda t: "\ufeff" + t,
        lambda t: t.replace("Frame Time: 0.04", "Frame Time:\t.04").replace("Frames: 2", "Frames:2"),
        lambda t: t.replace("Frame Time: 0.04", "frame time 4e-2").replace("HIERARCHY", "hierarchy"),
        lambda t: t.replace("Xrotation", "XRotation").replace("End Site", "end site"),
        lambda t: t.replace("10 20 30 1 2 3", "10 20\n30 1 2 3"),
    ],
)
def test_all_the_ways_to_write_one_clip(tmp_path, change):
    assert_is_plain(read_text_as_bvh(tmp_path, change(PLAIN)))


def test_more_rows_than_the_header_states_are_named_and_left_out(tmp_path):
    text = PLAIN.rstrip("\n") + "\n" + PLAIN.rstrip("\n").rpartition("\n")[2] + "\n"
    with pytest.warns(UserWarning, match="has 3 frames, its header states 2: the last 1 is left out"):
        assert_is_plain(read_text_as_bvh(tmp_path, text))


def test_several_roots_and_two_end_sites_are_read(tmp_path):
    joint = "{\nOFFSET 0 0 0\nCHANNELS 1 Xrotation\nEnd Site\n{\nOFFSET 1 0 0\n}\n}\n"
    text = f"HIERARCHY\nROOT a\n{joint}ROOT b\n{joint}MOTION\nFrames: 1\nFrame Time: 1\n1 2\n"
    clip = read_text_as_bvh(tmp_path, text)
    assert clip.names == ("a", "b")
    np.testing.assert_array_equal(clip.parents, [-1, -1])


CHILD = """HIERARCHY
ROOT Reference
{
OFFSET 0 94 0
CHANNELS 1 Yposition
JOINT Hips
{
OFFSET 0 10 0
CHANNELS 2 Xrotation Yposition
}
}
MOTION
Frames: 2
Frame Time: 1
1 0 %s
2 0 %s
"""


@pytest.mark.parametrize(
    ("first", "second", "added"), [(10.2, 9.0, 0), (0.1, -0.2, 10), (0.1, 4.0, 10), (10.0, 2.0, 0), (0.0, 10.0, 0)]
)
def test_positions_of_joints_are_added_to_their_offsets_where_two_frames_say_so(tmp_path, first, second, added):
    clip = read_text_as_bvh(tmp_path, CHILD % (first, second))
    np.testing.assert_allclose(clip.values, [[1, 0, first + added], [2, 0, second + added]])


def test_a_thousand_joints_deep(tmp_path):
    depth = 3000
    head = "".join(f"{'JOINT' if i else 'ROOT'} j{i}\n{{\nOFFSET 0 1 0\nCHANNELS 0\n" for i in range(depth))
    clip = read_text_as_bvh(tmp_path, f"HIERARCHY\n{head}{'}' * depth}\nMOTION\nFrames: 1\nFrame Time: 1\n")
    np.testing.assert_array_equal(clip.parents, np.arange(-1, depth - 1))
    assert clip.values.shape == (1, 0)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("HIERARCHY\n", "", "does not begin with HIERARCHY"),
        ("MOTION\n", "", "no MOTION"),
        ("OFFSET 0.5 0.25 1e-5", "OFFSET 0.5 0.25", "line 9: 'CHANNELS' is not a usable number"),
        ("OFFSET 0.5", "OFFSET nan", "line 8: 'nan' is not a usable number"),
        ("\tOFFSET -0.5 0 0\n", "", "line 18: joint 'Fixed' has no OFFSET"),
        ("CHANNELS 3 Y", "CHANNELS 4 Y", "line 10: a channel is missing or unknown"),
        ("CHANNELS 3 Yrotation", "CHANNELS 3 Yscale", "line 9: a channel is missing or unknown"),
        ("CHANNELS 0", "CHANNELS -3", "cannot have -3 channels"),
        ("CHANNELS 0", "CHANNELS 1e9", "cannot have 1e\\+09 channels"),
        ("CHANNELS 0", "CHANNELS 2 Xposition Xposition", "stands twice"),
        ("JOINT Fixed", "ROOT Fixed", "a ROOT stands in the wrong place"),
        ("ROOT Hips", "JOINT Hips", "line 2: a JOINT stands in the wrong place"),
        ("ROOT Hips", "ROOT", "line 2: a ROOT has no name"),
        ("ROOT Hips\n{", "ROOT Hips\n", "a brace is missing"),
        ("}\nMOTION", "MOTION", "a brace is never closed"),
        ("}\nMOTION", "}\n}\nMOTION", "'}' is not understood"),
        ("CHANNELS 0", "LIMITS 1 2", "'LIMITS' is not understood"),
        ("OFFSET 0.25 0 0", "JOINT x { OFFSET 0 0 0 }", "within an End Site"),
        ("Frames: 2", "Frames: two", "line 22: 'Frames: two' is not understood"),
        ("Frames: 2", "Frames: -2", "not understood"),
        ("Frames: 2", "Frames: 2.5", "counts of the MOTION section"),
        ("Frames: 2", "Frames: 99999999999", "2 frames"),
        ("Frame Time: 0.04", "Frame Time: 0", "line 23"),
        ("Frame Time: 0.04", "Frame Time: inf", "line 23"),
        ("10 20 30 1 2 3", "10 20 30 1 2", "line 24: the line has 8 numbers .*2 lines of 9"),
        ("10 20 30 1 2 3", "10 20 x 1 2 3", "line 24: 'x' is not a usable number"),
        ("10 20 30 1 2 3", "10 20 nan 1 2 3", "line 24: 'nan' is not a usable number"),
        ("-10 -20 -30 4 5 6", "-10 -20 -30 4 5 1e999", "line 25: '1e999' is not a usable number"),
    ],
)
def test_faults_are_reported_with_their_line(tmp_path, old, new, message):
    assert old in PLAIN
    with pytest.raises(BadInput, match=message):
        read_text_as_bvh(tmp_path, PLAIN.replace(old, new))


def test_every_truncation_is_refused_or_read(tmp_path):
    for length in range(0, len(PLAIN) - 1, 7):
        with pytest.raises(BadInput):
            read_text_as_bvh(tmp_path, PLAIN[:length])


def test_writing_and_reading_gives_the_clip_back(tmp_path):
    clip = read_text_as_bvh(tmp_path, PLAIN)
    write_bvh(tmp_path / "again.bvh", clip)
    assert_is_plain(read_bvh(tmp_path / "again.bvh"))


def test_branches_in_any_order_keep_their_channels(tmp_path):
    """Both arms come before both hands, as in a clip put together level by level; a file goes down each arm."""
    names, turns = ("hips", "left", "right", "left hand", "right hand"), ("Zrotation", "Xrotation")
    clip = Clip(
        names=names,
        parents=np.array([-1, 0, 0, 1, 2], np.int32),
        offsets=np.arange(15.0).reshape(5, 3),
        ends=np.full((5, 3), np.nan),
        channels=(("Yposition", *turns), ("Xrotation",), ("Zrotation",), turns, ("Yrotation",)),
        values=np.arange(16.0).reshape(2, 8),
        frame_time=0.04,
    )
    write_bvh(tmp_path / "clip.bvh", clip)
    again = read_bvh(tmp_path / "clip.bvh")
    assert again.names == ("hips", "left", "left hand", "right", "right hand")
    assert dict(zip(again.names, again.channels, strict=True)) == dict(zip(names, clip.channels, strict=True))
    np.testing.assert_array_equal(again.values, clip.values[:, [0, 1, 2, 3, 5, 6, 4, 7]])
    np.testing.assert_array_equal(again.parents, [-1, 0, 1, 0, 3])


def test_a_clip_is_read_again_only_where_its_file_changed(tmp_path):
    path = tmp_path / "clip.bvh"
    path.write_text(PLAIN)
    once = recall_bvh(path)
    assert recall_bvh(path) is once
    path.write_text(PLAIN.replace("0.04", "0.0625"))
    assert recall_bvh(path).frame_time == 0.0625
    path.unlink()
    with pytest.raises(BadInput):
        recall_bvh(path)


# As counted by an independent reader: frames, joints, channels.
FILES = {
    "mocap/cmu_05_06.bvh": (886, 31, 96),
    "mocap/cmu_49_08.bvh": (576, 31, 96),
    "mocap/cmu_61_12_scaled.bvh": (1690, 43, 132),
    "mocap/fair1_dab.bvh": (339, 27, 84),
    "mocap/rokoko_jesse_dance.bvh": (1007, 60, 183),
    "body_makehuman/tpose.bvh": (1, 173, 951),
}


@pytest.mark.parametrize("name", FILES)
def test_real_files_are_read_whole(shared, name):
    clip = read_bvh(shared / name)
    assert (len(clip.values), len(clip.names), clip.values.shape[1]) == FILES[name]


def test_a_hierarchy_that_no_rig_has_is_refused_before_it_takes_memory(tmp_path, monkeypatch):
    joint = "JOINT j\n{\nOFFSET 0 1 0\nCHANNELS 0\n}\n"
    text = PLAIN.replace("JOINT Fixed", joint * 5 + "JOINT Fixed")
    monkeypatch.setattr(bvh_hierarchy, "MOST_JOINTS", 8)
    assert len(read_text_as_bvh(tmp_path, text).names) == 8
    monkeypatch.setattr(bvh_hierarchy, "MOST_JOINTS", 7)
    with pytest.raises(BadInput, match="there are more than 7 joints"):
        read_text_as_bvh(tmp_path, text)
    with pytest.raises(BadInput, match=r"the HIERARCHY section has \d\d,\d{3},\d{3} letters"):
        read_text_as_bvh(tmp_path, PLAIN.replace("JOINT Fixed", joint * 400_000 + "JOINT Fixed"))
