import json

import bearing_watch as bw
import numpy as np
import pytest

from conftest import quietly


def system(samples=2000, noise=0.02, seed=5):
    """y = 1.5 y[-1] − 0.7 y[-2] + u1[-1] + 0.5 u2[-1] + e."""
    random = np.random.default_rng(seed)
    u1, u2 = random.choice([-1.0, 1.0], samples), random.normal(size=samples)
    y, e = np.zeros(samples), noise * random.normal(size=samples)
    for k in range(2, samples):
        y[k] = 1.5 * y[k - 1] - 0.7 * y[k - 2] + u1[k - 1] + 0.5 * u2[k - 1] + e[k]
    return y, u1, u2


ORDER = (2, 1, 1, 1, 1)
TRUE = np.array([-1.5, 0.7, 1.0, 0.5])


@pytest.mark.parametrize("method", ["ls", "iv", "iv-command", "iv4", "sriv", "sm", "oe", "armax"])
def test_every_method_finds_a_known_system(method):
    y, u1, u2 = system()
    command = u1 if method == "iv-command" else None
    # Output-error methods take the noise of the equation for coloured.
    found = quietly(lambda: bw.identify(y, u1, u2, order=ORDER, method=method, instruments=command))
    assert found.names == ["a1", "a2", "b1", "c1"] and found.order == ORDER
    np.testing.assert_allclose(found.theta, TRUE, atol=0.02)
    np.testing.assert_allclose(found.sd**2, np.diag(found.covariance))
    assert found.converged and found.stable and not found.undetermined
    assert found.residuals.shape == (found.rows,) and found.simulated.shape == (2000,)
    assert found.fit_percent > 95


def test_the_estimate_is_within_its_deviations():
    distances = []
    for seed in range(20):
        found = bw.identify(*system(500, 0.3, seed), order=ORDER)
        distances.append((found.theta - TRUE) @ np.linalg.solve(found.covariance, found.theta - TRUE))
    # χ² of 4 × 20 degrees of freedom.
    assert 50 < sum(distances) < 120


def test_any_layout_and_type_of_numbers_gives_the_same_bits():
    y, u1, u2 = system(noise=0.1)
    y = y.astype(np.float32)
    plain = bw.identify(y.astype(float), u1, u2, order=ORDER)
    strided = np.repeat(y, 3)[::3]
    assert not strided.flags.c_contiguous
    whole = u1.astype(np.int8)
    other = bw.identify(strided, whole, u2[::-1].copy()[::-1], order="2,1,1,1,1")
    assert np.array_equal(other.theta, plain.theta) and np.array_equal(other.covariance, plain.covariance)
    assert np.array_equal(bw.identify(y.tolist(), u1, u2, order=list(ORDER)).theta, plain.theta)


def test_the_command_line_gives_the_same_numbers(command, folder, bench):
    name = "spall_3_001"
    text = command(
        "identify", folder / f"{name}.csv", "--y=current_a", "--u1=velocity_ref_rad_s", "--u2=load_torque_nm",
        "--order=2,1,2,1,1", "--method=oe", "--json",
    )  # fmt: skip
    [row] = json.loads(text)
    trace = bench.traces[name]
    signals = trace["current_a"], trace["velocity_ref_rad_s"], trace["load_torque_nm"]
    found = quietly(lambda: bw.identify(*signals, order=(2, 1, 2, 1, 1), method="oe"))
    assert found.parameters == row["parameters"]
    assert found.covariance.tolist() == row["covariance"]
    assert found.fit_percent == row["fit_percent"]


def test_deviations_allow_for_coloured_residuals():
    y, u1, u2 = system(noise=0.0)
    random = np.random.default_rng(7)
    y = y + np.convolve(random.normal(size=len(y)), [1.0, 0.9, 0.8])[: len(y)]
    with pytest.warns(bw.BearingWatchWarning, match="the residuals are coloured"):
        plain = bw.identify(y, u1, u2, order=ORDER)
    robust = bw.identify(y, u1, u2, order=ORDER, robust=True)
    assert not plain.white and np.array_equal(plain.theta, robust.theta) and not np.allclose(plain.sd, robust.sd)
    with pytest.raises(ValueError, match="robust goes with least squares"):
        bw.identify(y, u1, u2, order=ORDER, method="oe", robust=True)
    with pytest.raises(ValueError, match="go with method iv-command"):
        bw.identify(y, u1, u2, order=ORDER, instruments=u1)


def test_structure_finds_the_order():
    training, validation = system(seed=1), system(seed=2)
    found = bw.structure(training, [validation, system(seed=3)], max_order=(3, 2, 2, 2, 2))
    assert found.best_mdl == ORDER and len(found.orders) == 3 * 2**4
    best = found.orders.tolist().index(list(found.best_fit))
    assert found.fit_percent[best] == found.fit_percent.max()
    one = bw.structure(training[:2], validation[:2], max_order=(2, 2, 0, 2, 0), min_order=(1, 1, 0, 1, 0))
    assert set(one.orders[:, 2]) == {0}


def test_validation_accepts_the_true_order_and_refuses_a_short_one():
    signals = system(noise=0.3)
    good, bad = (bw.validate(*signals, order=order) for order in (ORDER, (1, 1, 1, 1, 1)))
    assert good.independence.passed and good.whiteness.passed and not bad.independence.passed
    assert np.array_equal(good.estimate.theta, bw.identify(*signals, order=ORDER).theta)
    poles = np.roots([1, -1.5, 0.7])
    np.testing.assert_allclose(np.sort_complex(good.poles.at), np.sort_complex(poles), atol=0.05)
    assert good.poles.covariance.shape == (2, 2, 2) and good.zeros_u1.at.shape == (0,)
    assert good.autocorrelation.lags.tolist() == list(range(1, 26))


def test_bad_input_is_an_exception_with_a_clear_text():
    y, u1, u2 = system(200)

    def text(error, *signals, **options):
        with pytest.raises(error) as caught:
            bw.identify(*signals, **{"order": ORDER, **options})
        return str(caught.value)

    assert "u1 has 1 values, but column y has 200" in text(ValueError, y, [1.0], u2).replace("column u1: ", "u1 has ")
    assert "y has 2 dimensions" in text(ValueError, np.zeros((5, 2)), u1, u2)
    assert "y holds <U1" in text(TypeError, ["a", "b"], u1, u2)
    assert "y holds complex128" in text(TypeError, y * 1j, u1, u2)
    bad = y.copy()
    bad[7] = 1e300
    assert "row 8, column y: 1000000" in text(bw.BearingWatchError, bad, u1, u2)
    bad[7] = np.nan
    assert "y misses 1 of 200 samples, the first is 7" in text(bw.BearingWatchError, bad, u1, u2, method="iv")
    nothing = np.full(200, np.nan)
    assert "channel u1 has no number in any row" in text(bw.BearingWatchError, y, nothing, u2)
    assert "no rows" in text(bw.BearingWatchError, [], [], [])
    few = y[:10], u1[:10], u2[:10]
    assert "10 samples for 4 parameters" in text(bw.BearingWatchError, *few, order=(2, 1, 1, 9, 9))
    assert "the output is constant" in text(bw.BearingWatchError, np.ones(200), u1, u2)
    assert "do not excite parameter" in text(bw.BearingWatchError, y, u1, np.zeros(200))
    assert "2 terms of a second input" in text(bw.BearingWatchError, y, u1, order=(2, 1, 2, 1, 1))
    assert "no order" in text(bw.BearingWatchError, y, u1, u2, order=(1, 2))
    assert "no order" in text(bw.BearingWatchError, y, u1, u2, order="banana")
    assert "above 32" in text(bw.BearingWatchError, y, u1, u2, order=(33, 1, 1, 1, 1))
    assert "no method lsq; there are ls, iv" in text(bw.BearingWatchError, y, u1, u2, method="lsq")
    with pytest.raises(ValueError, match="too few for a residual test over 100 lags"):
        bw.validate(y, u1, u2, order=ORDER, lags=100)
    with pytest.raises(ValueError, match="whole numbers from 0 to 32"):
        bw.structure((y, u1), (y, u1), max_order=(99, 1, 0, 1, 1))
    with pytest.warns(bw.BearingWatchWarning, match="hardly determine"):
        sine = np.round(np.sin(0.01 * np.arange(2000)), 4)
        y = 0.5 * sine + np.random.default_rng(1).normal(size=2000)
        bw.identify(y, sine, order=(0, 3, 0, 1, 1), method="ls")


@pytest.mark.parametrize("kind", [float, np.float32, object, "masked", "list"])
def test_rows_that_miss_a_sample_are_left_out(kind):
    y, u1, u2 = system(600)
    whole = bw.identify(y, u1, u2, order=ORDER)
    y = y.copy()
    y[[50, 300]] = np.nan
    if kind == "masked":
        given = np.ma.masked_invalid(y)
    elif kind == "list":
        given = [None if np.isnan(value) else float(value) for value in y]
    elif kind is object:
        given = np.array([None if np.isnan(value) else value for value in y], dtype=object)
    else:
        given = y.astype(kind)
    found = bw.identify(given, u1, u2, order=ORDER)
    # y is in the target and in two lags: three rows for each missing sample.
    assert found.rows == whole.rows - 6
    assert np.all(np.abs(found.theta - whole.theta) < whole.sd)
    assert len(found.simulated) == 600 and np.all(np.isfinite(found.simulated))
