// Rows of a tabulated operator: by phase, or one for each pixel.
//
// A phase is a place in a cell; a patch is the square between four sampled ones, and its row
// holds every offset that any of the four sees, with the weights of all four. They are read
// bilinearly. Where perpendicular walls stand, each pixel has a row of its own.
//
// Defines: PER_PIXEL 1 where each pixel has its row; CORNERS 4 where phases are read bilinearly,
//          1 where the nearest serves; COLOURS_APART 1 where colours differ in their weights.
//          An entry has 32 bytes (four corners, colours apart), 16 (four corners) or 12 (one).
// Needs: viewport.glsl, of the block: ivec2 phases (a side of a cell, for each eye).
// Packing and twin: vrlf/passes/phases.py, vrlf/passes/pixels.py.

#if CORNERS == 1
layout(std430, binding = 0) readonly buffer Entries { uint entries[]; };
#else
layout(std430, binding = 0) readonly buffer Entries { uvec4 entries[]; };
#endif
layout(std430, binding = 1) readonly buffer Starts { int starts[]; };
layout(std430, binding = 2) readonly buffer Crossings { vec4 crossings[]; };

struct Row {
    int index;     // in the table
    vec4 corners;  // how much each of the patch's corners counts: +x +0, by rows
};

struct Entry {
    ivec2 offset;  // to another pixel, right and down
    vec3 weight;   // of each colour
};

ivec2 offset_in(uint word) {
    return ivec2(bitfieldExtract(int(word), 0, 16), bitfieldExtract(int(word), 16, 16));
}

#if PER_PIXEL
Row row_of(ivec2 pixel, int eye) {
    int column = eye * view_px.x * view_px.y + pixel.x - first_column(eye);
    return Row(column + pixel.y * view_px.x, vec4(0.0));
}
#else
// Where the pixel's chief ray crosses the array decides.
Row row_of(ivec2 pixel, int eye) {
    vec2 crossed = crossings[pixel.x].xy + crossings[panel_px.x + pixel.y].xy;
    int side = phases[eye];
    int first = eye * phases.x * phases.x;
    vec2 at = fract(crossed + 0.5) * float(side);
#if CORNERS == 1
    ivec2 nearest = ivec2(at + 0.5) % side;
    return Row(first + nearest.y * side + nearest.x, vec4(0.0));
#else
    // fract() of a tiny negative number is 1.
    vec2 low = min(floor(at), float(side - 1));
    vec2 b = at - low, a = 1.0 - b;
    return Row(first + int(low.y) * side + int(low.x),
               vec4(a.x * a.y, b.x * a.y, a.x * b.y, b.x * b.y));
#endif
}
#endif

float mixed(vec4 corners, uint first, uint second) {
    return dot(corners, vec4(unpackHalf2x16(first), unpackHalf2x16(second)));
}

// The entry at a place of the table, its weights mixed for a phase of its patch.
Entry entry_at(int index, Row row) {
#if CORNERS == 1
    uint tail = entries[3 * index + 2];
    return Entry(offset_in(entries[3 * index]),
                 vec3(unpackHalf2x16(entries[3 * index + 1]), unpackHalf2x16(tail).x));
#elif COLOURS_APART
    uvec4 head = entries[2 * index], tail = entries[2 * index + 1];
    return Entry(offset_in(head.x), vec3(mixed(row.corners, head.y, head.z),
                                         mixed(row.corners, head.w, tail.x),
                                         mixed(row.corners, tail.y, tail.z)));
#else
    uvec4 all = entries[index];
    return Entry(offset_in(all.x), vec3(mixed(row.corners, all.y, all.z)));
#endif
}
