"""Pipes, devices and parts of the system in place of files: refused, never waited for."""

import os
import socket
from pathlib import Path

import pytest

from hairpipe.engine.file.load import load_graph
from hairpipe.errors import BadInput
from hairpipe.plain_file import special


@pytest.fixture
def odd(tmp_path):
    """A pipe, a socket, and links to a device and to a file of the system."""
    os.mkfifo(tmp_path / "pipe")
    with socket.socket(socket.AF_UNIX) as server:
        server.bind(str(tmp_path / "socket"))
    (tmp_path / "device").symlink_to("/dev/zero")
    (tmp_path / "system").symlink_to("/proc/self/environ")
    return tmp_path


KINDS = {"pipe": "a pipe", "socket": "a socket", "device": "a device", "system": "part of the system"}


def test_special_files_are_named(odd):
    assert {name: special(odd / name) for name in KINDS} == KINDS
    assert special(Path("/proc/kmsg")) == special(Path("/proc")) == "part of the system"
    (odd / "file").touch()
    (odd / "own").symlink_to(odd / "file")
    assert [special(odd / name) for name in ("file", "own", ".", "none", "file/none")] == [None] * 5


@pytest.mark.parametrize("name", KINDS)
def test_special_file_is_neither_graph_nor_setting(odd, name, shot):
    with pytest.raises(BadInput, match=f"it is {KINDS[name]} .a graph file"):
        load_graph(odd / name)
    with pytest.raises(BadInput, match=rf"file = '{name}' is {KINDS[name]}"):
        shot.load(seed__file=name)


def test_files_of_a_format_that_is_not_read_are_refused_when_the_graph_is(shot):
    (shot.folder / "body.fbx").touch()
    shot.path.write_text('schema = 1\nframes = [1, 1]\nfps = 24\n[head]\ntype = "load_body"\nfile = "body.fbx"\n')
    with pytest.raises(BadInput) as caught:
        load_graph(shot.path)
    formats = "a file, .usd, .usda, .usdc, .usdz, .gltf, .glb, .abc, .ply or .obj"
    fault = f"[head]: file = 'body.fbx' is not a file that load_body reads ({formats})"
    assert str(caught.value) == f"{shot.path}:6: {fault}"
    (shot.folder / "body.OBJ").touch()
    shot.change("body.fbx", "body.OBJ")
    assert load_graph(shot.path).nodes["head"]
