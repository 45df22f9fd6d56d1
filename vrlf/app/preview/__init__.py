"""The live window: ``vrlf preview``.

========== ======================================================================
file       holds
========== ======================================================================
keys       the one table of keys: F1, the README and the window read it
chords     from glfw's keys to the table's
steps      prescription and rig in the clinic's steps, and alignment's
session    ``Session``: what the user has chosen so far; no window in it
layout     where in the window which view stands
frames     ``Frames``: from a rig to what the window shows, frame by frame
likening   how near the perceived picture comes to the target, in dB
pacing     frame times, dropped frames, what gives way when time is short
fading     ``Guard``: faults are held off the eyes
panels     Dear ImGui: sliders, help, frame times, messages
mouse      divider, zoom, moving, looking around
files      the rig's file, screenshots
state      what is remembered from one time to the next
loop       ``Preview``: the window, and what its keys do with files and clock
========== ======================================================================
"""
