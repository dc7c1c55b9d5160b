"""Dual scattering against a path tracer."""

from importlib.util import find_spec

import pytest

from hairpipe.graphs.experiments.bench.pictures.luminance import COLOURS, measure_luminance


@pytest.mark.skipif(find_spec("bpy") is None, reason="Blender is not installed: no bpy for this Python")
def test_locks_are_about_as_bright_as_by_path_tracing(monkeypatch: pytest.MonkeyPatch) -> None:
    """The darkest and the brightest."""
    monkeypatch.delitem(COLOURS, "brown")
    locks = measure_luminance(lambda _: None, samples=2)
    assert [lock.colour for lock in locks] == list(COLOURS)
    assert [lock.dual / lock.traced for lock in locks] == pytest.approx([1.0] * len(locks), abs=0.2)
