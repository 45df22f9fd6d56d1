"""Targets that come from files or the CPU.

========== ====================================================
file       holds
========== ====================================================
pictures   stereo pictures of the user's own
panorama   the world all around, from a picture
charts/    charts drawn at the panel's exact pixels
========== ====================================================
"""
