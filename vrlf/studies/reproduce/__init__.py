"""The thesis's results from content of our own, each beside what the thesis says of it.

============== =================================================================
file           holds
============== =================================================================
item           ``Item``, ``Number``, ``Picture``; ``Workbench``, which owns the renderer
run            the list of items, making them one after another, the short table
page           the HTML report
drawing        plots and sheets of pictures, in memory
samplings      one, nine and more samples of a pixel, and ``optimal``
accommodation  Fig. 3.2 and the clear zones of 3.3
zernike        Fig. 3.4
aberrations    Fig. 3.6
array_limits   4.3, with gratings about the Nyquist limit
fringes        5.3
sharpening     Fig. 6.2
pinhole        7.1
table_8_1      Table 8.1
stereo         Fig. 8.4 and 8.5
rays           9.1
methods        forward and optimal, holes and lenslets, the brightness each leaves
============== =================================================================
"""
