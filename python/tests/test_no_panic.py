"""Random bad input: every answer is a result or an ordinary exception."""

import warnings

import bearing_watch as bw
import numpy as np

ORDERS = [(1, 1, 0, 1, 1), (0, 1, 0, 0, 0), (0, 0, 0, 0, 0), (32, 32, 32, 32, 32), (2, 0, 0, 1, 1), (1, 1, 1, 0, 0)]


def signal(random, samples):
    kind = random.integers(7)
    if kind == 0:
        return np.zeros(samples)
    if kind == 1:
        return np.full(samples, random.choice([np.nan, np.inf, 1e15, -1e300, 5e-324]))
    if kind == 2:
        return np.arange(samples) * 1e-9
    values = random.normal(size=samples) * 10.0 ** random.integers(-12, 12)
    if kind == 3 and samples:
        values[random.integers(samples)] = np.nan
    return values if kind < 6 else values[: samples // 2]


def attempt(work):
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            work()
    except (ValueError, TypeError):
        pass


def test_signals():
    random = np.random.default_rng(1)
    for _ in range(400):
        samples = int(random.choice([0, 1, 2, 3, 5, 20, 80]))
        y, u1, u2 = (signal(random, samples) for _ in range(3))
        order = ORDERS[random.integers(len(ORDERS))]
        method = random.choice(["ls", "iv", "iv4", "sriv", "sm", "oe", "armax"])
        attempt(lambda: bw.identify(y, u1, u2, order=order, method=method, offset=bool(random.integers(2))))
        attempt(lambda: bw.validate(y, u1, u2, order=order, method=method, lags=int(random.integers(0, 30))))
        attempt(lambda: bw.structure((y, u1), (u2, u1), max_order=(2, 2, 0, 1, 1)))


def test_detector(bench, model):
    random = np.random.default_rng(2)
    names = ("velocity_ref_rad_s", "velocity_rad_s", "current_a", "load_torque_nm", "angle_rad")
    detector = bw.Detector(model)
    for _ in range(200):
        samples = int(random.choice([0, 1, 7, 500, 1500]))
        columns = {name: signal(random, samples) for name in names}
        attempt(lambda: detector.step(columns))
        attempt(lambda: detector.run(columns))
        if random.integers(4) == 0:
            attempt(detector.finish)


def test_training(bench):
    random = np.random.default_rng(3)
    for _ in range(60):
        names = [f"t{k}" for k in range(int(random.integers(0, 6)))]
        traces = {name: {column: signal(random, 60) for column in "abc"} for name in names}
        labels = {name: str(random.choice(["healthy", "x", ""])) for name in names}
        order = ORDERS[random.integers(len(ORDERS))]
        options = {"features": random.choice(["a", "log_variance", "?"]), "projection": random.choice(["pca", "none"])}
        attempt(lambda: bw.train(traces, labels, y="a", u1="b - c", u2="c", order=order, **options))
    for size in (0, 1, 3, 17, 200):
        attempt(lambda: bw.Model.from_bytes(random.bytes(size)))
