"""What drives many cases: each study takes a device and gives back a report.

========== ==========================================================================
file       holds
========== ==========================================================================
bench      how long each pass takes at several panel sizes, against its float64 twin
change     what a change of prescription does to the frames that run on
design/    the array that serves an eye best, searched
endurance  whether anything grows over ten thousand frames
evaluate   every source, rig and method in all metrics, case by case, resumable
evaluate_charts letters and an edge, shown through the whole chain
evaluate_judge  one case judged: what is shown, seen, and how like it is to the target
evaluate_plots  plots of all that
evaluate_report what an evaluation found as files and as a table
evaluate_store  finished cases on the disk
eyes       what an eye makes of a point and of a letter
eyeplot    the picture of it
frames     how good each frame of a moving picture is, solved from the last or cold
limits     how fast the device copies and fetches, measured
lenslet    a picture of a lenslet's spots, MTF, field curves and colours
mask/      arrays drawn at true scale, tables of lenslets
plots      pictures of what speed and quality have found
quality    how near each prefilter brings what is perceived to what it should be
reproduce/ the thesis's results from content of our own
speed      how long passes and whole frames take against size and the device's limits
steps      what bench times: passes, the making of their tables, twins
sweep/     any grid or sample of rig keys, sources and methods, on many workers
tolerance  what a tolerance gains where things are off, and what it costs
workloads  what speed times, and the least that each step must do
========== ==========================================================================
"""
