"""Parquet beside CSV: the same numbers."""

import csv

import pyarrow

from racing_lmpc import rows

TABLE = """run,plant.mu,car,seed,failure,best_lap_s,fallbacks,lap_times_s,settings
0,0.7,barc,0,,4.100000000000001,0,6.5 4.100000000000001,0123
1,1,barc,1,spin,,3,,0e45
"""


def test_columns_have_kinds_and_numbers_their_bits(tmp_path, capsys):
    import pyarrow.parquet

    (tmp_path / "runs.csv").write_text(TABLE)
    rows.main([str(tmp_path)])
    assert "2 runs" in capsys.readouterr().out
    found = pyarrow.parquet.read_table(tmp_path / "runs.parquet")
    kinds = {field.name: str(field.type) for field in found.schema}
    assert kinds["run"] == "int64" and kinds["plant.mu"] == "double" and kinds["fallbacks"] == "int64"
    # Fingerprints look like numbers now and then.
    assert kinds["settings"] == "string" and kinds["failure"] == "string"
    columns = found.to_pydict()
    assert columns["settings"] == ["0123", "0e45"] and columns["failure"] == [None, "spin"]
    assert columns["best_lap_s"] == [4.100000000000001, None]
    assert columns["lap_times_s"] == [[6.5, 4.100000000000001], []]


def test_every_field_of_a_campaign_comes_back(tmp_path):
    import racing_lmpc as lmpc
    from racing_lmpc import engines

    file = tmp_path / "two.toml"
    file.write_text('laps = 1\nseeds = 2\n[[record]]\ncolumn = "v_x_mps"\ntake = ["max", 0.99]\n')
    engines.study(file, tmp_path / "out", lambda drive, jobs: ((job, drive(job)) for job in jobs))
    found = rows.table(tmp_path / "out").to_pydict()
    assert list(found) == lmpc.Campaign(file).columns
    with open(tmp_path / "out" / "runs.csv", newline="") as lines:
        for i, row in enumerate(csv.DictReader(lines)):
            for name, text in row.items():
                value = found[name][i]
                if isinstance(value, float):
                    assert value == float(text)
                elif isinstance(value, list):
                    assert value == [float(part) for part in text.split()]
                else:
                    assert (text or None) == (None if value is None else str(value))
