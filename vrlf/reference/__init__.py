"""The float64 twin of each pass: slow, plain, and what the shaders are held against.

========== ======================================================================
file       twin of
========== ======================================================================
prepare    ``shaders/prepare.comp``: a picture fitted into its viewport
forward    ``shaders/forward.comp``: the forward prefilter
perceive   ``shaders/perceive.comp``: what both eyes see, plain pupil sampling
quadrature ``shaders/perceive.comp``: the same by lines and by points of holes
traced     ``shaders/perceive_traced.comp``: ray by ray, diffraction, real lenslets
optimal    ``vrlf/solve``: the optimal prefilter, each pixel's row traced by itself
converged  ``vrlf/solve``: the bounded optimum itself, by float64 matrices, proved
panorama   ``shaders/scene/panorama.comp``: the world all around from a picture
encode     ``shaders/encode.comp``: linear light to 8-bit sRGB
alignment  ``shaders/alignment.comp``: screens for aligning
show       ``shaders/show.comp``: what a rectangle of a window shows
squares    ``shaders/squares.comp``: sums of squares inside the borders
========== ======================================================================
"""
