"""The table of a campaign as Arrow columns, and as Parquet.

    python -m racing_lmpc.rows out/study-grip                  writes out/study-grip/runs.parquet
    python -m racing_lmpc.rows out/study-grip/runs.csv --parquet grip.parquet

Needs ``pyarrow`` (``pip install racing-lmpc[rows]``). Whole numbers become int64, numbers float64,
``lap_times_s`` a list of float64; an empty field is null. Numbers are those of the CSV to the last
bit: both hold the shortest text, or the bits, of the same double.
"""

from __future__ import annotations

import argparse
import csv
import os
import pathlib
from collections.abc import Sequence
from typing import Any

#: Columns that are words whatever stands in them.
WORDS = ("failure", "limits", "fail_message", "settings", "car", "track", "plant")


def _column(name: str, fields: list[str]) -> Any:
    import pyarrow  # type: ignore[import-untyped]

    if name == "lap_times_s":
        lists = [[float(lap) for lap in field.split()] for field in fields]
        return pyarrow.array(lists, pyarrow.list_(pyarrow.float64()))
    texts = [field or None for field in fields]
    if name not in WORDS and any(texts):
        for read, kind in ((int, pyarrow.int64()), (float, pyarrow.float64())):
            try:
                return pyarrow.array([None if text is None else read(text) for text in texts], kind)
            except (ValueError, OverflowError):
                continue
    return pyarrow.array(texts, pyarrow.string())


def table(path: str | os.PathLike[str]) -> Any:
    """The runs of a study as a ``pyarrow.Table``; ``.to_pandas()`` makes a data frame of it.

    Args:
        path: folder of the study, or its ``runs.csv``.
    """
    import pyarrow

    file = pathlib.Path(path)
    file = file / "runs.csv" if file.is_dir() else file
    with open(file, newline="", encoding="utf-8") as lines:
        head, *rows = csv.reader(lines)
    return pyarrow.table({name: _column(name, [row[i] for row in rows]) for i, name in enumerate(head)})


def main(arguments: Sequence[str] | None = None) -> None:
    """The command line, see the module."""
    import pyarrow.parquet  # type: ignore[import-untyped]

    parser = argparse.ArgumentParser(prog="racing_lmpc.rows", description="Writes a table of runs as Parquet.")
    parser.add_argument("runs", type=pathlib.Path, help="folder of a study, or its runs.csv")
    parser.add_argument("--parquet", type=pathlib.Path, help="file; by default runs.parquet beside the table")
    options = parser.parse_args(arguments)
    folder = options.runs if options.runs.is_dir() else options.runs.parent
    out = options.parquet or folder / "runs.parquet"
    runs = table(options.runs)
    pyarrow.parquet.write_table(runs, out)
    print(f"{runs.num_rows} runs, {runs.num_columns} columns: {out}")


if __name__ == "__main__":
    main()
