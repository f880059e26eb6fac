import pickle

import bearing_watch as bw
import numpy as np
import pytest

pytest.importorskip("sklearn")

from bearing_watch.sklearn import GaussianClassifier, NoveltyDetector  # noqa: E402
from sklearn.base import clone  # noqa: E402
from sklearn.model_selection import cross_val_score  # noqa: E402
from sklearn.pipeline import make_pipeline  # noqa: E402
from sklearn.preprocessing import StandardScaler  # noqa: E402
from sklearn.utils.estimator_checks import parametrize_with_checks  # noqa: E402


def expected_failures(estimator):
    return {}


@parametrize_with_checks(
    [GaussianClassifier(), NoveltyDetector()], expected_failed_checks=expected_failures
)
def test_scikit_learn_accepts(estimator, check):
    check(estimator)


def blobs(rows=120, seed=4):
    random = np.random.default_rng(seed)
    y = np.arange(rows) % 3
    X = random.normal(size=(rows, 4)) * [1, 2, 3, 4] + 2.0 * np.eye(3, 4)[y] * [1, 2, 3, 4]
    return X, np.array(["healthy", "roughness", "spall"])[y]


@pytest.mark.parametrize("discriminant", ["linear", "quadratic"])
def test_posteriors_are_those_of_gaussian_densities(discriminant):
    X, y = blobs()
    parts = [X[y == name] for name in np.unique(y)]
    own = [np.cov(part.T) for part in parts]
    pooled = sum((len(part) - 1) * one for part, one in zip(parts, own)) / (len(y) - 3)

    def log_density(part, covariance):
        away = X - part.mean(axis=0)
        squared = np.einsum("ij,ij->i", away @ np.linalg.inv(covariance), away)
        return -0.5 * (squared + np.linalg.slogdet(covariance)[1])

    each = [log_density(part, pooled if discriminant == "linear" else one) for part, one in zip(parts, own)]
    joint = np.stack(each, axis=1)
    expected = joint - np.logaddexp.reduce(joint, axis=1, keepdims=True)
    found = GaussianClassifier(discriminant=discriminant).fit(X, y)
    np.testing.assert_allclose(found.predict_log_proba(X), expected, rtol=1e-9, atol=1e-9)
    assert np.array_equal(found.predict(X), np.unique(y)[expected.argmax(axis=1)])


def test_priors_costs_and_missing_values():
    X, y = blobs()
    plain = GaussianClassifier().fit(X, y)
    rare = GaussianClassifier(priors={"healthy": 0.98, "roughness": 0.01, "spall": 0.01}).fit(X, y)
    assert (rare.predict(X) == "healthy").sum() > (plain.predict(X) == "healthy").sum()
    dear = GaussianClassifier(cost=[[0, 50, 50], [1, 0, 1], [1, 1, 0]]).fit(X, y)
    assert (dear.predict(X) == "healthy").sum() < (plain.predict(X) == "healthy").sum()
    holes = X.copy()
    holes[::5, 1] = np.nan
    assert GaussianClassifier().fit(holes, y).score(holes, y) > 0.7
    none = plain.predict_proba(np.full((1, 4), np.nan))
    np.testing.assert_allclose(none, 1 / 3)
    assert cross_val_score(make_pipeline(StandardScaler(), GaussianClassifier(projection="fisher")), X, y).mean() > 0.8
    for options in ({"discriminant": "cubic"}, {"projection": "x"}, {"priors": [1.0]}, {"cost": [[0.0]]}):
        with pytest.raises(ValueError):
            GaussianClassifier(**options).fit(X, y)
    with pytest.raises(ValueError, match="f1"):
        import pandas

        GaussianClassifier().fit(pandas.DataFrame({"f0": X[:, 0], "f1": 1.0}), y)


def test_the_gate_holds_its_rate_for_healthy_rows_and_finds_others():
    random = np.random.default_rng(8)
    rates = []
    for _ in range(20):
        gate = NoveltyDetector(false_alarm=0.05).fit(random.normal(size=(60, 3)))
        rates.append((gate.predict(random.normal(size=(500, 3))) == -1).mean())
    # 20 gates of 60 rows: the mean deviates by about 0.006.
    assert 0.03 < np.mean(rates) < 0.07
    assert (gate.predict(random.normal(size=(100, 3)) + 6.0) == -1).all()
    assert gate.limit_ == pytest.approx(-np.log(0.05)) and gate.offset_ == -gate.limit_
    assert np.isneginf(gate.score_samples([[np.nan] * 3])[0]) and gate.predict([[np.nan] * 3])[0] == -1
    runs = np.repeat(np.arange(20), 10)
    drifting = random.normal(size=(200, 2)) + 3.0 * random.normal(size=(20, 2))[runs]
    by_run, by_row = (NoveltyDetector(false_alarm=0.05).fit(drifting, runs=own) for own in (runs, None))
    far = [[9.0, -9.0]]
    assert by_run.score_samples(far)[0] > by_row.score_samples(far)[0]
    with pytest.raises(ValueError, match="too few for a novelty gate"):
        NoveltyDetector(false_alarm=0.001).fit(random.normal(size=(6, 3)))
    with pytest.raises(ValueError, match="a rate is between 0 and 1"):
        NoveltyDetector(false_alarm=2.0).fit(drifting)


def test_estimators_are_cloned_and_pickled_with_their_bits():
    X, y = blobs()
    for estimator, method in [(GaussianClassifier(), "predict_log_proba"), (NoveltyDetector(), "score_samples")]:
        fitted = clone(estimator).fit(X, y)
        other = pickle.loads(pickle.dumps(fitted))
        assert np.array_equal(getattr(fitted, method)(X), getattr(other, method)(X))


def test_features_of_the_detector_train_an_estimator(bench, model):
    found = {name: bw.Detector(model).run(trace).features for name, trace in bench.traces.items()}
    X = np.concatenate(list(found.values()))
    y = np.repeat([bench.labels[name] for name in found], [len(own) for own in found.values()])
    assert GaussianClassifier().fit(X, y).score(X, y) > 0.9


def test_masked_rows_are_missing_values():
    X, y = blobs()
    masked = np.ma.masked_array(X, mask=np.zeros(X.shape, dtype=bool))
    masked[::5, 1] = np.ma.masked
    holes = X.copy()
    holes[::5, 1] = np.nan
    for estimator, method in [(GaussianClassifier(), "predict_log_proba"), (NoveltyDetector(), "score_samples")]:
        found, expected = (getattr(clone(estimator).fit(own, y), method)(own) for own in (masked, holes))
        assert np.array_equal(found, expected)
