"""Messages: names that are near, and values that are cut short."""

from hairpipe.engine.node.messages import brief, nearest


def test_nearest_name_or_all_of_them():
    assert nearest("voxle", ["voxel", "band"]) == "did you mean 'voxel'?"
    assert nearest("zzz", ["voxel", "band"]) == "known: band, voxel"
    assert nearest("zzz", []) == "there are none"


def test_long_values_are_cut_and_unwritable_ones_described():
    assert (brief("a"), brief([1, "a"])) == ("'a'", "[1, 'a']")
    assert brief("a" * 100) == "'" + "a" * 59 + "..."
    assert brief(16**5000) == brief([16**5000]) == "(too long to show)"
