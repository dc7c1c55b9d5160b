"""Values as NPZ files."""

from dataclasses import dataclass, field

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from hairpipe.formats.values import write_npz


@dataclass(frozen=True)
class Inner:
    """A value within a value."""

    file: np.ndarray
    missing: float | None = None


@dataclass(frozen=True)
class Outer:
    """A value of every kind of entry."""

    inner: Inner
    number: float = 0.25
    count: int = 2**40
    flag: bool = True
    text: str = "Grüße"
    names: tuple[str, ...] = ("a", "", "long name")
    nothing: tuple[str, ...] = ()
    maps: dict[str, np.ndarray] = field(default_factory=lambda: {"scalp/left": np.zeros(2, np.int32)})


def test_everything_is_read_back_under_its_dotted_name(tmp_path):
    points = np.arange(6.0).reshape(2, 3)
    write_npz(tmp_path / "value.npz", Outer(Inner(points)))
    with np.load(tmp_path / "value.npz", allow_pickle=False) as found:
        names = {"inner.file", "number", "count", "flag", "text", "names", "nothing", "maps.scalp/left"}
        assert set(found) == names, "what is None is left out"
        np.testing.assert_array_equal(found["inner.file"], points)
        assert found["maps.scalp/left"].dtype == np.int32
        assert (found["number"], found["count"], found["flag"], found["text"]) == (0.25, 2**40, True, "Grüße")
        assert found["names"].tolist() == ["a", "", "long name"] and found["nothing"].shape == (0,)


@given(
    array=hnp.arrays(
        st.sampled_from([np.float64, np.float32, np.int32, bool]), hnp.array_shapes(min_dims=0, min_side=0)
    )
)
def test_any_array_is_read_back_unchanged(array, tmp_path_factory):
    path = tmp_path_factory.getbasetemp() / "array.npz"
    write_npz(path, {"array": array})
    with np.load(path) as found:
        np.testing.assert_array_equal(found["array"], array)
        assert found["array"].dtype == array.dtype


def test_equal_values_give_equal_bytes(tmp_path):
    for name in ("one", "two"):
        write_npz(tmp_path / name, Inner(np.arange(3)))
    assert (tmp_path / "one").read_bytes() == (tmp_path / "two").read_bytes()


def test_unsupported_values_are_refused(tmp_path):
    with pytest.raises(TypeError, match="a object is not stored"):
        write_npz(tmp_path / "value.npz", {"thing": object()})
