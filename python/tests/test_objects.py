"""Odd objects for every public function: a result, or a ValueError, TypeError or OSError with a sentence.

`BEARING_WATCH_OBJECTS=100000` runs more of them, `BEARING_WATCH_SEED` others.
"""

import collections
import faulthandler
import os
import pickle
import time
import warnings

import bearing_watch as bw
import numpy as np
import objects
import pytest
from bearing_watch import fleet

from conftest import quietly

COUNT = int(os.environ.get("BEARING_WATCH_OBJECTS", "2500"))
SEED = int(os.environ.get("BEARING_WATCH_SEED", "1"))
#: Seconds that no call takes.
LONGEST = 20.0

#: Options that functions take, most with a value of another type.
OPTIONS = [
    "order",
    "segment",
    "features",
    "priors",
    "cost",
    "healthy",
    "false_alarm",
    "where",
    "time",
    "rate_hz",
    "bearing",
    "orders",
    "offset",
    "block_mean",
    "decimate",
    "group",
    "unit",
    "train_where",
    "slip",
    "discriminant",
    "nonsense",
]


#: How much rarer odd objects are in a draw than `some` says.
RARER = [1]


def some(random, good, odd=objects.anything, one_in=5):
    """The good value, or an odd one."""
    return odd(random) if random.integers(one_in * RARER[0]) == 0 else good


def options(random, names=OPTIONS):
    chosen = {objects.pick(random, names) for _ in range(int(random.integers(0, 3)))}
    return {name: objects.anything(random) for name in chosen}


def channels(random):
    return {
        "y": some(random, "current_a"),
        "u1": some(random, "velocity_rad_s"),
        "order": some(random, (1, 1, 0, 1, 1), objects.order),
    }


@pytest.fixture(scope="module")
def functions(tmp_path_factory):
    """Every public function as one of a generator; what it calls takes the arguments as they are drawn."""
    random = np.random.default_rng(SEED)
    traces = {name: objects.good(random) for name in "abcdef"}
    labels = {name: "healthy" if name < "d" else "spall" for name in traces}
    model = quietly(
        lambda: bw.train(traces, labels, y="current_a", u1="velocity_rad_s", order=(1, 1, 0, 1, 1), novelty="none")
    )
    detector = bw.Detector(model)
    signal, file = traces["a"]["current_a"], tmp_path_factory.mktemp("objects") / "run.csv"
    file.write_text("t_s,current_a\n" + "".join(f"{k / 8},{k % 3}\n" for k in range(20)))
    command = traces["a"]["velocity_rad_s"]
    estimator = bw.RecursiveEstimator(signal, command, order=(1, 1, 0, 1, 1), every=20)
    found = bw.Detector(model).run(traces["a"])
    sklearn = pytest.importorskip("bearing_watch.sklearn")
    rows, classes = random.normal(size=(60, 3)), np.arange(60) % 2

    def vector(random, good=signal):
        return some(random, good, objects.column, 2)

    def training(random):
        tables = some(random, traces, objects.tables, 2)
        return bw.train(
            some(random, tables), some(random, labels, objects.labels), **{**channels(random), **options(random)}
        )

    def evaluation(random):
        return bw.evaluate(
            some(random, model, one_in=8),
            some(random, traces, objects.tables, 2),
            some(random, labels, objects.labels),
            **options(random),
        )

    def recursive(random):
        made = bw.RecursiveEstimator(
            vector(random),
            vector(random, command),
            some(random, None),
            order=some(random, (1, 1, 0, 1, 1), objects.order, 3),
            method=some(random, "ls"),
            forgetting=some(random, 0.99),
            every=some(random, 50),
            offset=some(random, False),
        )
        return made.step(vector(random), vector(random, command))

    def sets(random):
        own = (vector(random), vector(random, command))
        return bw.structure(
            some(random, own),
            some(random, [own, own]),
            max_order=some(random, (1, 1, 0, 1, 1), objects.order, 3),
            min_order=some(random, (1, 1, 0, 1, 1), objects.order),
            **estimator_of(random),
        )

    def estimation(random, function, **further):
        """A call of a function of signals, with its own options and those of all."""
        own = {name: some(random, good) for name, good in further.items()}
        signals = vector(random), vector(random, command), some(random, None)
        return function(*signals, order=some(random, (1, 1, 0, 1, 1), objects.order, 3), **estimator_of(random), **own)

    def estimator_of(random):
        return {"method": some(random, "ls"), "offset": some(random, False)}

    identifying = {"passes": 3, "noise_order": None, "instruments": None, "robust": False}

    return {
        "identify": lambda r: estimation(r, bw.identify, **identifying),
        "validate": lambda r: estimation(r, bw.validate, lags=5),
        "structure": sets,
        "RecursiveEstimator": recursive,
        "RecursiveEstimator.step": lambda r: estimator.step(vector(r), vector(r, command), some(r, None)),
        "train": training,
        "evaluate": evaluation,
        "Model.from_bytes": lambda r: bw.Model.from_bytes(objects.anything(r)),
        "Model.load": lambda r: bw.Model.load(some(r, file)),
        "Model.report": lambda r: model.report(rank=objects.anything(r)),
        "Model.summary": lambda r: model.summary(rank=objects.anything(r)),
        "Model.to_rust": lambda r: model.to_rust(some(r, None)),
        "Model.to_c": lambda r: model.to_c(some(r, None)),
        "Model.save": lambda r: model.save(objects.anything(r)),
        "Model.__eq__": lambda r: model.__eq__(objects.anything(r)),
        "Detector": lambda r: bw.Detector(some(r, model), run_a_trace=some(r, False)),
        "Detector.run": lambda r: detector.run(some(r, some(r, traces["a"], objects.table, 2))),
        "Detector.run by names": lambda r: detector.run(current_a=objects.column(r), velocity_rad_s=objects.column(r)),
        "Detector.step": lambda r: detector.step(some(r, some(r, traces["a"], objects.table, 2))),
        "Detector.finish": lambda r: detector.finish(),
        "pickle": lambda r: pickle.loads(pickle.dumps(model)),
        "replay": lambda r: bw.replay(some(r, model, one_in=8), some(r, some(r, traces, objects.tables, 2))),
        "read": lambda r: bw.read(some(r, file), some(r, None), time=some(r, None), rate_hz=some(r, None)),
        "audit": lambda r: bw.audit(some(r, file), some(r, None), **options(r)),
        "init": lambda r: bw.init(
            some(r, file),
            out=some(r, None),
            labels=some(r, None),
            labels_from_names=some(r, None),
            front_end=some(r, None),
            force=some(r, False),
            time=some(r, None),
            rate_hz=some(r, None),
        ),
        "simulate": lambda r: bw.simulate(
            some(r, "spall"),
            count=some(r, 1),
            seed=some(r, 1),
            **options(r, ["severity", "rig", "mix", "condition", "nonsense"]),
        ),
        "fleet.features": lambda r: fleet.features(
            some(r, file), some(r, None), out=some(r, "p.parquet"), **channels(r)
        ),
        "fleet.train_features": lambda r: fleet.train_features(
            objects.anything(r), model=some(r, "m.bwm"), **options(r)
        ),
        "GaussianClassifier": lambda r: (
            sklearn.GaussianClassifier(
                priors=some(r, None), cost=some(r, None), discriminant=some(r, "linear"), shrinkage=some(r, None)
            )
            .fit(some(r, rows), some(r, classes))
            .predict(some(r, rows, objects.an_array))
        ),
        "NoveltyDetector": lambda r: (
            sklearn.NoveltyDetector(false_alarm=some(r, 0.05))
            .fit(some(r, rows), runs=some(r, None))
            .predict(some(r, rows, objects.an_array))
        ),
        "Verdicts": lambda r: (found.to_numpy(), found.columns(), len(found), found._repr_html_()),
    }


def test_every_function_refuses_what_it_cannot_use_with_a_sentence(functions, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    calls, results, slowest, wrong = collections.Counter(), collections.Counter(), (0.0, ""), collections.OrderedDict()
    names = list(functions)
    for k in range(COUNT):
        random = np.random.default_rng([SEED, k])
        name, RARER[0] = names[k % len(names)], objects.pick(random, [1, 3, 10])
        faulthandler.dump_traceback_later(10 * LONGEST, exit=True)
        start = time.monotonic()
        calls[name] += 1
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                functions[name](random)
            results[name] += 1
        except (ValueError, TypeError, OSError) as refusal:
            if len(str(refusal)) < 8:
                wrong.setdefault(f"{name}: {refusal!r}", k)
        except BaseException as other:
            wrong.setdefault(f"{name}: {type(other).__name__}: {str(other)[:100]}", k)
        slowest = max(slowest, (time.monotonic() - start, f"{name}, draw {k}"))
        faulthandler.cancel_dump_traceback_later()
    print(f"{COUNT} calls, {sum(results.values())} with a result, longest {slowest[0]:.2f} s: {slowest[1]}")
    assert not wrong, "\n".join(f"draw {k}: {what}" for what, k in wrong.items())
    assert slowest[0] < LONGEST, slowest
    # Good arguments come often enough that functions are not only refused.
    assert 3 * len(results) > 2 * len(names) or COUNT < 1000, results
