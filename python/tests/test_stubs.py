"""The stubs are those of the module, and every public thing has a docstring in them."""

import ast
import inspect
import pathlib
import subprocess
import sys

import racing_lmpc


def test_stubs_match_the_module(tmp_path):
    run = subprocess.run(
        [sys.executable, "-m", "mypy.stubtest", "racing_lmpc", "--ignore-disjoint-bases"],
        capture_output=True, text=True, cwd=tmp_path,
    )
    assert run.returncode == 0, run.stdout + run.stderr


def test_everything_public_has_a_docstring():
    text = pathlib.Path(racing_lmpc.__file__).with_name("_native.pyi").read_text()
    count = 0
    for node in ast.walk(ast.parse(text)):
        if not isinstance(node, (ast.ClassDef, ast.FunctionDef)):
            continue
        if node.name in ("__eq__", "__hash__"):
            continue
        count += 1
        assert ast.get_docstring(node), node.name
    assert count > 100


def test_help_shows_what_the_stubs_say():
    text = pathlib.Path(racing_lmpc.__file__).with_name("_native.pyi").read_text()
    count = 0
    for node in ast.parse(text).body:
        if not isinstance(node, (ast.ClassDef, ast.FunctionDef)):
            continue
        thing = getattr(racing_lmpc, node.name)
        expected = ast.get_docstring(node)
        for part in node.body if isinstance(node, ast.ClassDef) else []:
            if not isinstance(part, ast.FunctionDef) or not ast.get_docstring(part):
                continue
            count += 1
            if part.name == "__new__":
                expected += "\n\n" + ast.get_docstring(part)
                continue
            shown = inspect.getdoc(getattr(thing, part.name))
            assert shown == ast.get_docstring(part), f"{node.name}.{part.name}"
        assert inspect.getdoc(thing) == expected, node.name
    assert count > 100
