# SPDX-License-Identifier: Apache-2.0
"""Event files, read by a reader that shares nothing with their writer."""
import json
import struct

import pytest

from conftest import STEPS
from splinevox import tensorboard


def crc32c(data):
    """Bit by bit, from the highest: the polynomial 0x1EDC6F41 on bytes turned round."""
    crc = 0xFFFFFFFF
    for byte in data:
        crc ^= int(f"{byte:08b}"[::-1], 2) << 24
        for _ in range(8):
            crc = (crc << 1 ^ (0x1EDC6F41 if crc >> 31 else 0)) & 0xFFFFFFFF
    return int(f"{crc ^ 0xFFFFFFFF:032b}"[::-1], 2)


def unmasked(crc):
    turned = (crc - 0xA282EAD8) & 0xFFFFFFFF
    return (turned >> 17 | turned << 15) & 0xFFFFFFFF


def records(data):
    while data:
        (length,) = struct.unpack_from("<Q", data)
        assert unmasked(*struct.unpack_from("<I", data, 8)) == crc32c(data[:8])
        body, end = data[12:12 + length], 12 + length
        assert len(body) == length and unmasked(*struct.unpack_from("<I", data, end)) == crc32c(body)
        yield body
        data = data[end + 4:]


def fields(message):
    """{field: [value]} of a protocol buffer."""
    found, at = {}, 0

    def varint():
        nonlocal at
        value = shift = 0
        while True:
            byte = message[at]
            at += 1
            value |= (byte & 127) << shift
            shift += 7
            if byte < 128:
                return value

    while at < len(message):
        key = varint()
        kind = key & 7
        if kind == 0:
            value = varint()
        else:
            size = {1: 8, 2: None, 5: 4}[kind]
            size = varint() if size is None else size
            value = message[at:at + size]
            at += size
            value = struct.unpack("<d" if kind == 1 else "<f", value)[0] if kind != 2 else value
        found.setdefault(key >> 3, []).append(value)
    return found


def values(path):
    """[(step, wall time, value message)] of an event file."""
    events = [fields(record) for record in records(path.read_bytes())]
    assert events[0][3] == [b"brain.Event:2"]
    return [(e.get(2, [0])[0], e[1][0], fields(fields(e[5][0])[1][0])) for e in events[1:]]


def test_the_reader_knows_the_checksum():
    assert crc32c(b"123456789") == 0xE3069283  # RFC 3720, appendix B.4 has the polynomial


def test_every_number_of_a_run_arrives(run, tmp_path, capsys):
    assert tensorboard.main([run, "--out", str(tmp_path)]) == 0
    (path,) = (tmp_path / "run").iterdir()
    assert capsys.readouterr().out.strip() == str(path) and "tfevents" in path.name
    found = values(path)
    scalars = {(step, v[1][0].decode()): (v[2][0], wall) for step, wall, v in found if 2 in v}
    with open(run + "/metrics.jsonl") as f:
        lines = [json.loads(line) for line in f]
    wanted = [line for line in lines if "loss" in line]
    assert wanted[-1]["step"] == STEPS
    for line in wanted:
        loss, wall = scalars[line["step"], "train/loss"]
        assert loss == pytest.approx(line["loss"], rel=1e-6)
        assert wall - scalars[wanted[0]["step"], "train/loss"][1] == pytest.approx(
            line["seconds"] - wanted[0]["seconds"], abs=1e-3)
    assert (STEPS, "end/peak_memory_bytes") in scalars
    (config,) = [v for _, _, v in found if v[1] == [b"config"]]
    assert b"max_steps = 60" in fields(config[8][0])[8][0]
    pictures = [fields(v[4][0]) for _, _, v in found if v[1] == [b"held"]]
    assert pictures and all((p[1], p[2]) == ([32], [32]) and p[4][0][:4] == b"\x89PNG" for p in pictures)


def test_again_is_the_same_file_and_a_torn_line_is_none(run, tmp_path):
    first = tensorboard.write_events(run, tmp_path).read_bytes()
    assert tensorboard.write_events(run, tmp_path).read_bytes() == first
    (tmp_path / "torn").mkdir()
    (tmp_path / "torn/metrics.jsonl").write_text('{"step": 3, "seconds": 1.5, "loss": 0.25}\n{"step": 4, "se')
    ((step, _, value),) = values(tensorboard.write_events(tmp_path / "torn", tmp_path / "events"))
    assert (step, value[1], value[2]) == (3, [b"train/loss"], [0.25])


def test_what_is_no_run_is_said(tmp_path, capsys):
    assert tensorboard.main([str(tmp_path), "--out", str(tmp_path / "out")]) == 2
    assert "metrics.jsonl" in capsys.readouterr().err
    with pytest.raises(SystemExit):
        tensorboard.main([str(tmp_path), str(tmp_path), "--out", str(tmp_path / "out")])
