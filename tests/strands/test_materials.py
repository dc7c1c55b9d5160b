"""Materials that vary from strand to strand and along strands, against theory and against strands of one material."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.integrate import solve_bvp, trapezoid
from scipy.linalg import eigh

from hairpipe.errors import BadInput
from hairpipe.geometry.curl import Helix, wound
from hairpipe.graphs.experiments.studies.accuracy.sample import Sample
from hairpipe.graphs.experiments.studies.accuracy.specimen import specimen_of, stiffness, straight_specimen
from hairpipe.graphs.experiments.studies.accuracy.statics import motions
from hairpipe.graphs.experiments.studies.accuracy.vibration import frequencies
from hairpipe.groom.strands import unbound
from hairpipe.laws.settings import Rest, Share
from hairpipe.shot.settings import Scene
from hairpipe.shot.simulate import advance_frame, start
from hairpipe.solve.settle import settle
from hairpipe.strands.hair_model import build_hair
from hairpipe.strands.material import Diameter, Material, Modulus, VariedMaterial, fibres_of
from hairpipe.values.painting import values_of
from hairpipe.values.strand_arrays import take

LENGTH, THICK = 0.1, 80e-6
TAPER = ((0.0, 1.0), (0.5, 0.9), (1.0, 0.3))
UNIFORM = ((0.0, 1.0), (1.0, 1.0))


def tapered(profile=TAPER, softening=1.0, **more):
    return VariedMaterial(diameter=Diameter(THICK, profile=profile, **more), softening=softening)


def strands_of(*lines):
    """A groom of strands that are bound to nothing."""
    return unbound(np.array(lines), np.tile(np.eye(3, 4), (len(lines), 1, 1)))


def beam(segments=25, length=LENGTH):
    return np.linspace(0.0, length, segments + 1)[:, None] * [1.0, 0.0, 0.0]


def widths_along(s, profile=TAPER):
    return np.interp(s, *np.transpose(profile))


@cache
def elastica(gamma, profile=TAPER):
    """Tip over length of a horizontal cantilever of diameter d(s): (d^4 theta')' = -gamma W(s) cos(theta).

    gamma  rho A g L^3 / (E I) of the root, and W the weight beyond s over that of a uniform strand. In the angle and
    the moment m = d^4 theta' the equations are theta' = m / d^4, m' = -gamma W cos(theta), theta(0) = m(1) = 0.
    """
    grid = np.unique(np.concatenate([np.linspace(0.0, 1.0, 801), np.transpose(profile)[0]]))
    dense = widths_along(grid, profile) ** 2
    pieces = np.diff(grid) * (dense[1:] + dense[:-1]) / 2
    beyond = np.append(np.cumsum(pieces[::-1])[::-1], 0.0)

    def slopes(s, y):
        weight = np.interp(s, grid, beyond)
        return np.stack([y[1] / widths_along(s, profile) ** 4, -gamma * weight * np.cos(y[0])])

    guess = np.stack([np.pi / 2 * (1.0 - np.exp(-np.sqrt(gamma) * grid)), np.zeros(len(grid))])
    found = solve_bvp(slopes, lambda a, b: np.array([a[0], b[1]]), grid, guess, tol=1e-6, max_nodes=100_000)
    assert found.success
    s = np.linspace(0.0, 1.0, 20_001)
    angle = found.sol(s)[0]
    return np.array([trapezoid(np.cos(angle), s), trapezoid(np.sin(angle), s)])


def hung(material, gamma, model, segments):
    """Tip over length of a horizontal cantilever at rest in a weight gamma of its root's section."""
    uniform = Material()
    gravity = gamma * uniform.bending / (uniform.line_density * LENGTH**3)
    hair = build_hair(strands_of(beam(segments)), material, model)
    everyone = np.ones(hair.layout.strands.shape, bool)
    found = settle(hair.model, hair.layout, hair.groom.ids, hair.rest, np.array([0.0, -gravity, 0.0]), everyone)
    return hair.layout.axis(found.positions)[-1] / LENGTH


@pytest.mark.parametrize(("model", "segments", "most"), [("rod", 25, 0.01), ("network", 50, 0.01), ("chain", 50, 0.01)])
@pytest.mark.parametrize("gamma", [1.0, 10.0, 100.0])
def test_a_tapered_cantilever_sags_like_its_elastica(model, segments, most, gamma):
    """Its own sag, which differs from that of a strand of one diameter by far more than the error."""
    tip = hung(tapered(softening=1.0 if model == "rod" else 100.0), gamma, model, segments)
    theory = elastica(gamma)
    # The angle of the theory is that below the horizontal.
    assert np.linalg.norm(tip[:2] - theory * [1.0, -1.0]) < most
    assert np.linalg.norm(theory - elastica(gamma, UNIFORM)) > 5 * most


def specimen(profile, model="rod", segments=25):
    sample = Sample(model=model, material=tapered(profile, 1.0 if model == "rod" else 100.0), length=LENGTH)
    return straight_specimen(sample, segments)


@pytest.mark.parametrize("model", ["rod", "network"])
def test_a_cone_bends_by_the_closed_form_of_small_loads(model):
    """A cone d = D (1 - s/2) under a force F at its tip: y = F L^3 / E I * int (1 - s)^2 / (1 - s/2)^4 ds = 2/3."""
    strand = specimen(((0.0, 1.0), (1.0, 0.5)), model, 50)
    free, load = motions(strand), strand.nothing()
    load[strand.tip, 1] = force = 1e-9
    moved = free @ np.linalg.solve(free.T @ stiffness(strand, strand.rest) @ free, free.T @ load.reshape(-1))
    sag = moved.reshape(load.shape)[strand.tip, 1]
    assert sag == pytest.approx(2.0 / 3.0 * force * LENGTH**3 / Material().bending, rel=2e-2)


def beam_frequencies(profile, elements=60):
    """Frequencies of a tapered cantilever [Hz] by Hermite elements of Euler and Bernoulli."""
    size = 2 * elements + 2
    K, M = np.zeros((size, size)), np.zeros((size, size))
    h = LENGTH / elements
    for at, weight in zip(*np.polynomial.legendre.leggauss(4), strict=True):
        u = (at + 1) / 2
        shape = np.array([1 - 3 * u**2 + 2 * u**3, h * (u - 2 * u**2 + u**3), 3 * u**2 - 2 * u**3, h * (u**3 - u**2)])
        curved = np.array([12 * u - 6, h * (6 * u - 4), 6 - 12 * u, h * (6 * u - 2)]) / h**2
        for e in range(elements):
            thick = widths_along((e + u) / elements, profile)
            some = np.ix_(range(2 * e, 2 * e + 4), range(2 * e, 2 * e + 4))
            K[some] += weight * h / 2 * Material().bending * thick**4 * np.outer(curved, curved)
            M[some] += weight * h / 2 * Material().line_density * thick**2 * np.outer(shape, shape)
    return np.sqrt(eigh(K[2:, 2:], M[2:, 2:], eigvals_only=True)) / (2 * np.pi)


@pytest.mark.parametrize(("model", "segments"), [("rod", 25), ("network", 50)])
def test_a_tapered_strand_swings_at_the_frequencies_of_its_beam(model, segments):
    """Within what strands of one diameter are; a taper raises the first by half."""
    found = frequencies(specimen(TAPER, model, segments), 2).mean(axis=1)
    np.testing.assert_allclose(found, beam_frequencies(TAPER)[:2], rtol=0.03)
    assert beam_frequencies(TAPER)[0] > 1.2 * beam_frequencies(UNIFORM)[0]


@pytest.mark.parametrize("model", ["rod", "network", "chain"])
def test_strands_of_two_materials_are_those_simulated_alone(scene, straight, triangle, model):
    """One groom of two groups, each with its own diameter and stiffness, against each with numbers alone."""
    line = straight(0.08, 10, [1, 0, 0])
    both = replace(scene([line, line]).hair.groom, groups=np.array([0, 1], np.int32), group_names=("fringe", "beard"))
    material = VariedMaterial(Diameter(60e-6, groups=(("beard", 1.5),)), Modulus(4e9, low=2e9, map="fringe"))
    together = fallen(both, material, model, triangle()).reshape(2, -1, 3)
    for found, own in zip(together, (Material(60e-6, 4e9), Material(90e-6, 2e9)), strict=True):
        alone = fallen(scene([line]).hair.groom, own, model, triangle())
        np.testing.assert_allclose(found, alone, rtol=0, atol=1e-9)
    assert np.linalg.norm(together[0, -1] - together[1, -1]) > 5e-4


def fallen(groom, material, model, driver):
    """Points of strands a twelfth of a second after they were let go [m]."""
    hair, rules = build_hair(groom, material, model), Scene()
    state = start(hair, driver, rules)
    for frame in range(2):
        state = advance_frame(hair, state, (driver, driver), (), 1 / 24, rules, frame / 24)
    return hair.layout.axis(state.positions)


@pytest.mark.parametrize("model", ["rod", "network"])
def test_balanced_strands_of_varying_material_stay(scene, straight, triangle, model):
    curl = wound(Helix(radius=0.003, pitch=0.012), 0.1, 50) @ np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])
    groom = scene([straight(0.06, 50, [1, 0, 0]), curl + straight(0.1, 1, [1, 0, 0])[0]]).hair.groom
    hair = build_hair(groom, tapered(((0.0, 1.0), (1.0, 0.6)), 100.0), model)
    rules = Scene(rest=Rest(balanced=Share(1.0), unstable="refuse"))
    state = start(hair, triangle(), rules)
    for frame in range(12):
        state = advance_frame(hair, state, (triangle(), triangle()), (), 1 / 24, rules, frame / 24)
    assert np.linalg.norm(hair.layout.axis(state.positions) - groom.points, axis=1).max() < 1e-6


def test_a_curl_of_the_network_is_fitted_to_the_rod_of_its_own_taper(scene):
    """Compliance of the tip of a curl, on average over directions, of the network against the rod."""
    points = wound(Helix(radius=0.015, pitch=0.03), 0.3, 50)
    tips = []
    for model in ("rod", "network"):
        strand = specimen_of(Sample(model=model, material=tapered(((0.0, 1.0), (1.0, 0.5)), 100.0)), points)
        free, load = motions(strand), np.zeros((*strand.nothing().shape, 3))
        load[strand.tip, :3] = np.eye(3)
        moved = free @ np.linalg.solve(free.T @ stiffness(strand, strand.rest) @ free, free.T @ load.reshape(-1, 3))
        tips.append(moved.reshape(load.shape)[strand.tip, :3])
    assert np.trace(np.linalg.solve(*tips)) / 3 == pytest.approx(1.0, abs=0.05)


@pytest.fixture
def groom():
    return replace(strands_of(beam(4), beam(4)), maps={"soft": np.array([0.0, 0.5])})


def test_value_profile_and_map_are_multiplied(groom):
    found = values_of(Diameter(80e-6, 40e-6, map="soft", profile=((0.0, 1.0), (1.0, 0.5))), groom, "diameter")
    points = [1.0, 0.875, 0.75, 0.625, 0.5]
    np.testing.assert_allclose(found[0], np.multiply.outer([40e-6, 60e-6], points).ravel())
    np.testing.assert_allclose(
        found[1].reshape(2, 5)[:, :4], np.multiply.outer([40e-6, 60e-6], np.subtract(points, 0.0625)[:4])
    )


def test_widths_of_the_groom_are_diameters(groom):
    wide = replace(groom, widths=np.tile([1e-3, 1e-3, 1e-3, 5e-4, 5e-4], 2))
    found = values_of(Diameter(80e-6, widths=0.1), wide, "diameter").reshape(2, 2, 5)
    np.testing.assert_allclose(found[0, 0], [1e-4, 1e-4, 1e-4, 5e-5, 5e-5])
    np.testing.assert_allclose(found[1, 0, :4], [1e-4, 1e-4, 7.5e-5, 5e-5])
    with pytest.raises(BadInput, match=r"the groom carries no widths"):
        values_of(Diameter(80e-6, widths=0.1), groom, "material.diameter")


def test_variation_of_a_strand_does_not_depend_on_others(groom):
    found = values_of(Diameter(80e-6, variation=0.2), groom, "d")[0, ::5]
    alone = values_of(Diameter(80e-6, variation=0.2), take(groom, np.array([1])), "d")[0, 0]
    assert found[1] == alone != found[0]
    assert np.all(np.abs(found / 80e-6 - 1) <= 0.2)


def test_a_plain_number_stays_one(groom):
    assert fibres_of(groom, VariedMaterial()) == fibres_of(groom, Material())


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        (Diameter(80e-6, map="hard"), r"no map or group 'hard'.*'soft'"),
        (Diameter(80e-6, groups=(("beard", 2.0),)), r"no group 'beard'"),
        (Diameter(80e-6, groups=(("soft", 2.0),)), r"no group 'soft'"),
        (Diameter(80e-6, map="soft"), r"material.diameter is 0 m: strands 0 .*1e-05 to 0.002 m"),
        (Diameter(80e-6, profile=((0.0, 1.0), (1.0, 0.0))), r"material.diameter is .* m: strands 0, 1"),
        (Diameter(80e-6, profile=((0.5, 1.0), (0.2, 1.0))), r"fractions that do not ascend"),
        (Diameter(80e-6, map="short"), r"shape \(1,\).*a value for each of 2 strands"),
    ],
)
def test_bad_variations_are_refused(groom, setting, message):
    bad = replace(groom, maps={**groom.maps, "short": np.ones(1)}) if setting.map == "short" else groom
    with pytest.raises(BadInput, match=message):
        fibres_of(bad, VariedMaterial(diameter=setting))
