"""The codec: what goes in comes out, equal values are equal bytes, and damage never passes for data."""

import dataclasses
import random
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import NamedTuple

import h5py
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from hairpipe.errors import BadInput
from hairpipe.formats import hdf5


@dataclass(frozen=True)
class Inner:
    """A part."""

    names: tuple[str, ...]
    weights: np.ndarray


class Named(NamedTuple):
    """A tuple with names."""

    left: Inner
    right: Inner | None


@dataclass(frozen=True)
class Value:
    """All that a value can hold."""

    points: np.ndarray
    maps: dict[str, np.ndarray]
    pair: Named
    label: str
    number: float
    count: int
    flag: bool
    maybe: np.ndarray | None = None


def value(**changes) -> Value:
    rng = np.random.default_rng(1)
    inner = Inner(("hips", "Rücken", ""), rng.random((3, 2)))
    base = Value(
        points=rng.random((5, 3)),
        maps={
            "scalp": np.ones(5),
            "a/b.c%": np.zeros((0, 3), np.float32),
            "": np.array(3, np.int8),
            ".": np.ones(1, bool),
        },
        pair=Named(inner, None),
        label="a\nbé",
        number=-0.0,
        count=2**62,
        flag=True,
    )
    return dataclasses.replace(base, **changes)


def assert_same(a, b):
    left, right = list(hdf5.leaves(hdf5.take_apart(a), ())), list(hdf5.leaves(hdf5.take_apart(b), ()))
    assert [path for path, _ in left] == [path for path, _ in right]
    for (path, one), (_, other) in zip(left, right, strict=True):
        assert type(one) is type(other), path
        if isinstance(one, np.ndarray):
            assert (one.dtype, one.shape) == (other.dtype, other.shape) and one.tobytes() == other.tobytes(), path
        else:
            assert repr(one) == repr(other), path


def test_every_kind_of_field_is_read_back(tmp_path):
    hdf5.encode(value(), tmp_path / "a.h5")
    back = hdf5.decode(tmp_path / "a.h5", Value)
    assert_same(back, value())
    assert hdf5.digest(back) == hdf5.digest(value()) == hdf5.digest_file(tmp_path / "a.h5")
    assert isinstance(back.pair, Named) and isinstance(back.pair.left, Inner) and back.maybe is None


def test_the_order_of_names_is_that_of_the_file(tmp_path):
    given = {"b": np.ones(1), "c": 1, "a.": {"2": None, "1": "x"}, "a-": np.ones(1), "": ("y",)}
    tree = hdf5.take_apart(given)
    hdf5.write(tree, tmp_path / "a.h5")
    assert str(hdf5.read(tmp_path / "a.h5")) == str(tree)
    assert list(tree) == ["", "a-", "a.", "b", "c"] and list(tree["a."]) == ["1", "2"]


class Level(StrEnum):
    """A text that shows itself as another."""

    HIGH = "high"


@pytest.mark.parametrize("value", [Level.HIGH, (Level.HIGH,), {Level.HIGH: 1}])
def test_a_text_of_a_derived_type_is_the_text(tmp_path, value):
    hdf5.encode(value, tmp_path / "v.h5")
    assert hdf5.digest(value) == hdf5.digest_file(tmp_path / "v.h5")


def test_no_names_are_not_no_texts():
    assert hdf5.digest_tree({"m": {}}) != hdf5.digest_tree({"m": ()})


def test_equal_values_are_equal_bytes(tmp_path):
    for name in "ab":
        hdf5.encode(value(), tmp_path / name)
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()


def test_the_size_of_a_file_is_known_before_it_is_written(tmp_path):
    """Small and large arrays, and those without elements, in groups within groups."""
    shapes = [(), (0,), (1,), (3, 5), (1000,), (70_000,), (4, 0, 2)]
    arrays = {f"a{n}": np.ones(shape, kind) for n, shape in enumerate(shapes) for kind in ("f8", "f4", "i4", "?")}
    texts = {"t": ("a", "bb"), "none": None, "long": "x" * 3000, "f": 1.5}
    for tree in ({}, texts, arrays, {"in": {"more": arrays | texts, "empty": {}}, "state": np.zeros((300, 3))}):
        path = tmp_path / "value.h5"
        tree = hdf5.take_apart(tree)
        hdf5.write(tree, path)
        assert hdf5.file_size(tree) == path.stat().st_size
        path.unlink()


def test_layout_in_memory_does_not_show(tmp_path):
    points = value().points
    big_endian = points.astype(points.dtype.newbyteorder(">"))
    wide = np.zeros((5, 6))
    wide[:, ::2] = points
    for same in (np.asfortranarray(points), big_endian, wide[:, ::2]):
        changed = value(points=same)
        assert hdf5.digest(changed) == hdf5.digest(value())
        hdf5.encode(changed, tmp_path / "x")
        back = hdf5.decode(tmp_path / "x", Value).points
        assert back.flags.c_contiguous and back.dtype == np.dtype("<f8")


@pytest.mark.parametrize(
    "change",
    [
        {"points": np.zeros((5, 3))},
        {"points": value().points.reshape(3, 5)},
        {"points": value().points.astype(np.float32)},
        {"points": value().points.view(np.int64)},
        {"maps": {"scalp": np.ones(5)}},
        {"maps": {**value().maps, "Scalp": np.ones(5)}},
        {"pair": Named(value().pair.left, value().pair.left)},
        {"pair": Named(Inner(("hips", "Rücken"), value().pair.left.weights), None)},
        {"label": "b"},
        {"number": 0.0},
        {"count": 2},
        {"flag": False},
        {"maybe": np.zeros(0)},
    ],
)
def test_every_field_counts_in_the_digest(change):
    assert hdf5.digest(value(**change)) != hdf5.digest(value())


@pytest.mark.parametrize(
    ("bad", "field"),
    [
        ({"points": np.array(["a"])}, "value.points"),
        ({"points": np.array([object()])}, "value.points"),
        ({"points": np.zeros(2, complex)}, "value.points"),
        ({"points": [1, 2]}, "value.points"),
        ({"count": 2**80}, "value.count"),
        ({"label": "a\0b"}, "value.label"),
        ({"maps": {3: np.zeros(1)}}, "value.maps"),
        ({"pair": Named(Inner((1, 2), np.zeros(1)), None)}, "value.pair.left.names"),
    ],
)
def test_unsupported_fields_are_named(bad, field, tmp_path):
    with pytest.raises((TypeError, ValueError), match=field):
        hdf5.encode(value(**bad), tmp_path / "a.h5")
    assert not (tmp_path / "a.h5").exists()


@settings(max_examples=60, deadline=None)
@given(
    arrays.arrays(
        st.one_of(
            arrays.floating_dtypes(), arrays.integer_dtypes(), arrays.unsigned_integer_dtypes(), arrays.boolean_dtypes()
        ),
        arrays.array_shapes(min_dims=0, max_dims=4, min_side=0, max_side=4),
    )
)
def test_any_array_is_read_back_bit_by_bit(tmp_path_factory, array):
    path = tmp_path_factory.getbasetemp() / "array.h5"
    hdf5.write({"a": array if array.dtype.byteorder != ">" else hdf5.plain_array(array, "a")}, path)
    back = hdf5.read(path)["a"]
    expected = hdf5.plain_array(array, "a")
    assert (back.dtype, back.shape, back.tobytes()) == (expected.dtype, array.shape, expected.tobytes())


def test_another_type_is_refused(tmp_path):
    hdf5.encode(value(), tmp_path / "a.h5")
    with pytest.raises(BadInput, match="not a Inner"):
        hdf5.decode(tmp_path / "a.h5", Inner)
    hdf5.encode(dataclasses.replace(value(), points=np.zeros(1)), tmp_path / "a.h5")
    other = [(field.name, float if field.name == "points" else field.type) for field in dataclasses.fields(Value)]
    with pytest.raises(BadInput, match="not a Other"):
        hdf5.decode(tmp_path / "a.h5", dataclasses.make_dataclass("Other", other, frozen=True))


@pytest.mark.parametrize("data", [b"", b"\x89HDF", b"not HDF5 at all" * 100])
def test_other_files_are_refused(tmp_path, data):
    (tmp_path / "a.h5").write_bytes(data)
    with pytest.raises(BadInput):
        hdf5.read(tmp_path / "a.h5")


def virtual(file: h5py.File, folder: Path) -> None:
    layout = h5py.VirtualLayout((3,), "f8")
    layout[:] = h5py.VirtualSource(str(folder / "other.h5"), "value", (3,))
    file.create_virtual_dataset("value", layout)


def packed(file: h5py.File, folder: Path) -> None:
    file.create_dataset("value", data=np.zeros(64), chunks=(64,), compression="gzip")
    file["fill"] = np.zeros(128)


FOREIGN: list[tuple[str, Callable[[h5py.File, Path], object]]] = [
    ("has two names", lambda file, _: file.create_group("value").__setitem__("again", file["value"])),
    (
        "has two names",
        lambda file, _: file.update({"value/a": np.zeros(3)}) or file.update({"value/b": file["value/a"]}),
    ),
    ("link to elsewhere", lambda file, _: file.update({"value/a": h5py.SoftLink("/value")})),
    ("link to elsewhere", lambda file, at: file.update({"value": h5py.ExternalLink(str(at / "other.h5"), "/value")})),
    (
        "does not lie in the file",
        lambda file, at: file.create_dataset("value", (3,), "f8", external=[(at / "o", 0, 24)]),
    ),
    ("does not lie in the file", virtual),
    ("does not lie in the file", packed),
    # nothing is written: it takes no room
    ("larger than its file", lambda file, _: [file.create_dataset(f"value/{n}", (500,), "f8") for n in range(30)]),
    ("larger than its file", lambda file, _: file.create_dataset("value", (1 << 40,), "f8", chunks=(1024,))),
]


@pytest.mark.parametrize(("message", "make"), FOREIGN)
def test_a_file_that_leads_elsewhere_or_claims_too_much_is_refused(tmp_path, message, make):
    hdf5.encode(value(), tmp_path / "other.h5")
    (tmp_path / "o").write_bytes(bytes(24))
    with h5py.File(tmp_path / "a.h5", "w") as file:
        make(file, tmp_path)
    with pytest.raises(BadInput, match=message):
        hdf5.read(tmp_path / "a.h5")


@pytest.mark.slow
def test_damage_is_refused_or_shows_in_the_digest(tmp_path):
    """Bits flipped, bytes scrambled, ends cut off: never another value under this digest, or another exception."""
    path, damaged = tmp_path / "a.h5", tmp_path / "b.h5"
    hdf5.encode(value(), path)
    whole, right = path.read_bytes(), hdf5.digest(value())
    choose = random.Random(3)
    seen = set()
    for _ in range(800):
        data = bytearray(whole)
        at = choose.randrange(len(data))
        how = choose.choice(["flip", "scramble", "cut"])
        if how == "flip":
            data[at] ^= 1 << choose.randrange(8)
        elif how == "scramble":
            data[at : at + 16] = choose.randbytes(len(data[at : at + 16]))
        else:
            del data[at:]
        damaged.write_bytes(data)
        try:
            tree = hdf5.read(damaged)
        except BadInput:
            seen.add((how, "refused"))
            continue
        if hdf5.digest_tree(tree) == right:
            assert_same(hdf5.build(Value, tree), value())
        else:
            seen.add((how, "digest"))
    assert {("flip", "refused"), ("flip", "digest"), ("scramble", "digest"), ("cut", "refused")} <= seen


LIMITED = """
import resource, sys
from pathlib import Path
import numpy as np
from hairpipe.formats import hdf5
for size in range(0, 200_000, 20_000):
    for limit in (1, 4096, size, size + 2048, size + 200_000):
        resource.setrlimit(resource.RLIMIT_FSIZE, (limit, resource.RLIM_INFINITY))
        path = Path(sys.argv[1], f"{size}-{limit}.h5")
        try:
            hdf5.write({"a": np.zeros(size, np.uint8), "b": ("text",) * 9}, path)
        except OSError as error:
            assert error.errno == 27 and not path.exists(), error
print("ended")
"""


def test_a_limit_of_file_size_is_an_error_before_the_file_is_begun(tmp_path):
    """HDF5 itself would end the process by SIGSEGV."""
    done = subprocess.run([sys.executable, "-c", LIMITED, tmp_path], capture_output=True, text=True)
    assert (done.returncode, done.stdout) == (0, "ended\n"), done.stderr
    assert any(tmp_path.iterdir())
