// Rows of a tabulated operator, bilinear between four sampled phases.
//
// A phase is a place in a cell; a patch is the square between four sampled ones, and its row
// holds every offset that any of the four sees, with the weights of all four.
//
// Needs of the block: ivec2 phases (a side of a cell, for each eye); of the shader: the buffer
// entries.
// Packing and twin: vrlf/passes/phases.py.

struct Phase {
    int patch_row;  // in the table
    vec4 corners;   // how much each of the patch's corners counts: +x +0, by rows
};

struct Entry {
    ivec2 offset;  // to another pixel, right and down
    vec3 weight;   // of each colour
};

// Where the pixel whose chief ray crosses at these cell coordinates finds its row.
Phase phase_of(vec2 crossed, int eye) {
    int side = phases[eye];
    vec2 at = fract(crossed + 0.5) * float(side);
    // fract() of a tiny negative number is 1.
    vec2 low = min(floor(at), float(side - 1));
    vec2 b = at - low, a = 1.0 - b;
    int row = int(low.y) * side + int(low.x);
    return Phase(eye * phases.x * phases.x + row, vec4(a.x * a.y, b.x * a.y, a.x * b.y, b.x * b.y));
}

float mixed(vec4 corners, uint first, uint second) {
    return dot(corners, vec4(unpackHalf2x16(first), unpackHalf2x16(second)));
}

// The entry at a place of the table, its weights mixed for a phase of its patch.
Entry entry_at(int index, vec4 corners) {
    uvec4 head = entries[2 * index], tail = entries[2 * index + 1];
    int offset = int(head.x);
    return Entry(ivec2(bitfieldExtract(offset, 0, 16), bitfieldExtract(offset, 16, 16)),
                 vec3(mixed(corners, head.y, head.z),
                      mixed(corners, head.w, tail.x),
                      mixed(corners, tail.y, tail.z)));
}
