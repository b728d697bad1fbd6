"""
Sweeps: a grid or a sample of scenarios, times seeds, flown on all cores or on a Dask cluster.

`study.py` reads a study, `plan.py` resolves and checks every run of it, `local.py` or `cluster.py` has the
runs flown by `worker.py`, `parts.py` keeps each run as it ends, `table.py` writes all of them into one
Parquet file. `summary.py`, `figures.py` and `page.py` show the content of that file only, with the intervals
of `statistics.py`. For users there is docs/how_to/sweeps.md.
"""
