"""Targets that come from files or the CPU.

========== ====================================================
file       holds
========== ====================================================
pictures   stereo pictures of the user's own
charts/    charts drawn at the panel's exact pixels
========== ====================================================
"""
