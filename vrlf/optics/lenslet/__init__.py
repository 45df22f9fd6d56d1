"""The lenslet's own optics: surfaces, first order, exact rays, foci, diffraction, achromats.

=========== ===================================================================
file        holds
=========== ===================================================================
surfaces    a lenslet as a row of surfaces, and what is between them
paraxial    matrix, focal length and principal planes of each colour
trace       exact rays, their paths, and where they are blocked
spots       spots on the panel, and the gap at which they are least
focus       sagittal and tangential foci over the field; focus of each colour
diffraction wavefront and modulation transfer function
given       the lenslet of a rig, and its focal length of each colour
achromat    doublets that bring two colours to one focus
table       the thesis's doublet beside right ones
setting     a lenslet before its panel
report      how well a lenslet focuses a rig's panel
=========== ===================================================================
"""
