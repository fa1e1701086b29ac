"""The code of the tutorial runs, block after block."""

import pathlib
import re

PAGE = pathlib.Path(__file__).parents[2] / "docs" / "tutorials" / "python.md"


def test_the_tutorial_runs(capsys):
    blocks = re.findall(r"```python\n(.*?)```", PAGE.read_text(), re.DOTALL)
    names = {}
    for block in blocks:
        exec(compile(block, str(PAGE), "exec"), names)
    shown = capsys.readouterr().out
    assert len(blocks) >= 9 and "stepz" in shown and names["info"]["lap"] == 6
    assert 1.0 < names["race"].best_lap / names["optimum"].lap_time < 1.2
