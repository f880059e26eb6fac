"""Reading of a recording of a million rows: the workbench beside pandas and pyarrow.

    python reading.py DIR PROGRAM     writes the files, runs PROGRAM FILE ROUNDS; table on standard output
    python reading.py --once FILE     the time of one read in a new process

Each reads every column into memory as doubles. Exit code 1 if a wanted ratio is missed, 2 if the sums of the values
differ.
"""

import statistics
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq

ROWS, ROUNDS = 1_000_000, 11
COLUMNS = ["current_a", "velocity_rad_s", "load_torque_nm", "voltage_v", "temperature_c", "angle_rad"]


def timed(path, rounds):
    read = pd.read_csv if path.suffix == ".csv" else pq.read_table
    times = []
    for _ in range(rounds):
        start = time.perf_counter()
        table = read(path)
        times.append(time.perf_counter() - start)
    return statistics.median(times), float(sum(table[name].to_numpy().sum() for name in COLUMNS))


def in_new_processes(command):
    """The median time of one read in each of several new processes."""
    once = [float(subprocess.check_output(command, text=True).split()[0]) for _ in range(ROUNDS)]
    return statistics.median(once)


def main(folder, program):
    draw = np.random.default_rng(1)
    table = pd.DataFrame({"t_s": np.arange(ROWS) / 1000.0})
    for name in COLUMNS:
        table[name] = np.round(draw.standard_normal(ROWS), 6)
    csv, parquet = Path(folder) / "reading.csv", Path(folder) / "reading.parquet"
    table.to_csv(csv, index=False)
    pq.write_table(pa.Table.from_pandas(table, preserve_index=False), parquet)
    print("| file | MB | reads of a process | ours, s | peer | theirs, s | ratio | asked |")
    print("|---|---|---|---|---|---|---|---|")
    code = 0
    for kind, path, peer, wanted in [("CSV", csv, "pandas", 2.0), ("Parquet", parquet, "pyarrow", 1.0)]:
        theirs, expected = timed(path, ROUNDS)
        own, total = map(float, subprocess.check_output([program, path, str(ROUNDS)], text=True).split())
        if abs(total - expected) > 1e-6 * ROWS:
            print(f"{kind}: the sums differ, {total} and {expected}", file=sys.stderr)
            return 2
        first = [in_new_processes([program, path, "1"]), in_new_processes([sys.executable, __file__, "--once", path])]
        code = max(code, int(theirs / own < wanted))
        rows = [("the first", first, ""), (f"median of {ROUNDS}", (own, theirs), f"≥ {wanted:.0f}")]
        for reads, (own, theirs), asked in rows:
            size, ratio = path.stat().st_size / 1e6, theirs / own
            print(f"| {kind} | {size:.0f} | {reads} | {own:.3f} | {peer} | {theirs:.3f} | {ratio:.1f} | {asked} |")
    return code


if __name__ == "__main__":
    if sys.argv[1] == "--once":
        print(timed(Path(sys.argv[2]), 1)[0])
    else:
        sys.exit(main(*sys.argv[1:]))
