"""The live window: ``vrlf preview``.

========== ======================================================================
file       holds
========== ======================================================================
keys       the one table of keys: F1, the README and the window read it
session    ``Session``: what the user has chosen so far; no window in it
steps      prescription and rig in the clinic's steps
layout     where in the window which view stands
frames     ``Frames``: from a session to what the window shows, frame by frame
pacing     frame times, dropped frames, what gives way when time is short
panels     Dear ImGui: sliders, help, frame times, messages
saving     screenshots, the rig's file
loop       ``Preview``: the window, its keys and mouse, its faults
========== ======================================================================
"""
