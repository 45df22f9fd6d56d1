"""Numbers for what an eye perceives against what it should.

========== ==========================================================
file       holds
========== ==========================================================
measure    RMSE, PSNR and SSIM inside the border, after one gain
fringes    colour that is seen where none was meant
========== ==========================================================
"""
