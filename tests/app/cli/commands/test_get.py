"""`hairpipe get`: results as files."""

import h5py
import numpy as np
import pytest


def test_a_value_as_hdf5_and_npz(computed, hairpipe):
    result = hairpipe("get shot.toml sum@2 -o some/where.h5")
    assert result.stdout.startswith("some/where.h5  ")
    hairpipe("get shot.toml sum@2 -o sum.npz")
    with h5py.File("some/where.h5") as file:
        assert np.load("sum.npz")["value"] == file["value"].attrs["value"] == 0.9 * 4 + 5


def test_an_output_by_its_name(computed, hairpipe):
    hairpipe("get shot.toml sum.state@6 -o state.npz")
    assert np.load("state.npz")["history"].shape == (6,)


def test_a_file_is_copied_as_it_is(computed, hairpipe):
    hairpipe("get shot.toml list -o copy")
    assert (computed.parent / "copy").read_bytes() == (computed.parent / "out" / "list.txt").read_bytes()


def test_file_is_written_with_its_companions(shot, hairpipe):
    hairpipe("run shot.toml -j1 -q --set list.parts=true")
    hairpipe("get shot.toml list -o into/list.txt --set list.parts=true")
    assert (shot.parent / "into" / "parts" / "sums.txt").is_file()


@pytest.mark.parametrize("target", ["sum@2", "list"])
def test_a_damaged_result_is_there_again_after_a_run(target, computed, hairpipe):
    for path in computed.parent.glob("cache/objects/??/*"):
        path.chmod(0o644)
        path.write_bytes(bytes(path.stat().st_size))
    result = hairpipe(f"get shot.toml {target} -o copy.h5")
    assert result.exit_code == 2 and "hairpipe run computes it again" in result.stderr
    hairpipe("run shot.toml -j1 -q")
    assert hairpipe(f"get shot.toml {target} -o copy.h5").exit_code == 0


def test_results_of_all_frames_are_found_by_the_frames_of_the_run(shot, hairpipe):
    hairpipe("run shot.toml -j1 -q --frames 2-3")
    assert hairpipe("get shot.toml list -o copy").exit_code == 2
    assert hairpipe("get shot.toml list -o copy --frames 2-3").exit_code == 0


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ("sum@2 -o sum.csv", "sum.csv: a Numeral has no points to write (.h5 or .npz)"),
        ("sum@2 -o sum.usda", "sum.usda: a Numeral has no points to write (.h5 or .npz)"),
        ("sum@2 -o sum.doc", "sum.doc: values are not written as .doc files"),
        ("sum@2 -o sum", "sum: values are not written as such files"),
        ("sum@2 -o nodes", "nodes: is a folder"),
        ("sum.stat@2 -o s.npz", "'sum' has no output 'stat'"),
        ("sun@2 -o s.npz", "no node 'sun'"),
        ("sum -o s.npz", "'sum' has a value per frame (sum@1)"),
        ("sum@2 -o s.npz --set seed.value=9", "'sum@2' has not been computed"),
        ("sum@2", "Missing option '-o'"),
        ("@2 -o s.npz", "'@2' is not the name of a result"),
    ],
)
def test_missing_results_are_reported_in_one_message(arguments, message, computed, hairpipe):
    before = sorted(computed.parent.iterdir())
    result = hairpipe(f"get shot.toml {arguments}")
    assert result.exit_code == 2 and message in result.stderr
    assert sorted(computed.parent.iterdir()) == before


def test_asking_leaves_no_trace(shot, hairpipe):
    assert hairpipe("get shot.toml seed -o s.npz").exit_code == 2
    assert not (shot.parent / "cache").exists()
