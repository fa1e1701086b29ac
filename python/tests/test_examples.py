"""The examples run."""

import importlib.util
import pathlib

import nbclient
import nbformat

import racing_lmpc as lmpc

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


def test_tuning_keeps_its_constraints_and_repeats():
    spec = importlib.util.spec_from_file_location("tune", EXAMPLES / "tune.py")
    tune = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(tune)
    first, second = (tune.study("barc", "l", trials=5, laps=3) for _ in range(2))
    assert [t.value for t in first.trials] == [t.value for t in second.trials]
    kept = tune.feasible(first)
    assert kept and kept[0].value <= first.trials[0].value
    race = lmpc.race("barc", "l", laps=3)
    assert first.trials[0].value == race.best_lap
    # What comes too close to an edge breaks a constraint.
    failing = tune.study("barc", "l", trials=1, laps=3, margin=10.0)
    assert not tune.feasible(failing)
