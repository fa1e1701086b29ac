"""The examples run."""

import pathlib

import nbclient
import nbformat

EXAMPLES = pathlib.Path(__file__).parents[1] / "examples"


def test_the_notebook_runs_and_is_kept_without_outputs(tmp_path):
    notebook = nbformat.read(EXAMPLES / "race.ipynb", as_version=4)
    nbformat.validate(notebook)
    code = [cell for cell in notebook.cells if cell.cell_type == "code"]
    assert code and all(not cell.outputs and cell.execution_count is None for cell in code)
    nbclient.NotebookClient(notebook, timeout=300, resources={"metadata": {"path": tmp_path}}).execute()
    pictures = [
        output for cell in code for output in cell.outputs
        if "image/png" in output.get("data", {})
    ]
    assert len(pictures) == 3
