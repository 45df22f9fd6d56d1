"""What drives many cases: each study takes a device and gives back a report.

========== ==========================================================================
file       holds
========== ==========================================================================
bench      how long each pass takes at several panel sizes, against its float64 twin
steps      what bench times: passes, the making of their tables, twins
========== ==========================================================================
"""
