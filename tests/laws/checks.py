"""Laws of every force that has an energy, by differences in extended precision."""

import numpy as np
from scipy.spatial.transform import Rotation

TURN, SHIFT = Rotation.from_rotvec([0.3, -1.0, 2.0]), np.array([1.0, -2.0, 3.0])


def check_law(energy, force, derivative, x, *, rtol=1e-6, atol=1e-7, steps=(1e-5, 1e-4), free=True):
    """See that a force is minus the gradient of its energy, and so on.

    energy      of places, an array of long doubles
    force       function of places; a linear form if they are not points
    derivative  minus the slope of the force at x, a matrix; None where the law has another one
    atol        share of the largest value
    steps       lengths of first and of second differences
    free        whether nothing but the points acts: no net force, no net torque, and turned points have turned forces
    """
    found, wide = force(x), x.astype(np.longdouble)
    first, second = (h * np.eye(x.size, dtype=np.longdouble).reshape(-1, *x.shape) for h in steps)
    slope = np.array([energy(wide + d) - energy(wide - d) for d in first]) / (2 * steps[0])
    np.testing.assert_allclose(found.ravel(), -slope.astype(float), rtol=rtol, atol=atol * np.abs(found).max())
    if derivative is not None:
        bends = [
            [energy(wide + a + b) - energy(wide + a - b) - energy(wide - a + b) + energy(wide - a - b) for a in second]
            for b in second
        ]
        expected = np.array(bends, float) / (4 * steps[1] ** 2)
        np.testing.assert_allclose(derivative, derivative.T, atol=1e-14 * np.abs(derivative).max())
        np.testing.assert_allclose(derivative, expected, rtol=rtol, atol=atol * np.abs(derivative).max())
    if free:
        check_balance(x, found)
        np.testing.assert_allclose(
            force(TURN.apply(x) + np.ptp(x) * SHIFT), TURN.apply(found), atol=1e-12 * np.abs(found).max()
        )


def check_balance(x, force):
    """See that forces at points (n, 3) act, and have neither a sum nor a torque."""
    assert np.abs(force).max() > 0
    np.testing.assert_allclose(force.sum(axis=0), 0, atol=1e-13 * np.abs(force).sum())
    torques = np.cross(x, force)
    np.testing.assert_allclose(torques.sum(axis=0), 0, atol=1e-12 * np.abs(torques).sum())
