"""Values between processes: as they were, and nothing but values."""

from pathlib import Path

import numpy as np
import pytest

from hairpipe.apart import pack, unpack
from hairpipe.errors import BadInput
from hairpipe.formats.usd.check.scene import Fault, Finding
from hairpipe.values import Mesh


@pytest.mark.parametrize(
    "value",
    [
        None,
        True,
        -3,
        2.5,
        float("inf"),
        "caf\udce9 \n \0",
        Path("/a/b"),
        [1, (2, "3"), {"a": [], (1, 2): None}],
        Finding("rule", "/Hair", 3.0, "what", "error", 2),
        Fault("/Hair", "what"),
    ],
)
def test_values_are_read_back(value):
    found = unpack(pack([value, value]))
    assert found == [value, value] and type(found[0]) is type(value)


@pytest.mark.parametrize("dtype", ["?", "i1", "u2", "<i4", ">i8", "f2", "<f4", "f8"])
@pytest.mark.parametrize("shape", [(), (0, 3), (5,), (2, 3, 4)])
def test_arrays_are_read_back_and_may_be_written_to(dtype, shape):
    array = (np.arange(60)[: int(np.prod(shape))] % 2).reshape(shape).astype(dtype)
    first, second = unpack(pack((array, array[..., ::-1] if shape else array)))
    assert first.dtype == array.dtype and first.flags.writeable
    np.testing.assert_array_equal(first, array)
    np.testing.assert_array_equal(second, array[..., ::-1] if shape else array)


def test_records_and_faults_are_read_back(box):
    mesh = unpack(pack(box()))
    assert type(mesh) is Mesh
    np.testing.assert_array_equal(mesh.points, box().points)
    fault = unpack(pack(BadInput("what", where=Path("a"), right="right")))
    assert (fault.what, fault.where, fault.right) == ("what", Path("a"), "right")


@pytest.mark.parametrize("value", [object(), np.array([None]), np.array(["a"]), print, b"bytes"])
def test_nothing_else_is_sent(value):
    with pytest.raises(TypeError, match="is not sent"):
        pack(value)


@pytest.mark.parametrize(
    "name",
    ["subprocess:Popen", "os:system", "hairpipe.app.cli.entry:commands", "hairpipe.errors:BadInput", "hairpipe:x"],
)
def test_an_answer_names_no_code(name):
    with pytest.raises(TypeError):
        unpack(b'[["' + name.encode() + b'", ["echo"]], []]\n')
