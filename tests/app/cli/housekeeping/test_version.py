"""`hairpipe version`: what results depend on."""

import json
import platform
from pathlib import Path

import numpy as np

from hairpipe import __version__, openvdb_library
from hairpipe.app.cli.commands.environment import version_of
from hairpipe.engine.worker.threading_layer import choose_layer
from hairpipe.errors import BadInput
from hairpipe.openvdb_library import find_openvdb
from hairpipe.processor import processor_class


def test_a_document_names_all_that_matters(hairpipe):
    found = json.loads(hairpipe("version --json").stdout)
    expected = {"hairpipe": __version__, "python": platform.python_version(), "numpy": np.__version__}
    expected |= {"class": processor_class(), "threading layer": choose_layer().name}
    assert expected.items() <= found.items() and found["threads"] >= 1
    assert {"numba", "usd", "h5py", "blosc"} <= found.keys()
    assert (found["openvdb"] is None) == (find_openvdb() is None)
    assert f"numpy            {np.__version__}\n" in hairpipe("version").stdout
    assert version_of("no-such-distribution") is None


def test_a_broken_module_is_named(monkeypatch):
    def refuse(task, where):
        raise BadInput("OpenVDB failed: undefined symbol", where=where)

    monkeypatch.setattr(openvdb_library, "find_openvdb", lambda: Path("openvdb.so"))
    monkeypatch.setattr(openvdb_library, "ask", refuse)
    assert openvdb_library.version_of_openvdb() == "unusable: openvdb: OpenVDB failed: undefined symbol"
