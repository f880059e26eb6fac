from pathlib import Path

import pytest

nbformat, nbclient = pytest.importorskip("nbformat"), pytest.importorskip("nbclient")
EXAMPLES = Path(__file__).parent.parent / "examples"


@pytest.mark.parametrize("path", sorted(EXAMPLES.glob("*.ipynb")), ids=lambda path: path.name)
def test_a_notebook_runs(path, tmp_path):
    notebook = nbformat.read(path, as_version=4)
    nbclient.NotebookClient(notebook, timeout=300, resources={"metadata": {"path": str(tmp_path)}}).execute()
    printed = [own.get("text", "") for cell in notebook.cells for own in cell.get("outputs", [])]
    text = "".join(printed)
    assert "simulation fit" in text and "ALARM: spall" in text
    assert "trained on 20 healthy, 20 spall, 20 roughness traces" in text and "balanced accuracy" in text
    assert not [own for cell in notebook.cells for own in cell.get("outputs", []) if own.get("name") == "stderr"]
    # Kept without results, which would age.
    assert all(not cell.get("outputs") for cell in nbformat.read(path, as_version=4).cells)
