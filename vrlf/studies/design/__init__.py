"""Finding the array that serves an eye best.

============= ==================================================================
file          holds
============= ==================================================================
target        dead leaves: what candidates are judged by
patch         the operator of a small patch of one eye, sampled in 0.1 s
score         decibels of a candidate on it, over cases that are a little off too
space         what is searched, about the matched focus; what is on sale
scorer        candidates judged side by side, and what it costs
search        grid, Optuna, all turns, simplex
sensitivity   what each number of the best may be off by; brightness
design        ``run_design``: all of it, the best checked by the whole chain
report        table, JSON, rig file
pictures      maps and curves
============= ==================================================================
"""
