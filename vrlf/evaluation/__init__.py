"""Numbers for what an eye perceives against what it should.

========== ==========================================================
file       holds
========== ==========================================================
measure    RMSE and PSNR inside the border, after one gain
========== ==========================================================
"""
