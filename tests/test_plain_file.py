"""What is no file is refused by every reader, at once."""

import os
import socket
from collections.abc import Callable
from pathlib import Path

import pytest

from hairpipe.errors import BadInput
from hairpipe.formats.bvh import read_bvh
from hairpipe.formats.hdf5 import read
from hairpipe.formats.makehuman import read_weights
from hairpipe.formats.pictures import read_image, read_picture
from hairpipe.formats.registry import read_body
from hairpipe.formats.tfx import read_tfx
from hairpipe.formats.usd.stage import open_stage
from hairpipe.formats.vdb import inspect

READERS: dict[str, Callable[[Path], object]] = {
    "a.obj": read_body,
    "a.bvh": read_bvh,
    "a.mhw": lambda path: read_weights(path, ("hip",), 3),
    "a.tfx": read_tfx,
    "a.png": read_image,
    "b.png": read_picture,
    "a.vdb": inspect,
    "a.usda": open_stage,
    "a.h5": read,
}


def pipe(path: Path) -> None:
    os.mkfifo(path)


def device(path: Path) -> None:
    path.symlink_to("/dev/zero")


def listener(path: Path) -> None:
    with socket.socket(socket.AF_UNIX) as end:
        before = Path.cwd()
        os.chdir(path.parent)  # the names of sockets are short
        end.bind(path.name)
        os.chdir(before)


@pytest.mark.parametrize("name", READERS)
@pytest.mark.parametrize(
    ("make", "what"), [(pipe, "a pipe"), (device, "a device"), (listener, "a socket"), (Path.mkdir, "a directory")]
)
def test_special_files_are_refused_by_every_reader(tmp_path, name, make, what):
    make(tmp_path / name)
    with pytest.raises(BadInput, match=f"(it is|value:) {what}") as caught:
        READERS[name](tmp_path / name)
    assert caught.value.where == tmp_path / name


@pytest.mark.parametrize("name", READERS)
def test_files_of_the_kernel_that_may_never_end_are_refused(tmp_path, name):
    log = Path("/proc/kmsg")
    if not log.exists():
        pytest.skip("the kernel shows no log here")
    (tmp_path / name).symlink_to(log)
    with pytest.raises(BadInput):
        READERS[name](tmp_path / name)
