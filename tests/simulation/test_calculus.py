# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest
from scipy.integrate import quad

from lodestar.simulation import calculus


def test_step_is_smooth_to_the_fourth_derivative():
    step = calculus._STEP
    assert step(0.0) == 0.0
    assert step(1.0) == pytest.approx(1.0, abs=1e-13)
    for order in range(1, 5):
        assert step.deriv(order)(0.0) == 0.0
        # Coefficients of up to 1e5 cancel here.
        assert step.deriv(order)(1.0) == pytest.approx(0.0, abs=1e-9)


def test_named_constants_are_those_of_the_step():
    x = np.linspace(0, 1, 2001)
    assert np.max(calculus.step_slope(x)) == pytest.approx(calculus.STEP_SLOPE, rel=1e-12)
    moment, _ = quad(lambda u: u * (1 - float(calculus.step(u))), 0, 1)
    assert pytest.approx(moment, abs=1e-12) == calculus.STEP_MOMENT


@pytest.mark.parametrize(("duration", "ramp"), [(10.0, 2.0), (4.0, 2.0), (3.0, 0.5)])
def test_plateau_rises_holds_falls_and_has_its_stated_integral(duration, ramp):
    t = np.linspace(0, duration, 1001)
    pulse = calculus.plateau(t, duration, ramp)
    assert pulse[0] == 0.0
    assert pulse[-1] == pytest.approx(0.0, abs=1e-12)
    assert pulse.max() == pytest.approx(1.0, abs=1e-12)
    integral = calculus.running_integral(pulse, t[1])
    np.testing.assert_allclose(
        calculus.plateau_integral(t, duration, ramp), integral, rtol=0, atol=1e-9
    )
    assert calculus.plateau_integral(duration, duration, ramp) == pytest.approx(duration - ramp)


def test_derivative_and_integral_of_samples_undo_each_other():
    interval = 1 / 60
    t = np.arange(6001) * interval
    values = np.stack([np.sin(t), np.cos(3 * t)], axis=-1)
    slope = calculus.derivative(values, interval)
    # Quintic splines: the error falls with the fifth power of 3/60, on the ends less.
    np.testing.assert_allclose(slope[:, 0], np.cos(t), rtol=0, atol=1e-9)
    np.testing.assert_allclose(slope[:, 1], -3 * np.sin(3 * t), rtol=0, atol=2e-6)
    back = values[0] + calculus.running_integral(slope, interval)
    np.testing.assert_allclose(back, values, rtol=0, atol=1e-8)
