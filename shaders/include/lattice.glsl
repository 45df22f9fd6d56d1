// The array's lattice: cells, openings, and the panel area that barriers leave to a cell.
//
// Defines: HEXAGONAL 1 where the second cell coordinate runs 60 degrees to the first;
// VARYING 1 where the pitch varies: then *even* places, in pitches of the lattice's middle, in
// which rays are straight, differ from cells. From a pixel's crossing on, a law says how: a and b
// of both axes, with growth.
//
// Cell coordinates are kept as a rest of at most a cell (in .xy) and a whole number (in .zw),
// one part for the column and one for the row: 32-bit floats then lose nothing.
//
// Needs of the block: vec2 growth, vec2 hole_reach, float half_aperture, int round_holes,
// int barriers, vec4 cells_per_px, vec4 px_per_cell (2x2 matrices, rows one after the other),
// float barrier_scale.
// Twin: vrlf/optics/lattice.py, vrlf/optics/raster.py.

vec2 times(vec4 rows, vec2 v) {
    return vec2(dot(rows.xy, v), dot(rows.zw, v));
}

#if HEXAGONAL
// How far along the first and the second neighbour's direction, in pitches.
vec2 toward_neighbours(vec2 v) {
    return v + 0.5 * v.yx;
}

// The nearest whole numbers or the neighbour across the coordinate that is farther off.
vec2 nearest_cell(vec2 q) {
    vec2 square = floor(q + 0.5), p = q - square;
    vec2 axis = abs(p.x) >= abs(p.y) ? vec2(1.0, 0.0) : vec2(0.0, 1.0);
    return square + axis * floor(dot(axis, toward_neighbours(p)) + 0.5);
}

vec2 upright(vec2 in_cell) {
    return vec2(in_cell.x + 0.5 * in_cell.y, 0.866025404 * in_cell.y);
}
#else
// A point on a border belongs to the cell above it; round() may do either.
vec2 nearest_cell(vec2 q) {
    return floor(q + 0.5);
}

vec2 upright(vec2 in_cell) {
    return in_cell;
}
#endif

#if VARYING
// The even place of what lies d cells beyond the crossing.
vec2 evenly(vec2 d, vec4 law) {
    return d * (law.xy + d * (law.zw + d * growth));
}

// The reverse, by Newton's steps.
vec2 in_cells(vec2 even, vec4 law) {
    vec2 d = even / law.xy;
    for (int i = 0; i < 4; i++) {
        vec2 slope = law.xy + d * (2.0 * law.zw + 3.0 * d * growth);
        d -= (evenly(d, law) - even) / max(slope, vec2(0.1));
    }
    return d;
}
#else
vec2 evenly(vec2 d, vec4 law) {
    return d;
}

vec2 in_cells(vec2 even, vec4 law) {
    return even;
}
#endif

// Where, from the middle of `cell`, a ray crosses that is q in cells and `even` from the crossing.
vec2 from_middle(vec2 q, vec2 cell, vec2 even, vec4 crossed, vec4 law) {
#if VARYING
    return even - evenly(cell - crossed.xy, law);
#else
    return q - cell;
#endif
}

// Whether light passes there.
bool is_open(vec2 in_cell) {
    in_cell = upright(in_cell);
    if (round_holes != 0) return dot(in_cell, in_cell) <= half_aperture * half_aperture;
    return max(abs(in_cell.x), abs(in_cell.y)) <= half_aperture;
}

// Place of a panel point in the area that its barriers divide off, relative to the cell that
// was passed: nearest_cell is 0 if the point belongs to that cell.
//   owner    cell coordinates of the pixel's own centre, by the barriers' scale; law: from there on
//   crossed  cell coordinates of the pixel's crossing of the array
//   cell     the cell passed, counted from crossed.zw
//   place    the panel point, in pixels from the pixel's centre
vec2 from_owner(vec4 owner, vec4 law, vec4 crossed, vec2 cell, vec2 place) {
    vec2 moved = in_cells(barrier_scale * times(cells_per_px, place), law);
    return owner.xy + moved + (owner.zw - crossed.zw) - cell;
}
