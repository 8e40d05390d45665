# SPDX-License-Identifier: Apache-2.0
"""docs/python_example.py runs, in small."""
import pathlib
import runpy
import sys


def test_the_example_runs(monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", ["python_example.py", "100"])
    runpy.run_path(str(pathlib.Path(__file__).parents[2] / "docs" / "python_example.py"))
    told = capsys.readouterr().out
    assert "PSNR of the batch" in told and "points move by" in told
