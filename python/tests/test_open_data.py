"""Layouts of public recordings, written as their authors and packages write them, from `init` to a model."""

import re
import zipfile

import bearing_watch as bw
import numpy as np
import pytest

from conftest import document, quietly, told

savemat = pytest.importorskip("scipy.io").savemat
pandas = pytest.importorskip("pandas")
pyarrow = pytest.importorskip("pyarrow")
parquet = pytest.importorskip("pyarrow.parquet")

#: Rows a second of a converter, and of a data acquisition with a slow and a fast raster.
CONVERTER_HZ, FAST_HZ, SLOW_HZ = 16_000, 64_000, 4_000
SPEED_HZ = 25.0


def workbook(path):
    """A workbook of a spreadsheet, as far as its first bytes."""
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("xl/workbook.xml", "<workbook/>")


def converter(random, is_damaged, rows):
    """Signals of a converter by their names: phase currents in A, angle in turns from -0.5 to 0.5, speed."""
    turns = SPEED_HZ * np.arange(rows) / CONVERTER_HZ + random.random()
    noise = random.normal(size=(4, rows))
    amplitude = 3.0 + 0.5 * is_damaged
    angles = [4 * np.pi * turns - shift for shift in (0, 2.094, 4.189)]
    phases = [amplitude * np.sin(angle) + 0.05 * own for angle, own in zip(angles, noise)]
    names = ("current_u", "current_v", "current_w")
    return {
        **dict(zip(names, phases)),
        "angle": (turns + 0.5) % 1 - 0.5,
        "speed": SPEED_HZ / CONVERTER_HZ * (1 + 1e-3 * noise[3]),
    }


@pytest.fixture(scope="module")
def matrices(tmp_path_factory):
    """Files of one matrix of 16 rows: time, currents, voltages, bus, angle, current vector, speed, deviation, zeros."""
    folder = tmp_path_factory.mktemp("matrices")
    random = np.random.default_rng(7)
    for k in range(12):
        own = converter(random, k >= 6, 8192)
        rows = np.zeros((16, 8192))
        rows[0] = np.arange(8192) / CONVERTER_HZ
        rows[1:4] = own["current_u"], own["current_v"], own["current_w"]
        rows[4:8] = 40 * np.cos(rows[1:5]) + random.normal(size=(4, 8192))
        rows[8:12] = own["angle"], 1e3 * own["current_u"], own["speed"], 1e-6 * random.normal(size=8192)
        savemat(folder / f"H1.{k + 1}.mat", {"StromBox_Werte": rows}, do_compression=True)
    workbook(folder / "labels.xlsx")
    return folder


def test_a_matrix_of_a_converter_is_read_described_and_trained(command, matrices, tmp_path):
    turns = "6.283185307179586*StromBox_Werte_9"
    trace = quietly(lambda: bw.read(matrices / "H1.1.mat", ["StromBox_Werte_2", turns]))
    assert trace.interval_s == pytest.approx(1 / CONVERTER_HZ, rel=2e-5) and len(trace) == 8192
    assert -np.pi <= trace[turns].min() < -3 and 3 < trace[turns].max() < np.pi
    drive, said = told(lambda: bw.init(matrices, out=tmp_path / "drive.toml"))
    assert "labels.xlsx: content: an Excel workbook, which is not read: save its sheet as CSV, the labels as" in said
    assert quietly(lambda: bw.train(drive)).classes == ["reference"]
    assert "16000.0000 rows a second" in quietly(lambda: bw.audit(drive)).text
    # The workbook, saved as CSV.
    labels = tmp_path / "labels.csv"
    rows = [f"H1.{k + 1},{'normal' if k < 6 else 'pitting'}" for k in range(12)]
    labels.write_text("trace,class_name\n" + "\n".join(rows))
    quietly(lambda: bw.init(matrices, out=drive, labels=labels, force=True))
    assert quietly(lambda: bw.train(drive)).classes == ["normal", "pitting"]
    command("convert", matrices, "--out", tmp_path / "csv", "--format", "csv")
    assert len(list((tmp_path / "csv").glob("*.csv"))) == 12


def channels(values):
    """A structure array of channels with name and data."""
    array = np.zeros((1, len(values)), dtype=[(name, object) for name in ("Name", "Data", "Raster")])
    for place, (name, data, raster) in enumerate(values):
        array[0, place] = (name, np.reshape(data, (1, -1)), raster)
    return array


@pytest.fixture(scope="module")
def structures(tmp_path_factory):
    """Files of a structure with channels at 64 kHz and 4 kHz in Y, whose times are in X."""
    folder = tmp_path_factory.mktemp("structures")
    random = np.random.default_rng(8)
    fast, slow = np.arange(16_000) / FAST_HZ, np.arange(1000) / SLOW_HZ
    for bearing, damage in (("K001", 0.0), ("KA04", 0.4)):
        for k in range(1, 7):
            name = f"N15_M07_F10_{bearing}_{k}"
            wave = damage * np.sin(2 * np.pi * 76 * fast)
            currents = [np.sin(2 * np.pi * 100 * fast - shift) + wave for shift in (0, 2.094)]
            noise = [0.05 * random.normal(size=16_000) for _ in range(3)]
            own = [
                ("force", 1000 + random.normal(size=1000), "Mech_4kHz"),
                ("phase_current_1", currents[0] + noise[0], "HostService"),
                ("phase_current_2", currents[1] + noise[1], "HostService"),
                ("speed", 1500 + random.normal(size=1000), "Mech_4kHz"),
                ("temp_2_bearing_module", np.full(2, 45.0), "Temp_1Hz"),
                ("torque", 0.7 + random.normal(size=1000), "Mech_4kHz"),
                ("vibration_1", noise[2], "HostService"),
            ]
            axes = [("HostService", fast, ""), ("Mech_4kHz", slow, ""), ("Temp_1Hz", np.arange(2.0), "")]
            run = {"Info": {"Setup": "x"}, "X": channels(axes), "Y": channels(own), "Description": "run"}
            savemat(folder / f"{name}.mat", {name: run}, do_compression=True)
    return folder


def test_a_structure_of_channels_has_the_time_of_its_axes(structures, tmp_path):
    trace, said = told(lambda: bw.read(structures / "N15_M07_F10_K001_1.mat"))
    assert "array force: left out: it has 1000 values where the longest have 16000" in said
    assert trace.interval_s == pytest.approx(1 / FAST_HZ, rel=2e-5)
    assert list(trace.columns) == ["phase_current_1", "phase_current_2", "vibration_1"]
    drive = quietly(lambda: bw.init(structures, out=tmp_path / "drive.toml"))
    text = open(drive).read()
    assert 'y = "phase_current_1"' in text and "64000" in text
    model = quietly(lambda: bw.train(drive))
    assert sorted(model.classes) == ["k001", "ka04"]
    assert model.interval_s == pytest.approx(1 / FAST_HZ, rel=2e-5)


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    """A built set of the package bearing-datasets: an index of signals, and signals as lists in row groups."""
    folder = tmp_path_factory.mktemp("sets") / "lenze_mb"
    (folder / "signals").mkdir(parents=True)
    random = np.random.default_rng(9)
    index, groups = [], []
    units = {"current_u": "A", "current_v": "A", "current_w": "A", "angle": "rev", "speed": "unknown"}
    for k in range(12):
        own = converter(random, k >= 6, 8000)
        ids = [f"H1.{k + 1}/{channel}" for channel in own]
        groups.append(pyarrow.table({"signal_id": ids, "signal": pyarrow.array([list(x) for x in own.values()])}))
        for row, (channel, signal_id) in enumerate(zip(own, ids)):
            about = {"dataset": "lenze_mb", "signal_id": signal_id, "recording_id": f"H1.{k + 1}", "channel": channel}
            kind = {"unit": units[channel], "fs": CONVERTER_HZ, "n_samples": 8000, "speed_rpm": 1500.0, "load": 2.0}
            fault = {"native_label": "H1", "fault_type": "normal" if k < 6 else "inner"}
            place = {"signal_file": "part-float64.parquet", "signal_row_group": k, "signal_row": row}
            index.append({**about, **kind, **fault, **place})
    with parquet.ParquetWriter(folder / "signals" / "part-float64.parquet", groups[0].schema) as writer:
        for group in groups:
            writer.write_table(group, row_group_size=len(group))
    pandas.DataFrame(index).to_parquet(folder / "metadata.parquet")
    (folder / "manifest.json").write_text("{}")
    return folder


def test_a_built_set_becomes_recordings_by_the_lines_of_the_book(command, built, tmp_path):
    with pytest.raises(bw.BearingWatchError, match=r"column signal: a signal in each cell .* file for each recording"):
        bw.init(built, out=tmp_path / "none.toml")
    (lines,) = [own for own in document("STORES.md", "python") if "metadata.parquet" in own]
    runs = tmp_path / "runs"
    lines, count = re.subn('"sets/lenze_mb"', repr(str(built)), lines)
    assert count == 1
    exec(lines.replace('"runs"', repr(str(runs))), {})
    assert len(list(runs.glob("*.parquet"))) == 12
    trace = bw.read(runs / "H1.3.parquet")
    assert list(trace.columns) == ["current_u_A", "current_v_A", "current_w_A", "angle_rev"]
    assert trace.interval_s == pytest.approx(1 / CONVERTER_HZ, rel=2e-5)
    drive = tmp_path / "drive.toml"
    command("init", runs, "--out", drive)
    command("train", drive, "--model", tmp_path / "m.bwm")
    assert sorted(bw.Model.load(tmp_path / "m.bwm").classes) == ["inner", "normal"]
