"""Recordings as arrays, an audit, a drive file, and the replay of recordings through a model."""

import json
import sys

import bearing_watch as bw
import numpy as np
import pytest

from conftest import from_json, quietly, read_csv


def test_a_file_becomes_columns_with_units(folder):
    file = folder / "spall_3_000.csv"
    trace, columns = bw.read(file), read_csv(file)
    assert trace.name == "spall_3_000.csv" and len(trace) == 5000
    assert np.array_equal(trace.time_s, columns.pop("t_s")) and trace.interval_s == pytest.approx(0.002)
    assert list(trace.columns) == list(columns)
    for name, values in columns.items():
        assert np.array_equal(trace[name], values), name
    units = [trace.units[name] for name in ("current_a", "velocity_rad_s", "load_torque_nm")]
    assert units == ["A", "rad/s", "Nm"]
    formula = bw.read(file, ["velocity_ref_rad_s-velocity_rad_s", "(velocity_rad_s)rpm"])
    assert np.allclose(formula["(velocity_rad_s)rpm"], trace["velocity_rad_s"] * 30 / np.pi)
    assert formula.units == {"(velocity_rad_s)rpm": "rpm"}
    untimed = bw.read(file, ["current_a"], time="none", rate_hz=500)
    assert untimed.interval_s == pytest.approx(0.002)
    table = trace.to_pandas()
    assert list(table.columns) == list(columns) and table.index.name == "time_s"


def test_a_tidy_table_is_several_traces(tmp_path):
    file = tmp_path / "all.csv"
    file.write_text("trace,t_s,current_mA\na,0,1\nb,0,2\na,1,3\n")
    first, second = bw.read(file)
    assert (first.name, first["current_mA"].tolist(), second["current_mA"].tolist()) == ("a", [1, 3], [2])
    with pytest.raises(bw.BearingWatchError, match="no column"):
        bw.read(file, ["voltage"])
    with pytest.raises(FileNotFoundError):
        bw.read(tmp_path / "none.csv")
    with pytest.raises(bw.BearingWatchError, match="rate_hz"):
        bw.read(file, rate_hz=-1)


def test_an_audit_is_that_of_the_command_line(program, folder):
    done = program("audit", folder, "--labels", folder / "labels.csv", "--false-alarm", 0.02, "--json")
    found = bw.audit(folder, folder / "labels.csv", false_alarm=0.02)
    assert found.report == from_json(done.stdout)
    assert (done.returncode == 1) == bool(found.findings)
    assert "12 traces, 60000 rows" in str(found) and "<pre>" in found._repr_html_()
    with pytest.raises(bw.BearingWatchError, match="did you mean false_alarm"):
        bw.audit(folder, false_alram=0.02)


def test_a_drive_file_is_proposed(command, bench, folder, tmp_path):
    drive = bw.init(folder, out=tmp_path / "drive.toml", labels=folder / "labels.csv")
    command("init", folder, "--out", tmp_path / "own.toml", "--labels", folder / "labels.csv")
    assert open(drive).read() == (tmp_path / "own.toml").read_text()
    with pytest.raises(bw.BearingWatchError, match="exists"):
        bw.init(folder, out=drive)
    bw.init([folder], out=drive, labels=folder / "labels.csv", force=True)
    assert set(quietly(lambda: bw.train(drive, novelty="none")).classes) == {"healthy", "roughness", "spall"}


def test_a_replay_is_that_of_the_command_line(command, model, bench, folder, tmp_path):
    file = tmp_path / "m.bwm"
    model.save(file)
    names = ["healthy_3_000", "spall_3_001"]
    paths = [folder / f"{name}.csv" for name in names]
    segments = json.loads(command("replay", "--model", file, *paths, "--json"))
    found = bw.replay(file, paths)
    assert [name.removesuffix(".csv") for name in found] == names
    verdicts = [verdict for own in found.values() for verdict in own.verdict.tolist()]
    assert verdicts == [own["verdict"] for own in segments]
    scores = np.concatenate([own.score for own in found.values()])
    assert np.array_equal(scores, np.float32([own["score"] for own in segments]))
    arrays = bw.replay(model, {name: bench.traces[name] for name in names})
    assert list(arrays) == names
    for own, other in zip(arrays.values(), found.values()):
        assert own.to_numpy().tobytes() == other.to_numpy().tobytes()


def test_verdicts_are_tables(model, bench, monkeypatch):
    found = bw.Detector(model).run(bench.traces["spall_3_000"])
    table = found.to_pandas()
    assert len(table) == len(found) and table["verdict"].tolist() == found.verdict.tolist()
    assert {"p_spall", "feature_drag", "slip_outer", "score"} <= set(table.columns)
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(ImportError, match="to_pandas needs pandas: pip install pandas"):
        found.to_pandas()


def test_notebooks_show_tables(model, bench, folder):
    shown = bw.Detector(model).run(bench.traces["spall_3_000"])._repr_html_()
    assert shown.count("<tr>") == 6 and "p spall" in shown and "5 segments" in shown
    assert "order_outer" in model._repr_html_()
    judged = quietly(lambda: bw.evaluate(model, bench.traces, bench.labels))
    assert "error rate" in judged._repr_html_() and judged._repr_html_().count("<tr>") == 4
    odd = bw.Audit([], {}, "<script>")
    assert "<script>" not in odd._repr_html_()


def test_what_is_left_out_or_asked_is_a_warning(tmp_path):
    file = tmp_path / "log.csv"
    rows = "".join(f"{123456789 + 250 * k},{k % 7},word\n" for k in range(400))
    file.write_text("timestamp,current_A,state\n" + rows + "5,1")
    with pytest.warns(bw.BearingWatchWarning) as told:
        trace = bw.read(file)
    said = "\n".join(str(one.message) for one in told)
    assert "the file ends inside it" in said and "taken in us" in said and "column state" in said
    assert list(trace.columns) == ["current_A"] and trace.interval_s == pytest.approx(250e-6)
    with pytest.warns(bw.BearingWatchWarning) as told:
        bw.init(tmp_path)
    assert any("Which recordings are healthy" in str(one.message) for one in told)


def test_the_layout_of_a_text_is_given_where_guessing_fails(tmp_path):
    file = tmp_path / "odd.txt"
    file.write_text("1~2\n3~4\nt_s~n\ns~foo\n0~2,000\n0.5~13,000.5\n1~7\n")
    trace = bw.read(file, skip=2, units_row=True, separator="~", decimal="point")
    assert trace["n"].tolist() == [2000.0, 13000.5, 7.0]
    assert trace.interval_s == 0.5
    with pytest.raises(bw.BearingWatchError, match="separates no cells"):
        bw.read(file, separator="7")
