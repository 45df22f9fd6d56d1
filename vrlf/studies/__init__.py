"""What drives many cases: each study takes a device and gives back a report.

========== ==========================================================================
file       holds
========== ==========================================================================
bench      how long each pass takes at several panel sizes, against its float64 twin
change     what a change of prescription does to the frames that run on
endurance  whether anything grows over ten thousand frames
quality    how near each prefilter brings what is perceived to what it should be
steps      what bench times: passes, the making of their tables, twins
========== ==========================================================================
"""
