"""Numbers for what an eye perceives against what it should.

========== ============================================================
file       holds
========== ============================================================
shift      PSNR after the best shift of the whole picture
metrics/   every metric of two pictures, by name
report/    an evaluation as one HTML file, as JSON and CSV
measure    RMSE, PSNR and SSIM of an eye, inside the border, after one gain
live       RMSE and PSNR from the sums that a GPU makes each frame
fringes    colour that is seen where none was meant
hdrvdp     HDR-VDP-2.2: which differences are seen, and how they spoil
========== ============================================================
"""
