"""The table of the field by a plain program in numpy, beside that of `bearing-watch-studies campaign --field`.

    python field.py RECORDS OURS_JSON     table on standard output; exit code 3 if ours is behind in a cell

RECORDS is the program `workbench/studies/examples/field_records.rs`, which writes the records of a row: both sides have the
same seeds. OURS_JSON is the output of `campaign --field --json`; its rows and draws are repeated here.

The method is what an engineer writes by hand. Missing samples are interpolated. Filters of second order give current,
velocity, acceleration and load without differentiation of noise; least squares give inertia, viscous and Coulomb
friction, load coefficient and offset. The residual of this balance, behind a faster filter, is added up in bins of the
shaft angle behind the same filter, and the powers of both directions are added: a delay that is left shifts the phases
of the two directions apart. The features are viscous friction, Coulomb friction, and the peak within
+-2 % of the outer race's order and its harmonics over the neighbourhood. A shrunk covariance of 150 healthy records
gives a Mahalanobis distance; its 99 % quantile on these records is the threshold. (Median and MAD instead of mean and
deviation find less: the tails of the friction estimates then raise the threshold.)
"""

import json
import subprocess
import sys

import numpy as np

FRICTION_HZ, RESIDUAL_HZ = 8.0, 100.0
SETTLE = 100  # samples dropped at the start
SLOWEST_RAD_S = 4.0  # slower samples are not in the spectrum
BINS = 64  # angle bins a turn
HARMONICS = ((1, 1.0), (2, 0.4), (3, 0.2))  # and their weights
PEAK, NEAR, FAR = 0.02, 0.05, 0.15  # peak within +-2 %, neighbours from 5 to 15 %
SHRINK, QUANTILE = 0.1, 0.99


def read_exactly(stream, count):
    parts = []
    while count > 0 and (part := stream.read(count)):
        parts.append(part)
        count -= len(part)
    if count > 0:
        raise EOFError("the records end early")
    return b"".join(parts)


def records(program, row, draw):
    """Header, and one list of (set, {column: records x samples})."""
    with subprocess.Popen([program, row, str(draw)], stdout=subprocess.PIPE) as child:
        header = json.loads(child.stdout.readline())
        columns, samples = header["columns"], header["samples"]
        for own in header["sets"]:
            shape = (own["count"], len(columns), samples)
            values = np.frombuffer(read_exactly(child.stdout, 8 * int(np.prod(shape))), "<f8").reshape(shape)
            yield header, own, dict(zip(columns, values.transpose(1, 0, 2)))


def interpolated(signal):
    """Missing samples between their neighbours, for each record."""
    lost = np.isnan(signal)
    if not lost.any():
        return signal
    places, filled = np.arange(signal.shape[1]), signal.copy()
    for one, gaps in zip(filled, lost):
        one[gaps] = np.interp(places[gaps], places[~gaps], one[~gaps])
    return filled


def state_variable(signals, cutoff_hz, interval_s):
    """Low-pass (Butterworth, second order) and derivative of each signal (signals x records x samples)."""
    w = np.tan(np.pi * cutoff_hz * interval_s) * 2 / interval_s
    a = np.array([[0.0, 1.0], [-w * w, -np.sqrt(2) * w]])
    left = np.linalg.inv(np.eye(2) - 0.5 * interval_s * a)
    step, enter = left @ (np.eye(2) + 0.5 * interval_s * a), left @ np.array([0.0, w * w]) * interval_s
    state = np.stack([signals[..., 0], np.zeros(signals.shape[:-1])])
    out = np.empty((2, *signals.shape))
    out[..., 0] = state
    inputs = np.moveaxis(0.5 * (signals[..., 1:] + signals[..., :-1]), -1, 0).copy()
    for k, u in enumerate(inputs, 1):
        x, v = state
        state = np.stack([row[0] * x + row[1] * v + gain * u for row, gain in zip(step, enter)])
        out[..., k] = state
    return out


def balance(filtered, load):
    """Columns of the balance (records x samples x columns), and the current."""
    (current, velocity, *torque), (_, acceleration, *_) = filtered
    columns = [acceleration, velocity, np.tanh(0.5 * velocity), np.ones_like(velocity)]
    return np.stack(columns + (torque if load else []), -1)[:, SETTLE:], current[:, SETTLE:]


def order_peak(residual, velocity, angle_rad, outer):
    """Logarithm of the weighted peaks over their neighbourhoods; NaN without motion."""
    place = np.floor((angle_rad - angle_rad.min()) * BINS / (2 * np.pi)).astype(int)
    length = max(4096, 8 << int(np.ceil(np.log2(place.max() + 1))))
    power = np.zeros(length // 2 + 1)
    for moving in (velocity > SLOWEST_RAD_S, velocity < -SLOWEST_RAD_S):
        power += np.abs(np.fft.rfft(np.bincount(place[moving], residual[moving]), length)) ** 2
    if not power.any():
        return np.nan
    orders = np.arange(len(power)) * BINS / length
    total = 0.0
    for harmonic, weight in HARMONICS:
        off = np.abs(orders / (harmonic * outer) - 1)
        inside = off <= max(PEAK, off.min())
        total += weight * power[inside].max() / np.mean(power[(off > NEAR) & (off <= FAR)])
    return np.log(total)


def features(header, columns):
    """Viscous and Coulomb friction and the order's peak of each record; NaN if it has none."""
    load = "load_torque_nm" in columns
    names = ["current_a", "velocity_rad_s"] + ["load_torque_nm"] * load
    signals = np.stack([interpolated(columns[name]) for name in [*names, "angle_rad"]])
    slow = state_variable(signals[:-1], FRICTION_HZ, header["interval_s"])
    fast = state_variable(signals, RESIDUAL_HZ, header["interval_s"])
    angle = fast[0, -1, :, SETTLE:]
    (rows, current), (fast_rows, fast_current) = balance(slow, load), balance(fast[:, :-1], load)
    found = []
    for k, own in enumerate(rows):
        theta = np.linalg.lstsq(own[::5], current[k][::5], rcond=None)[0]
        residual = fast_current[k] - fast_rows[k] @ theta
        found.append([theta[1], theta[2], order_peak(residual, fast_rows[k][:, 1], angle[k], header["outer"])])
    return np.array(found)


class Class:
    """Mean and shrunk covariance of a class."""

    def __init__(self, rows):
        self.centre, self.spread = rows.mean(0), rows.std(0, ddof=1)
        correlation = (1 - SHRINK) * np.corrcoef(rows.T) + SHRINK * np.eye(rows.shape[1])
        self.inverse, self.log_det = np.linalg.inv(correlation), np.linalg.slogdet(correlation)[1]

    def distance2(self, rows):
        scaled = (rows - self.centre) / self.spread
        return np.einsum("ij,jk,ik->i", scaled, self.inverse, scaled)

    def minus_log_likelihood(self, rows):
        return 0.5 * (self.distance2(rows) + self.log_det) + np.log(self.spread).sum()


def tally(outcomes, known):
    return [int((outcomes & known).sum()), int((~outcomes & known).sum()), int((~known).sum())]


def draw(program, row, number):
    """Tallies (counted, opposite, undetermined) of the columns, and of the three classes at both sizes."""
    training, judged = {}, {}
    for header, own, columns in records(program, row, number):
        key, sets = (own["kind"], own["severity"]), training if own["purpose"] == "Training" else judged
        sets[key] = features(header, columns)
    usable = {key: rows[np.isfinite(rows).all(1)] for key, rows in training.items()}
    gate = Class(usable["healthy", 1.0])
    limit = np.quantile(gate.distance2(usable["healthy", 1.0]), QUANTILE)
    known = {key: np.isfinite(rows).all(1) for key, rows in judged.items()}
    detected = {key: tally(gate.distance2(rows) > limit, known[key]) for key, rows in judged.items()}
    if not header["three_classes"]:
        return detected, None
    kinds = ["healthy", "spall", "roughness"]
    classes = [Class(usable[kind, 1.0]) for kind in kinds]
    errors = []
    for size in (1.0, 0.5):
        counts = np.zeros(3, int)
        for truth, kind in enumerate(kinds):
            key = (kind, 1.0 if kind == "healthy" else size)
            rows = judged[key][: len(judged["spall", 1.0])]
            decided = np.argmin([one.minus_log_likelihood(rows) for one in classes], 0)
            counts += tally(decided != truth, known[key][: len(rows)])
        errors.append([int(counts[0] + counts[2]), int(counts[1]), 0])
    return detected, errors


def rate(tallies):
    """Rate in percent with the interval of `workbench/studies/src/field/tally.rs`."""
    counted, judged = np.array([t[0] for t in tallies], float), np.array([sum(t) for t in tallies], float)
    n, p = judged.sum(), counted.sum() / judged.sum()
    if 0 < p < 1 and len(tallies) > 1:
        excess = ((counted - p * judged) ** 2).sum() / (len(tallies) - 1) / (n / len(tallies) * p * (1 - p))
        n /= max(1.0, excess)
    q = 1.959963984540054
    centre = (p + q * q / (2 * n)) / (1 + q * q / n)
    half = q / (1 + q * q / n) * np.sqrt(p * (1 - p) / n + (q / n / 2) ** 2)
    return [100 * p, 100 * max(0.0, min(centre - half, p)), 100 * min(1.0, max(centre + half, p))]


def keys(heading):
    """Kind and severity of a column's heading."""
    if heading == "false alarms":
        return "healthy", 1.0
    kind, size = heading.split()
    return kind, 1 / float(size.split("/")[1]) if "/" in size else 1.0


def shown(cell):
    return "refused" if cell is None else f"{cell[0]:.1f} [{cell[1]:.1f}, {cell[2]:.1f}]"


def behind(ours, theirs, small):
    """Whether ours is worse by more than the intervals allow; `small`: lower is better."""
    if ours is None:
        return True
    gap = ours[0] - theirs[0] if small else theirs[0] - ours[0]
    sides = (ours[0] - ours[1], theirs[2] - theirs[0]) if small else (ours[2] - ours[0], theirs[0] - theirs[1])
    return bool(gap > np.hypot(*sides))


def rates_of_ours(cells):
    percent = lambda own: None if own is None else [100 * own["rate"][key] for key in ("value", "low", "high")]
    return [percent(own) for own in cells]


def plain_row(program, own, ours):
    """Rates of the plain program: columns, three-class errors (or none), and undetermined records in percent."""
    draws = [draw(program, own["name"], number) for number in range(ours["first"], ours["first"] + ours["draws"])]
    tallies = [[detected[keys(heading)] for detected, _ in draws] for heading in ours["columns"]]
    errors = [rate([e[k] for _, e in draws]) for k in range(2)] if draws[0][1] else []
    everything = [t for column in tallies for t in column]
    without = 100 * sum(t[2] for t in everything) / sum(map(sum, everything))
    return [rate(column) for column in tallies], errors, without


def table(head, rows):
    print(f"| {' | '.join(head)} |\n|{'---|' * len(head)}")
    for row in rows:
        print(f"| {' | '.join(row)} |")
    print()


def main():
    program, ours = sys.argv[1], json.load(open(sys.argv[2]))
    plain, both, errors, late = [], [], [], []
    for own in ours["rows"]:
        theirs, their_errors, without = plain_row(program, own, ours)
        mine = rates_of_ours(own["detected"])
        plain.append([own["name"], *map(shown, theirs), f"{without:.1f}"])
        pair = lambda a, b: f"{'refused' if a is None else f'{a[0]:.1f}'} / {b[0]:.1f}"
        cells = list(zip(ours["columns"], mine, theirs, [True] + [False] * len(mine)))
        if their_errors:
            my_errors = rates_of_ours(own["three_class_error"])
            errors.append([own["name"], *(f"{shown(a)} / {shown(b)}" for a, b in zip(my_errors, their_errors))])
            cells += zip(("error at full size", "error at half size"), my_errors, their_errors, (True, True))
        lost = [name for name, a, b, small in cells if behind(a, b, small)]
        late += [f"{own['name']}: {name}" for name in lost]
        verdict = f"no: {', '.join(lost)}" if lost else "yes"
        both.append([own["name"], *(pair(a, b) for a, b in zip(mine, theirs)), verdict])
        print(f"{own['name']} done", file=sys.stderr)
    print(f"{ours['draws']} draws; the plain program, detected in % [95 % interval]:\n")
    table(["row", *ours["columns"], "no verdict"], plain)
    print("Ours / the plain program, detected in %; ahead or equal within the intervals:\n")
    table(["row", *ours["columns"], "ahead or equal"], both)
    if errors:
        print("Three classes, error in %, ours / the plain program:\n")
        table(["row", "full size", "half size"], errors)
    print(f"Behind the plain program by more than the intervals: {'; '.join(late)}." if late
          else "In no cell behind the plain program by more than the intervals.")
    return not late


if __name__ == "__main__":
    sys.exit(0 if main() else 3)
