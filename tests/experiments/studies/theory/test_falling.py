"""Free fall in still air: its terminal speed carries the weight, and a damping rate has a closed form."""

import numpy as np
import pytest

from hairpipe.engine import Time
from hairpipe.graphs.experiments.nodes.drop_ends import drop_ends
from hairpipe.graphs.experiments.studies.theory.falling import DENSITY, VISCOSITY, fallen
from hairpipe.groom.strands import lay_strands
from hairpipe.strands.material import Material

HAIR = Material()


def test_a_damping_rate_has_its_closed_form():
    fall = fallen("rate", 0.3, HAIR, 8.0)
    left = np.exp(-8.0 * 0.3)
    assert fall.speed == pytest.approx(9.81 / 8.0 * (1.0 - left), rel=1e-8)
    assert fall.distance == pytest.approx(9.81 / 8.0 * (0.3 - (1.0 - left) / 8.0), rel=1e-8)


def test_the_drag_of_a_cylinder_carries_its_weight_at_the_terminal_speed():
    speed = fallen("across", 2.0, HAIR, 0.0).speed
    reynolds = DENSITY * HAIR.diameter * speed / VISCOSITY
    drag = 0.5 * DENSITY * HAIR.diameter * speed**2 * (1.18 + 6.8 * reynolds**-0.89 + 1.96 * reynolds**-0.5)
    assert drag == pytest.approx(9.81 * HAIR.line_density, rel=1e-6)
    faster = fallen("along", 4.0, HAIR, 0.0).speed
    friction = 0.25 * VISCOSITY * 6.8 * (DENSITY * HAIR.diameter * faster / VISCOSITY) ** 0.11
    assert friction * faster == pytest.approx(9.81 * HAIR.line_density, rel=1e-6) and faster > 3.0 * speed


def test_ends_fall_with_their_velocity_and_rest_before():
    groom = lay_strands(2, 0.1, 10, (1.0, 0.0, 0.0), (0.0, 0.0, 0.01), None, 0.0)
    before, now, after = (drop_ends(groom, Time(n, 1000.0), at=5, law="across") for n in (5, 49, 51))
    assert not before.roots[:, :, 3].any() and not before.roots_rate.any()
    middle = drop_ends(groom, Time(50, 1000.0), at=5, law="across")
    np.testing.assert_allclose(500.0 * (after.roots - now.roots), middle.roots_rate, atol=1e-4)
    assert np.isnan(now.tips).all() and (now.roots[:, 1, 3] < -0.005).all()
