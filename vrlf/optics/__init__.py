"""What follows from a rig, in float64 numpy: functions on plain arrays, no GPU.

============ ====================================================================
file         holds
============ ====================================================================
frames       the one place where the examiner's view becomes the wearer's
polynomial   polynomials of the two pupil coordinates
wavefront    Zernike terms as polynomials, over any pupil, as power vectors
refraction   prescriptions, power vectors, matrices, transverse aberration
pupil_light  how wide a pupil is in its light, how much its parts count
eye          an eye's wavefront, accommodated, for each colour of the panel; cameras
pupil        the wavefront with which a point of the panel is seen, its RMS and its rays
psf          point spread functions by rays and by diffraction, modulation transfer
glass        refractive indices of lens materials
lenslet/     a lenslet's own surfaces: foci, rays, spots, diffraction, achromats
bench        distances and powers of the headset
distortion   the headset lens's radial distortion, and the way back
viewport     which columns an eye sees, where its axis meets the panel
subpixels    where in a pixel each colour emits
lattice      the array's cells, openings and barriers
raster       the lattice on the panel's raster, split for 32-bit floats
sequence     well-spread points
samples      perception's rays, reduced to what no pixel changes
quadrature   perception's rays without waste: which kind serves a rig, and what was measured
maps         where a pupil point's rays cross the array and meet the panel
lines        lines through pupil and retinal pixel, for lenslets
holes        points of a mask's holes
beams        a retinal point's beam where it meets the array
fresnel      how openings spread light by diffraction, as a map of rays
exact_lenslet a lenslet as it is made, refracted exactly
tracing      options of perception ray by ray, and their checks
inverse      the forward prefilter's map, reduced to a place in a cell
footprint    what a sub-pixel's samples cover in the forward prefilter's target
alignment    screens for aligning array, panel and lenses: their principle and sizes
tile         which part of a picture a rectangle of a window shows
openings     how sharp single openings are, with all orders of the eye in
tolerance    the cases that a tolerant panel image serves
limits       what an array can and cannot do
lateral      how far the headset's lens takes the colours apart
gaze         how far the eye may turn before the correction fails
relief       what taking the eye to be at the lens costs
inspect      all numbers and warnings that follow from a rig
============ ====================================================================
"""
