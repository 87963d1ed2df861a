"""The notebook of the manual runs from its first cell to its last, on results as run.sh leaves them."""

import re
from pathlib import Path

import nbclient
import nbformat
import pytest

NOTEBOOK = Path(__file__).resolve().parents[2] / "manual" / "results.ipynb"


def test_the_notebook_runs(place, shear, network, monkeypatch, tmp_path):
    assert shear.is_relative_to(place)
    assert network.is_relative_to(place)
    monkeypatch.setenv("FEMDEM_PROJECT", str(place))
    notebook = nbformat.read(NOTEBOOK, as_version=4)
    nbclient.NotebookClient(notebook, timeout=300, resources={"metadata": {"path": str(tmp_path)}}).execute()
    outputs = [output for cell in notebook.cells for output in cell.get("outputs", [])]
    text = "".join(output.get("text", "") for output in outputs)
    # The peak that figure and manual have of this joint, with elements of 3 mm
    assert float(re.search(r"peak ([\d.]+) kPa", text)[1]) == pytest.approx(43.6, abs=0.5)
    assert float(re.search(r"rms difference from eq 13 ([\d.]+) %", text)[1]) < 1.0
    assert sum("image/png" in output.get("data", {}) for output in outputs) == 3
    assert "joint elements in pyvista" in text
    nbformat.write(notebook, tmp_path / "done.ipynb")
