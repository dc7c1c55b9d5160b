"""What a value prints: shapes, units and ranges, never its arrays."""

import dataclasses
import importlib
import pkgutil

import numpy as np
import pytest

import hairpipe.values
from hairpipe.values import BodyParts, Groom, Mesh, Particles
from hairpipe.values.table import table_of_columns
from hairpipe.values.value import units_of, value

SETTINGS = {"painting", "simplification"}
"""Modules whose types are settings, compared by their contents; edges transport those of the others."""
NAMES = [module.name for module in pkgutil.iter_modules(hairpipe.values.__path__) if module.name not in SETTINGS]
MODULES = [importlib.import_module(f"hairpipe.values.{name}") for name in NAMES]
TYPES = [
    item
    for module in MODULES
    for item in vars(module).values()
    if dataclasses.is_dataclass(item) and item.__module__ == module.__name__
]


@value
class Springs:
    """Springs, for a test.

    lengths   at rest of lengths[i] [m], (n,) float64
    frames    [R | p] at rest [m], (3, 4) float64
    mesh      that they hold
    stiffness of each [N/m]
    """

    lengths: np.ndarray
    frames: np.ndarray
    mesh: Mesh
    stiffness: float
    names: tuple[str, ...] = ()
    broken: np.ndarray | None = None


def springs_of(count):
    mesh = Mesh(np.zeros((count, 3)), np.zeros((0, 3), np.int32))
    return Springs(np.linspace(0.25, 0.5, count), np.eye(3, 4), mesh, 2.5)


@pytest.mark.parametrize("kind", TYPES, ids=lambda kind: kind.__name__)
def test_every_type_is_declared_and_printed_alike(kind):
    assert kind.__repr__ is Springs.__repr__
    with pytest.raises(dataclasses.FrozenInstanceError):
        dataclasses.replace(springs_of(2)).lengths = None


def test_a_value_prints_shapes_units_and_ranges():
    assert repr(springs_of(1000)).splitlines() == [
        "Springs",
        "  lengths    (1000,) float64  [m]  0.25 to 0.5",
        "  frames     (3, 4) float64  [m]  0 to 1",
        "  mesh       Mesh",
        "    points      (1000, 3) float64  [m]  0 to 0",
        "    triangles   (0, 3) int32  []",
        "    velocities  None",
        "    uv          None",
        "  stiffness  2.5 [N/m]",
        "  names      ()",
        "  broken     None",
    ]


def test_numbers_that_are_not_finite_and_short_arrays_are_shown():
    lengths = np.array([np.nan, 1.0, np.inf, 2.0, 3.0])
    lines = repr(dataclasses.replace(springs_of(2), lengths=lengths, broken=np.zeros(9, bool), names=("a",) * 9))
    assert "1 to 3, 2 not finite" in lines and "(9,) bool  0 true" in lines and "... 9 in all" in lines
    assert "(2,) float64  [m]  [0.25 0.5 ]" in repr(springs_of(2))


def test_a_table_prints_a_line_for_every_column():
    lines = repr(table_of_columns({"case": ["a", "b"], "tip [m]": [0.5, 1.5]})).splitlines()
    assert [line.split() for line in lines[2:]] == [
        ["numbers['tip", "[m]']", "(2,)", "float64", "[0.5", "1.5]"],
        ["texts['case']", "'a',", "'b'"],
    ]


def test_units_are_those_of_the_docstrings():
    assert {"points": "m", "root_frames": "m", "widths": "m"}.items() <= units_of(Groom).items()
    assert "offsets" not in units_of(Groom) and units_of(BodyParts)["poses"] == "m"
    assert units_of(Particles)["masses"] == "kg"
