"""Reading of a recording of a million rows: the workbench beside pandas and pyarrow.

    python reading.py DIR PROGRAM     writes the files, runs PROGRAM FILE ROUNDS; table on standard output

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

ROWS, ROUNDS = 1_000_000, 5
COLUMNS = ["current_a", "velocity_rad_s", "load_torque_nm", "voltage_v", "temperature_c", "angle_rad"]


def timed(read):
    times = []
    for _ in range(ROUNDS):
        start = time.perf_counter()
        table = read()
        times.append(time.perf_counter() - start)
    return statistics.median(times), float(sum(table[name].to_numpy().sum() for name in COLUMNS))


def main(folder, program):
    draw = np.random.default_rng(1)
    table = pd.DataFrame({"t_s": np.arange(ROWS) / 1000.0})
    for name in COLUMNS:
        table[name] = np.round(draw.standard_normal(ROWS), 6)
    csv, parquet = Path(folder) / "reading.csv", Path(folder) / "reading.parquet"
    table.to_csv(csv, index=False)
    pq.write_table(pa.Table.from_pandas(table, preserve_index=False), parquet)
    rows = [
        ("CSV", csv, "pandas", 2.0, lambda: pd.read_csv(csv)),
        ("Parquet", parquet, "pyarrow", 1.0, lambda: pq.read_table(parquet)),
    ]
    print("| file | MB | workbench, s | peer | peer, s | ratio | wanted |\n|---|---|---|---|---|---|---|")
    code = 0
    for kind, path, peer, wanted, read in rows:
        theirs, expected = timed(read)
        own, total = map(float, subprocess.check_output([program, path, str(ROUNDS)], text=True).split())
        if abs(total - expected) > 1e-6 * ROWS:
            print(f"{kind}: the sums differ, {total} and {expected}", file=sys.stderr)
            return 2
        ratio = theirs / own
        code = max(code, int(ratio < wanted))
        size = path.stat().st_size / 1e6
        print(f"| {kind} | {size:.0f} | {own:.3f} | {peer} | {theirs:.3f} | {ratio:.1f} | ≥ {wanted:.0f} |")
    return code


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
