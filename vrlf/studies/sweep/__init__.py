"""A sweep: any grid or sample of rig keys, sources and methods, on many workers.

======= =============================================================================
file    holds
======= =============================================================================
plan    ``Plan``: job number to rig, source and method; what a sweep is known by
jobs    one job: what both eyes perceive against what they should
bench   what a worker keeps: one thread with one GL context
rows    a job's row, its checksum, the columns
journal rows as they come, line by line, whole lines only
store   ``Store``: the folder of a sweep, each row exactly once
cluster workers on this machine, or those of a Dask scheduler
keepers what starts this machine's workers, and others when they die
worker  such a worker's process
run     jobs in a bounded window; workers that die, jobs that fail
======= =============================================================================

Dask, distributed and pyarrow are an extra and are imported when a sweep runs.
"""
