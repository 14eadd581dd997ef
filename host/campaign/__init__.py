"""Many runs: seeds times swept values, on local processes or on a Dask cluster, and what they say together.

plan → check of each set-up → pool or cluster → journal → Parquet, summary, report
"""
