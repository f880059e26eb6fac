"""The DBC file of `bearing-watch dbc` is read by cantools, and logs that python-can writes are read by `listen`."""

import json
from pathlib import Path

import can
import cantools
import pytest

MODEL = Path(__file__).parents[2] / "examples" / "support" / "standard_rig" / "model.bwm"


@pytest.fixture(name="message", scope="module", params=["0x123", "0x18FF1234"])
def of_model(command, request):
    """The message of the DBC file, as cantools reads it without leniency."""
    text = command("dbc", "--model", MODEL, "--id", request.param)
    [message] = cantools.database.load_string(text, "dbc", strict=True).messages
    number = int(request.param, 16)
    assert (message.frame_id, message.is_extended_frame, message.length) == (number, number > 0x7FF, 8)
    return message


def test_signals_are_those_of_the_table(message):
    data = bytes([7, 0, 0b010_00111, 3, 3, 26, 0x80 | 61, 255])
    expected = {
        "Segment": 7,
        "Verdict": "undetermined",
        "Reason": "stuck sensor",
        "Undetermined": 2,
        "Place": 3,
        "Alarm": "spall",
        "Deviations": 6.5,
        "Usable": 61,
        "Silent": 1,
        "Distance": 63.75,
    }
    assert message.decode(data) == expected
    assert message.encode(expected) == data
    units = {signal.name: signal.unit for signal in message.signals if signal.unit}
    assert units == {"Deviations": "sd", "Usable": "%", "Distance": "sd"}
    assert sum(signal.length for signal in message.signals) == 64
    verdicts = ["undetermined", "novel", "ambiguous", "healthy", "spall", "roughness"]
    assert [str(name) for name in message.get_signal_by_name("Verdict").choices.values()] == verdicts


@pytest.mark.parametrize("is_fd", [False, True])
@pytest.mark.parametrize("ending", ["log", "asc"])
def test_logs_of_another_program_are_read(message, command, tmp_path, ending, is_fd):
    log = tmp_path / f"bus.{ending}"
    numbers = [*range(200, 231), *range(233, 600)]
    usual = {"Reason": "none", "Undetermined": 0, "Place": 0, "Alarm": "none", "Deviations": 0, "Silent": 0}
    with can.Logger(log) as writer:
        for number in numbers:
            signals = {**usual, "Segment": number % 256, "Usable": 90, "Distance": 0.5, "Verdict": "healthy"}
            time = 1.7e9 + 6 * number
            common = {"is_extended_id": message.is_extended_frame, "is_rx": True, "channel": 0}
            own = {**common, "arbitration_id": message.frame_id, "is_fd": is_fd, "timestamp": time}
            writer(can.Message(data=message.encode(signals), **own))
            writer(can.Message(data=b"12345", **{**common, "arbitration_id": 5, "timestamp": time + 1}))
        writer(can.Message(is_remote_frame=True, dlc=8, **{**common, "arbitration_id": 5, "timestamp": time + 2}))
        writer(can.Message(is_error_frame=True, timestamp=time + 3, channel=0))
    shown = f"0x{message.frame_id:03x}" if not message.is_extended_frame else f"0x{message.frame_id:08x}"
    *segments, end = map(json.loads, command("listen", log, "--can-id", shown, "--model", MODEL, "--json").splitlines())
    assert [line["segment"] for line in segments] == numbers
    assert {line["verdict"] for line in segments} == {"healthy"}
    counts = {key: end[key] for key in ("segments", "lost", "other_ids", "remote", "error_frames", "unread_lines")}
    expected = {"segments": 398, "lost": 2, "other_ids": 398, "remote": 1, "error_frames": 1, "unread_lines": 0}
    assert counts == expected
