// Rows of a tabulated operator: the same for all pixels of a phase.
//
// Needs of the block: what viewport.glsl needs, int phases_a_side, int rows_an_eye; of the
// shader: the buffers below, and lattice.glsl's nearest_cell.
// Twin: vrlf/reference/optimal.py.

struct Entry {
    ivec2 offset;  // to another pixel, right and down
    vec3 weight;   // of each colour
};

// Offsets as two signed bytes and red's weight as a half float; green's and blue's.
Entry unpacked(uvec2 bits) {
    int offsets = int(bits.x);
    vec2 red = unpackHalf2x16(bits.x >> 16u);
    vec2 rest = unpackHalf2x16(bits.y);
    return Entry(ivec2(bitfieldExtract(offsets, 0, 8), bitfieldExtract(offsets, 8, 8)),
                 vec3(red.x, rest.x, rest.y));
}

// The row of the pixel whose chief ray crosses at these cell coordinates.
int row_of(vec2 crossed, int eye) {
    vec2 in_cell = crossed - nearest_cell(crossed) + 0.5;
    ivec2 phase = clamp(ivec2(floor(in_cell * float(phases_a_side))), ivec2(0), ivec2(phases_a_side - 1));
    return eye * rows_an_eye + phase.y * phases_a_side + phase.x;
}
