"""Targets that come from files or the CPU.

========== ====================================================
file       holds
========== ====================================================
pictures   stereo pictures of the user's own
panorama   the world all around, from a picture
video      films in, and lossless films out; the only PyAV
charts/    charts drawn at the panel's exact pixels
========== ====================================================
"""
