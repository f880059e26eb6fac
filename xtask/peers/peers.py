"""What other programs need for the work that `workbench/cli/examples/peers.rs` times, and the table of both.

    python peers.py DIR RUST_JSON OXICTL_JSON     table on standard output
    python peers.py --numpy DIR                   (itself, with the number of BLAS threads set) JSON on standard output

DIR holds train.csv and validate.csv: y, u1, u2 and the velocity reference. The naive search is what a user of numpy and
scipy writes: a regressor matrix and `lstsq` for every structure, `lfilter` for every simulation.
"""

import io
import itertools
import json
import os
import statistics
import subprocess
import sys
import time
import warnings
from contextlib import redirect_stdout
from pathlib import Path

import numpy as np
from scipy.signal import lfilter

SINGLE = (2, 2, 2, 1, 1)
GRID = list(itertools.product(range(1, 5), repeat=5))


def load(folder):
    """(y, u1, u2) of the training and the validation trace."""
    return [signals[:3] for signals in load_all(folder)]


def load_all(folder):
    """(y, u1, u2, reference) of both."""
    return [np.loadtxt(Path(folder) / name, delimiter=",", skiprows=1).T.copy() for name in ("train.csv", "validate.csv")]


def depth(order):
    na, nb, nc, nkb, nkc = order
    return max(na, nb + nkb - 1, nc + nkc - 1)


def regressors(order, output, u1, u2):
    na, nb, nc, nkb, nkc = order
    t0, n = depth(order), len(output)
    lag = lambda x, k: x[t0 - k : n - k]
    return np.column_stack(
        [-lag(output, k) for k in range(1, na + 1)]
        + [lag(u1, nkb + k) for k in range(nb)]
        + [lag(u2, nkc + k) for k in range(nc)]
    )


def least_squares(order, y, u1, u2):
    return np.linalg.lstsq(regressors(order, y, u1, u2), y[depth(order) :], rcond=None)[0]


def simulate(order, theta, u1, u2):
    """Output from the inputs alone, unstable poles reflected."""
    na, nb, nc, nkb, nkc = order
    a = np.concatenate([[1.0], theta[:na]])
    poles = np.roots(a)
    outside = np.abs(poles) > 1.0
    if outside.any():
        poles[outside] = 1.0 / np.conj(poles[outside])
        a = np.poly(poles).real
    b = np.concatenate([np.zeros(nkb), theta[na : na + nb]])
    c = np.concatenate([np.zeros(nkc), theta[na + nb :]])
    return lfilter(b, a, u1) + lfilter(c, a, u2)


def fit(y, simulated):
    return 100.0 * (1.0 - np.linalg.norm(simulated - y) / np.linalg.norm(y - y.mean()))


def instrumental(order, y, u1, u2, instruments):
    """Parameters, and X, Z and ZᵀX that they follow from."""
    x, z = regressors(order, y, u1, u2), regressors(order, instruments, u1, u2)
    zx = z.T @ x
    return np.linalg.solve(zx, z.T @ y[depth(order) :]), (x, z, zx)


def iv4_stages(order, y, u1, u2):
    """Parameters, the filtered output, and X, Z and ZᵀX of the last stage."""
    t0, n = depth(order), sum(order[:3])
    theta = least_squares(order, y, u1, u2)
    theta, _ = instrumental(order, y, u1, u2, simulate(order, theta, u1, u2))
    w = y[t0:] - regressors(order, y, u1, u2) @ theta
    lags = np.column_stack([-w[n - k : len(w) - k] for k in range(1, n + 1)])
    shaping = np.concatenate([[1.0], np.linalg.lstsq(lags, w[n:], rcond=None)[0]])
    filtered = [lfilter(shaping, [1.0], x) for x in (y, u1, u2, simulate(order, theta, u1, u2))]
    theta, products = instrumental(order, *filtered)
    return theta, filtered[0], products


def iv4(order, y, u1, u2):
    return iv4_stages(order, y, u1, u2)[0]


def whole(order, y, u1, u2, theta, residuals, cofactor):
    """What `identify` returns: parameters, residual variance, covariance, residuals, simulation and prediction fit."""
    residual_sum = residuals @ residuals
    variance = residual_sum / (len(residuals) - len(theta))
    measured = y[depth(order) :]
    return {
        "theta": theta,
        "covariance": variance * cofactor,
        "variance": variance,
        "residual_sum": residual_sum,
        "fits": [fit(y, simulate(order, theta, u1, u2)), fit(measured, measured - residuals)],
    }


def whole_normal(order, y, u1, u2):
    """By normal equations; one inverse serves the parameters and the covariance."""
    x, target = regressors(order, y, u1, u2), y[depth(order) :]
    cofactor = np.linalg.inv(x.T @ x)
    theta = cofactor @ (x.T @ target)
    return whole(order, y, u1, u2, theta, target - x @ theta, cofactor)


def whole_lstsq(order, y, u1, u2):
    x, target = regressors(order, y, u1, u2), y[depth(order) :]
    theta = np.linalg.lstsq(x, target, rcond=None)[0]
    return whole(order, y, u1, u2, theta, target - x @ theta, np.linalg.inv(x.T @ x))


def whole_iv4(order, y, u1, u2):
    """With cov θ = σ² (ZᵀX)⁻¹ ZᵀZ (XᵀZ)⁻¹ of the filtered data."""
    theta, target, (x, z, zx) = iv4_stages(order, y, u1, u2)
    inverse = np.linalg.inv(zx)
    return whole(order, y, u1, u2, theta, target[depth(order) :] - x @ theta, inverse @ (z.T @ z) @ inverse.T)


def clock(runs, call, statistic=statistics.median):
    """Median or other statistic of the times of a call, s, and its last result."""
    times = []
    for _ in range(runs):
        start = time.perf_counter()
        result = call()
        times.append(time.perf_counter() - start)
    return statistic(times), result


# Least times: other work on the machine reaches a median of calls as short as these.
WHOLE = (("whole_normal", whole_normal, 1001), ("whole_lstsq", whole_lstsq, 1001), ("whole_iv4", whole_iv4, 201))


def numpy_half(folder):
    train, (y, u1, u2) = load(folder)
    result = {}
    for name, method, runs in (("ls", least_squares, 5), ("iv4", iv4, 3)):
        estimate_s, thetas = clock(runs, lambda: [method(order, *train) for order in GRID])

        def scored():
            return [fit(y, simulate(order, method(order, *train), u1, u2)) for order in GRID]

        score_s, fits = clock(runs, scored)
        structures = [[order, f, theta.tolist()] for order, f, theta in zip(GRID, fits, thetas)]
        result[name] = {"estimate_s": estimate_s, "score_s": score_s, "structures": structures}
    one_s, theta = clock(201, lambda: least_squares(SINGLE, *train))
    result["one_ls"] = {"lone_s": one_s, "theta": theta.tolist()}
    result["one_iv4"] = {"lone_s": clock(51, lambda: iv4(SINGLE, *train))[0]}
    for name, method, runs in WHOLE:
        seconds, found = clock(runs, lambda: method(SINGLE, *train), min)
        result[name] = {"s": seconds} | {key: np.asarray(value).ravel().tolist() for key, value in found.items()}
    return result


def sippy_arx(train):
    from sippy_unipi import system_identification

    y, u1, u2 = train
    na, nb, nc, nkb, nkc = SINGLE
    # Its delays count from one sample after the input.
    orders = [[na], [[nb, nc]], [[nkb - 1, nkc - 1]]]
    call = lambda: system_identification(y, np.vstack([u1, u2]), "ARX", ARX_orders=orders)
    seconds, model = clock(7, call)
    numerator, denominator = model.NUMERATOR[0], model.DENOMINATOR[0]
    theta = denominator[0][1 : na + 1] + numerator[0][nkb - 1 :][:nb] + numerator[1][nkc - 1 :][:nc]
    return seconds, np.array(theta)


def sippy_armax(folder):
    """Time and parameters of SINGLE with one noise term."""
    from sippy_unipi import system_identification

    y, u1, u2, _ = np.loadtxt(Path(folder) / "armax.csv", delimiter=",", skiprows=1).T.copy()
    na, nb, nc, nkb, nkc = SINGLE
    orders = [[na], [[nb, nc]], [1], [[nkb - 1, nkc - 1]]]
    inputs = np.vstack([u1, u2])
    call = lambda: system_identification(y, inputs, "ARMAX", ARMAX_orders=orders, max_iterations=100)
    seconds, model = clock(3, call)
    numerator, denominator = model.NUMERATOR[0], model.DENOMINATOR[0]
    theta = denominator[0][1 : na + 1] + numerator[0][nkb - 1 :][:nb] + numerator[1][nkc - 1 :][:nc]
    return seconds, np.array(theta)


def extended_precision(order, signals, start):
    """The least-squares parameters of the sums from `start` on, with the 64-bit mantissa of `longdouble`."""
    y, u1, u2 = [np.asarray(x, np.longdouble) for x in signals]
    x, target = regressors(order, y, u1, u2)[start - depth(order) :], y[start:]
    # Gram–Schmidt, twice: orthogonal to the last bit.
    q, r = x.copy(), np.eye(x.shape[1], dtype=np.longdouble)
    for _ in range(2):
        step = np.zeros_like(r)
        for k in range(q.shape[1]):
            for j in range(k):
                step[j, k] = (q[:, j] * q[:, k]).sum()
                q[:, k] -= step[j, k] * q[:, j]
            step[k, k] = np.sqrt((q[:, k] ** 2).sum())
            q[:, k] /= step[k, k]
        r = step @ r
    theta = (q * target[:, None]).sum(axis=0)
    for k in reversed(range(len(theta))):
        theta[k] = (theta[k] - (r[k, k + 1 :] * theta[k + 1 :]).sum()) / r[k, k]
    return theta


def relative(theta, exact):
    return float((np.abs(np.array(theta, np.longdouble) - exact) / np.abs(exact)).max())


def one_input(folder, rust, oxictl):
    """Time, accuracy and free-run fit beside oxictl, which takes one input; whether it is beaten."""
    order = (2, 2, 0, 1, 1)
    traces = load_all(folder)
    beaten = True
    print("\nOne input, two terms of y and u1, delay 1, against oxictl 0.1.1 (least squares by normal equations; its")
    print("instrumental variables use 4096 samples):\n")
    print("| u1 | program | method | time | error against extended precision | free-run fit, validation |\n|---|---|---|---|---|---|")
    for name, column in (("error", 1), ("reference", 3)):
        # oxictl's sums start a sample later; each is held against the exact solution of its own sums.
        signals = [(y, u[column], u[2]) for u in traces for y in (u[0],)]
        errors = {}
        for program, found, start in (("ours", rust["one_input"][name], 2), ("oxictl", oxictl[name], 3)):
            for method, outcome in found.items():
                if "failed" in outcome:
                    print(f"| {name} | {program} | {method} | {milliseconds(outcome['s'])} | – | {outcome['failed']} |")
                    continue
                theta = np.array(outcome["theta"])
                error = "–"
                if method == "ls":
                    errors[program] = relative(theta, extended_precision(order, signals[0], start))
                    error = f"{errors[program]:.1e}"
                y, u1, u2 = signals[1]
                score = f"{fit(y, simulate(order, theta, u1, u2)):.2f} %"
                print(f"| {name} | {program} | {method} | {milliseconds(outcome['s'])} | {error} | {score} |")
        beaten &= errors["ours"] < errors["oxictl"] and rust["one_input"][name]["ls"]["s"] < oxictl[name]["ls"]["s"]
    print()
    return beaten


def milliseconds(seconds):
    return f"{seconds * 1e3:.3g} ms"


def same_results(method, ours, theirs):
    """Whether both wholes give the same numbers, so that the same work is timed."""
    scale = lambda x: np.abs(x).max()
    differences = {}
    for key in ("theta", "covariance", "variance", "residual_sum", "fits"):
        a, b = np.ravel(ours[key]), np.ravel(theirs[key])
        differences[key] = float(scale(a - b) / scale(b))
    text = ", ".join(f"{key.replace('_', ' ')} {value:.1e}" for key, value in differences.items())
    print(f"* all of `identify::{method}` against numpy, largest relative differences: {text}.")
    return max(differences.values()) < 1e-6


def agreement(name, ours, theirs):
    """How the two searches compare, and whether the same structures win."""
    ours = {tuple(order): (f, np.array(theta)) for order, f, theta in ours["structures"]}
    theirs = {tuple(order): (f, np.array(theta)) for order, f, theta in theirs["structures"]}
    assert set(ours) == set(theirs) == set(GRID)
    fits = max(abs(ours[o][0] - theirs[o][0]) for o in GRID)
    thetas = max(np.abs(ours[o][1] - theirs[o][1]).max() / np.abs(theirs[o][1]).max() for o in GRID)

    def winners(found):
        best = {}
        for order in GRID:
            d = sum(order[:3])
            if d not in best or found[order][0] > found[best[d]][0]:
                best[d] = order
        return max(found, key=lambda o: found[o][0]), best

    (best, by_count), (naive, naive_by_count) = winners(ours), winners(theirs)
    same = sum(by_count[d] == naive_by_count[d] for d in by_count)
    verdict = "agree" if best == naive and same == len(by_count) else "DIFFER"
    print(
        f"* {name}: winners {verdict}: best {list(best)} against {list(naive)}, {same} of {len(by_count)} of the best by "
        f"parameter count; largest difference of a fit {fits:.1e} points, of a parameter {thetas:.1e} relative."
    )
    return verdict == "agree"


def table(folder, rust, oxictl, peers):
    train, _ = load(folder)
    best = lambda *keys: min(peer[keys[0]][keys[1]] for peer in peers)
    rows = []
    for name, least in (("ls", 8), ("iv4", 4)):
        for what, key in (("estimation alone", "estimate"), ("with scoring", "score")):
            theirs = best(name, f"{key}_s")
            asked = f"≥ {least}" if key == "score" else ""
            title = f"1024 structures by {name}, {what}"
            rows.append((f"{title}, two threads", rust[name][f"{key}_s"], "numpy + scipy", theirs, asked))
            rows.append((f"{title}, one thread", rust[name][f"{key}_one_thread_s"], "numpy + scipy", theirs, ""))
    rows.append(("one ls estimate", rust["one_ls"]["lone_s"], "numpy lstsq", best("one_ls", "lone_s"), "≥ 1"))
    whole_ls, whole_iv4 = rust["one_ls"]["whole"]["s"], rust["one_iv4"]["whole"]["s"]
    for peer, key in (("numpy normal equations", "whole_normal"), ("numpy lstsq", "whole_lstsq")):
        rows.append(("`identify::least_squares`, all of it", whole_ls, peer, best(key, "s"), "≥ 4"))
    rows.append(("one iv4 estimate", rust["one_iv4"]["lone_s"], "numpy iv4", best("one_iv4", "lone_s"), "≥ 4"))
    rows.append(("`identify::iv4`, all of it", whole_iv4, "numpy iv4", best("whole_iv4", "s"), "≥ 4"))
    with warnings.catch_warnings(), redirect_stdout(io.StringIO()):
        warnings.simplefilter("ignore")
        arx_s, arx = sippy_arx(train)
        armax_s, armax = sippy_armax(folder)
    rows.append(("one ls estimate", rust["one_ls"]["lone_s"], "sippy_unipi ARX", arx_s, "≥ 1"))
    rows.append(("one armax estimate, one noise term", rust["armax"]["s"], "sippy_unipi ARMAX", armax_s, "≥ 1"))
    print(f"N = {rust['samples']}, y = current, u1 = velocity error, u2 = load torque. Medians; the better of one and")
    print("two BLAS threads for numpy. All of an `identify` call is timed by the least of at least 201 calls.\n")
    print("| work | ours | peer | theirs | ratio | asked |\n|---|---|---|---|---|---|")
    met = True
    for work, ours, peer, theirs, asked in rows:
        ratio = theirs / ours
        met &= not asked or ratio >= float(asked[2:])
        print(f"| {work} | {milliseconds(ours)} | {peer} | {milliseconds(theirs)} | {ratio:.3g} | {asked} |")
    print()
    exact = extended_precision(SINGLE, train, depth(SINGLE))
    for name, theta in (
        ("ours, `structure`", rust["one_ls"]["theta"]),
        ("ours, `identify`", rust["one_ls"]["whole"]["theta"]),
        ("numpy lstsq", peers[0]["one_ls"]["theta"]),
        ("sippy_unipi ARX", arx),
    ):
        print(f"* ls {list(SINGLE)} against extended precision, {name}: {relative(theta, exact):.1e} relative.")
    truth, sd = np.array(rust["armax"]["truth"]), np.array(rust["armax"]["sd"])
    errors = [np.sqrt(np.mean(((np.array(t) - truth) / sd) ** 2)) for t in (rust["armax"]["theta"], armax)]
    print("* armax on a true ARMAX system, rms error of the parameters in their standard deviations: "
          f"ours {errors[0]:.2f}, sippy_unipi {errors[1]:.2f}.")
    met &= bool(errors[0] <= errors[1])
    for method, name in (("least_squares", "ls"), ("iv4", "iv4")):
        ours, theirs = rust[f"one_{name}"]["whole"], peers[0]["whole_lstsq" if name == "ls" else "whole_iv4"]
        met &= same_results(method, ours, theirs)
    for name in ("ls", "iv4"):
        met &= agreement(name, rust[name], peers[0][name])
    met &= one_input(folder, rust, oxictl)
    print("Every ratio and agreement asked for is met." if met else "NOT every ratio and agreement asked for is met.")
    return met


def main():
    if sys.argv[1] == "--numpy":
        json.dump(numpy_half(sys.argv[2]), sys.stdout)
        return True
    folder, rust, oxictl = sys.argv[1], *[json.loads(Path(name).read_text()) for name in sys.argv[2:4]]
    peers = []
    for threads in ("1", "2"):
        names = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")
        environment = os.environ | dict.fromkeys(names, threads)
        command = [sys.executable, __file__, "--numpy", folder]
        peers.append(json.loads(subprocess.run(command, env=environment, check=True, stdout=subprocess.PIPE).stdout))
    return table(folder, rust, oxictl, peers)


if __name__ == "__main__":
    sys.exit(0 if main() else 1)
