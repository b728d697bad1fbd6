"""
Sweeps: a grid or a sample of scenarios, times seeds, flown on all cores or on a Dask cluster.

`study.py` reads what is asked for, `plan.py` resolves and checks every run of it, `cluster.py` has them flown
by `worker.py`, `parts.py` keeps each as it ends, `table.py` puts all of them into one Parquet file, and
`summary.py`, `figures.py` and `page.py` show what is in that file and nothing else.  For users there is
docs/how_to/sweeps.md.
"""
