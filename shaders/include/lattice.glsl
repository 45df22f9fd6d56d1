// The array's lattice: cells, openings, and the panel area that barriers leave to a cell.
//
// Cell coordinates are kept as a rest of at most a cell (in .xy) and a whole number (in .zw),
// one part for the column and one for the row: 32-bit floats then lose nothing.
//
// Needs of the block: float half_aperture, int round_holes, int barriers, vec4 cells_per_px,
// vec4 px_per_cell (2x2 matrices, rows one after the other), float barrier_scale.
// Twin: vrlf/optics/lattice.py, vrlf/optics/raster.py.

vec2 times(vec4 rows, vec2 v) {
    return vec2(dot(rows.xy, v), dot(rows.zw, v));
}

// A point on a border belongs to the cell above it; round() may do either.
vec2 nearest_cell(vec2 q) {
    return floor(q + 0.5);
}

bool is_open(vec2 in_cell) {
    if (round_holes != 0) return dot(in_cell, in_cell) <= half_aperture * half_aperture;
    return max(abs(in_cell.x), abs(in_cell.y)) <= half_aperture;
}

// Place of a panel point in the area that its barriers divide off, relative to the cell that
// was passed: within half a cell of 0 if the point belongs to that cell.
//   owner    cell coordinates of the pixel's own centre, by the barriers' scale
//   crossed  cell coordinates of the pixel's crossing of the array
//   cell     the cell passed, counted from crossed.zw
//   place    the panel point, in pixels from the pixel's centre
vec2 from_owner(vec4 owner, vec4 crossed, vec2 cell, vec2 place) {
    return owner.xy + barrier_scale * times(cells_per_px, place) + (owner.zw - crossed.zw) - cell;
}
