#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs as TensorBoard shows them. Needs nothing but Python, not even the compiled module.

    python3 -m splinevox.tensorboard RUN... --out LOGS      # or this file itself
    tensorboard --logdir LOGS

Every RUN becomes LOGS/NAME with one event file: the numbers of metrics.jsonl by step, the last figures of
metrics.json, the pictures in preview and the text of config.toml. Done again, it replaces that file.
"""
import argparse
import json
import os
import pathlib
import re
import struct
import sys

FILE = "events.out.tfevents.0000000000.splinevox"


def _table():
    entries = []
    for byte in range(256):
        for _ in range(8):
            byte = byte >> 1 ^ (0x82F63B78 if byte & 1 else 0)  # Castagnoli, reflected
        entries.append(byte)
    return entries


_CRC32C = _table()


def _masked_crc(data):
    crc = 0xFFFFFFFF
    for byte in data:
        crc = _CRC32C[(crc ^ byte) & 255] ^ crc >> 8
    crc ^= 0xFFFFFFFF
    return ((crc >> 15 | crc << 17) + 0xA282EAD8) & 0xFFFFFFFF


def _record(data):
    """TFRecord: the length and its checksum, the bytes and theirs."""
    length = struct.pack("<Q", len(data))
    checked = [(length, _masked_crc(length)), (data, _masked_crc(data))]
    return b"".join(part + struct.pack("<I", crc) for part, crc in checked)


def _varint(number):
    out = bytearray()
    while number > 127:
        out.append(number & 127 | 128)
        number >>= 7
    out.append(number)
    return bytes(out)


# Fields of protocol buffers by their number; the numbers are those of event.proto and summary.proto.
def _whole(field, number):
    return _varint(field << 3) + _varint(number)


def _double(field, number):
    return _varint(field << 3 | 1) + struct.pack("<d", number)


def _float(field, number):
    return _varint(field << 3 | 5) + struct.pack("<f", number)


def _bytes(field, data):
    return _varint(field << 3 | 2) + _varint(len(data)) + data


def _event(wall_time, step, value):
    return _record(_double(1, wall_time) + _whole(2, step) + _bytes(5, _bytes(1, value)))


def _scalar(tag, number):
    return _bytes(1, tag.encode()) + _float(2, number)


def _picture(tag, png):
    width, height = struct.unpack(">II", png[16:24])
    picture = _whole(1, height) + _whole(2, width) + _whole(3, 3) + _bytes(4, png)  # 3 channels
    return _bytes(1, tag.encode()) + _bytes(4, picture)


def _text(tag, text):
    plugin = _bytes(9, _bytes(1, _bytes(1, b"text")))
    tensor = _bytes(8, _whole(1, 7) + _bytes(8, text.encode()))  # DT_STRING
    return _bytes(1, tag.encode()) + plugin + tensor


def _lines(path):
    """The objects of metrics.jsonl, but for lines that a kill has torn."""
    for line in path.read_text(errors="replace").splitlines():
        try:
            found = json.loads(line)
        except ValueError:
            continue
        if isinstance(found, dict) and isinstance(found.get("step"), int):
            yield found


def _numbers(line):
    """What of a line is drawn: held_psnr as held/psnr, everything else as train/NAME."""
    for key, value in line.items():
        if key in ("step", "seconds") or isinstance(value, bool) or not isinstance(value, (int, float)):
            continue
        yield ("held/" + key[5:] if key.startswith("held_") else "train/" + key), value


def write_events(run, folder):
    """Writes the event file of a run folder into `folder`, which is made. Returns its path. Raises
    OSError, and ValueError where `run` has no metrics.jsonl with a step in it."""
    run, folder = pathlib.Path(run), pathlib.Path(folder)
    metrics = run / "metrics.jsonl"
    if not metrics.is_file():
        raise ValueError(f"{metrics}: there is no such file; the folder of a run is expected")
    lines = list(_lines(metrics))
    if not lines:
        raise ValueError(f"{metrics}: there is no step in it; has the run begun?")
    now, seconds, last = 0.0, {}, lines[-1]["step"]
    for line in lines:  # a discarded step says no time: it is that of the line before
        now = float(line.get("seconds") or now)
        seconds[line["step"]] = now
    begin = metrics.stat().st_mtime - now  # the file was written last with its last line
    events = [_record(_double(1, begin) + _bytes(3, b"brain.Event:2"))]
    for line in lines:
        for tag, value in _numbers(line):
            events.append(_event(begin + seconds[line["step"]], line["step"], _scalar(tag, value)))
    for path in sorted((run / "preview").glob("step_*.png")):
        step = re.fullmatch(r"step_(\d+)\.png", path.name)
        png = path.read_bytes()
        if step and png.startswith(b"\x89PNG"):
            step = int(step.group(1))
            events.append(_event(begin + seconds.get(step, seconds[last]), step, _picture("held", png)))
    end = begin + seconds[last]
    if (run / "metrics.json").is_file():
        figures = json.loads((run / "metrics.json").read_text())
        for key in ("psnr", "ssim", "ms_ssim", "train_seconds", "peak_memory_bytes"):
            if isinstance(figures.get(key), (int, float)):
                events.append(_event(end, last, _scalar("end/" + key, figures[key])))
        for key, value in figures.get("metrics", {}).items():
            events.append(_event(end, last, _scalar("end/" + key, value)))
    if (run / "config.toml").is_file():
        lines = (run / "config.toml").read_text().splitlines()
        code = "".join("    " + line + "\n" for line in lines)  # as Markdown has it
        events.append(_event(begin, 0, _text("config", code)))
    folder.mkdir(parents=True, exist_ok=True)
    draft = folder / (".draft." + str(os.getpid()))
    draft.write_bytes(b"".join(events))
    draft.replace(folder / FILE)
    return folder / FILE


def main(words=None):
    about = "Runs as TensorBoard shows them."
    parser = argparse.ArgumentParser(prog="splinevox.tensorboard", description=about)
    parser.add_argument("run", nargs="+", help="folder of a run, which becomes OUT/NAME")
    parser.add_argument("--out", required=True, help="folder for `tensorboard --logdir`")
    options = parser.parse_args(words)
    names = [pathlib.Path(os.path.abspath(run)).name for run in options.run]
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        parser.error("two runs have one name: " + ", ".join(twice))
    for run, name in zip(options.run, names):
        try:
            print(write_events(run, pathlib.Path(options.out) / name))
        except (OSError, ValueError) as error:
            print(f"splinevox.tensorboard: {error}", file=sys.stderr)
            return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
