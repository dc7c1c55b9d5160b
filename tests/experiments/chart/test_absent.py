"""Charts without matplotlib, which `make demo` does not install."""

import importlib

import pytest

from hairpipe.errors import BadInput
from hairpipe.graphs.experiments import chart


def test_the_extra_is_named(monkeypatch):
    with monkeypatch.context() as patched:
        patched.setattr(importlib.util, "find_spec", lambda name: None)
        with pytest.raises(BadInput, match=r"matplotlib is not installed.*hairpipe\[experiments\]"):
            importlib.reload(chart)
    importlib.reload(chart)
