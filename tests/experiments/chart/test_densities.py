"""Sections through densities: what is drawn lies where it is."""

import numpy as np
from PIL import Image

from hairpipe.graphs.experiments.chart.densities import draw_densities


def drawn(path, nodes):
    """A picture of a density that rises evenly, known at so many nodes along each side."""
    ramp = np.linspace(0.0, 1.0, nodes)
    draw_densities(path, [("ramp", ramp[:, None] + ramp, (0.0, 0.1, 0.0, 0.1))], size=(500, 400))
    with Image.open(path) as image:
        return np.asarray(image.convert("RGB"), float)


def test_a_density_that_rises_evenly_looks_the_same_from_few_nodes_and_from_many(tmp_path):
    coarse, fine = drawn(tmp_path / "coarse.png", 4), drawn(tmp_path / "fine.png", 64)
    assert coarse.shape == (400, 500, 3)
    assert np.abs(coarse - fine).max() < 12.0
    assert (fine[200, :, 1] < 250.0).any()


def test_no_hair_is_an_empty_panel(tmp_path):
    draw_densities(tmp_path / "none.png", [("none", np.zeros((0, 0)), (0.0, 0.0, 0.0, 0.0))], size=(500, 400))
    with Image.open(tmp_path / "none.png") as image:
        assert image.size == (500, 400)
