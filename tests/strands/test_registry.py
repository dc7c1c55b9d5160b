"""A model of a strand of one's own: registered here, simulated by the house as it is."""

from typing import NamedTuple, get_args

import numpy as np
import pytest

from hairpipe.geometry.compile import inlined
from hairpipe.geometry.simd import load
from hairpipe.laws.settings import Air, Drag, Scheme
from hairpipe.laws.stretch import linearise_spring
from hairpipe.shot.settings import Scene
from hairpipe.shot.simulate import advance_frame, start, strands_of
from hairpipe.solve.band import eliminate
from hairpipe.strands.assembly import add_spring
from hairpipe.strands.hair_model import HairModels
from hairpipe.strands.interface import ModelKind, kind_of, register_model
from hairpipe.strands.layout import Shape
from hairpipe.strands.material import Material, fibres_of
from hairpipe.strands.registry import ModelName, strand_models

SHAPE, STIFFNESS, MASS, G = Shape(reach=1, clamped=1, stride=1), 1e-3, 1e-7, 9.81


class Beads(NamedTuple):
    """Beads on a thread that does not resist bending."""

    first: np.ndarray
    mass: np.ndarray
    inverse_lengths: np.ndarray
    constants: np.ndarray
    shape = SHAPE


def build_beads(layout, groom, fibres, construction, shape):
    beads, rest = Beads(layout.first, layout.empty(), layout.empty(1), layout.empty(1)), layout.empty(3)
    beads.mass[:], beads.constants[:], beads.inverse_lengths[:] = MASS, STIFFNESS, 0.0
    for blocks in layout.classes():
        axis = groom.points[layout.points(blocks)]
        lengths = np.linalg.norm(np.diff(axis, axis=1), axis=2)
        layout.scatter(axis, blocks, rest)
        layout.scatter(np.pad(1 / lengths, [(0, 0), (0, 1)])[:, :, None], blocks, beads.inverse_lengths)
    return beads, rest


@inlined
def springs(model, p, count):
    return min(1, count - 1 - p)


@inlined
def constant(model, block, p, offset):
    return load(model.constants, (model.first[block] + p, 0))


@inlined
def forces(model, system, at, p, block, terms):
    (A, b), (x, _, _) = system, at
    if p + 1 < x.shape[0]:
        row = model.first[block] + p
        k, inverse_rest = load(model.constants, (row, 0)), load(model.inverse_lengths, (row, 0))
        add_spring(A, b, p, 1, linearise_spring(at, p, 1, (k, inverse_rest, 0.0 * k), terms.h, terms.hh))


def test_a_model_that_is_registered_hangs_by_its_own_springs(scene, straight, triangle):
    kind = register_model(ModelKind("beads", Beads, SHAPE, build_beads, forces, springs, constant))
    groom = scene([straight(0.05, 5, [0, -1, 0]), straight(0.08, 5, [0, -1, 0])]).hair.groom
    hair = HairModels(groom, fibres_of(groom, Material()), kind).in_precision("double")
    rules = Scene(G, Air(Drag(30.0)), scheme=Scheme("backward_euler"))
    state = start(hair, triangle(), rules)
    for _ in range(48):
        state = advance_frame(hair, state, (triangle(), triangle()), (), 1 / 24, rules)
    points = strands_of(hair, state).points.reshape(2, 6, 3)
    lengths = np.linalg.norm(np.diff(points, axis=1), axis=2)
    weights = MASS * G * np.arange(5, 0, -1)
    np.testing.assert_allclose(lengths, np.array([[0.01], [0.016]]) * (1 + weights / STIFFNESS), rtol=1e-4)


def test_models_of_the_house_are_those_that_a_graph_may_name(scene, straight):
    models = strand_models()
    assert tuple(models) == get_args(ModelName)
    for name, kind in models.items():
        model = scene([straight(0.05, 5, [0, -1, 0])], model=name).hair.model
        assert isinstance(model, kind.model) and kind_of(model) is kind and model.shape is kind.shape


def test_a_kernel_selected_by_the_model_is_refused_outside_compiled_code():
    with pytest.raises(TypeError, match="eliminate is a kernel that numba selects by the model"):
        eliminate(None, None, None, 0, 1, 1.0)
