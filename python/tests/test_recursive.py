"""The streaming estimator against batch estimates of the same samples."""

import bearing_watch as bw
import numpy as np
import pytest

ORDER = (2, 1, 2, 1, 1)


@pytest.fixture(scope="module")
def signals(bench):
    trace = bench.traces["healthy_3_000"]
    return trace["current_a"], trace["velocity_ref_rad_s"], trace["load_torque_nm"]


def test_long_memory_gives_batch_least_squares(signals):
    batch = bw.identify(*signals, order=ORDER, robust=True)
    estimator = bw.RecursiveEstimator(*signals, order=ORDER, forgetting=0.9999, every=5000)
    found = estimator.step(*signals)
    assert found.names == batch.names and found.samples.tolist() == [5000] and found.reason == [""]
    assert np.all(np.abs(found.theta[0] - batch.theta) < batch.sd)
    assert found.sd.shape == batch.sd[None].shape and found.variance[0] == pytest.approx(batch.variance, rel=0.1)


def test_pieces_and_reset(signals):
    estimator = bw.RecursiveEstimator(*signals, order=ORDER, forgetting=0.999, every=1000)
    whole = estimator.step(*signals)
    estimator.reset()
    pieces = [estimator.step(*(own[from_:to] for own in signals)) for from_, to in ((0, 10), (10, 2777), (2777, 5000))]
    assert [len(own) for own in pieces] == [0, 2, 3]
    assert np.array_equal(np.concatenate([own.theta for own in pieces]), whole.theta)


def test_instruments_are_not_biased_by_noise():
    random = np.random.default_rng(2)
    u, x = random.normal(size=40_000), np.zeros(40_000)
    for k in range(1, len(u)):
        x[k] = 0.9 * x[k - 1] + u[k - 1]
    y = x + random.normal(size=len(u))
    options = {"order": (1, 1, 0, 1, 1), "forgetting": 0.9998, "every": 5000}
    squares, instruments = (
        bw.RecursiveEstimator(y, u, method=method, **options).step(y, u) for method in ("ls", "instruments")
    )
    assert abs(squares.theta[-1, 0] + 0.9) > 5 * squares.sd[-1, 0]
    assert abs(instruments.theta[-1, 0] + 0.9) < 4 * instruments.sd[-1, 0]


def test_bad_input_is_refused(signals):
    def text(**options):
        with pytest.raises(bw.BearingWatchError) as caught:
            bw.RecursiveEstimator(*signals, **{"order": ORDER, **options})
        return str(caught.value)

    assert "no method sq" in text(method="sq")
    assert "--memory 2" in text(forgetting=2.0)
    assert "every is at least 2" in text(every=0)
    estimator = bw.RecursiveEstimator(*signals, order=ORDER)
    with pytest.raises(TypeError, match="u2"):
        estimator.step(*signals[:2])
    with pytest.raises(bw.BearingWatchError, match="one length"):
        estimator.step(signals[0][:9], *signals[1:])
    missing = np.full(1000, np.nan)
    found = bw.RecursiveEstimator(*signals, order=ORDER, every=1000).step(missing, missing, missing)
    assert np.isnan(found.theta).all() and found.reason[0]
