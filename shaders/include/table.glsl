// Rows of a tabulated operator: by phase, or one for each pixel.
//
// A phase is a place in a cell; the nearest of those that were sampled is read. Each place of a
// layout's period has phases of its own. Behind perpendicular walls, a pitch that varies and a lens
// with lateral colour each pixel has a row of its own. An entry is an offset to another pixel, right
// and down, and how much of it is seen in each colour; entries are read in pairs.
//
// Defines: SIGNED 1 where entries have signs, 2 for their sizes; PER_PIXEL 1 where each pixel has its row; PERIOD_X, PERIOD_Y (include/period.glsl).
// Needs: viewport.glsl, of the block: ivec2 phases (a side of a cell, for each eye).
// Packing: packed() of vrlf/passes/phases.py.

#include "include/period.glsl"

layout(std430, binding = 0) readonly buffer Entries { uvec4 entries[]; };  // in pairs
layout(std430, binding = 1) readonly buffer Starts { int starts[]; };
layout(std430, binding = 2) readonly buffer Crossings { vec4 crossings[]; };

#if PER_PIXEL
int row_of(ivec2 pixel, int eye) {
    int column = eye * view_px.x * view_px.y + pixel.x - first_column(eye);
    return column + pixel.y * view_px.x;
}
#else
// Where the pixel's chief ray crosses the array decides.
int row_of(ivec2 pixel, int eye) {
    vec2 crossed = crossings[pixel.x].xy + crossings[panel_px.x + pixel.y].xy;
    int side = phases[eye];
    ivec2 nearest = ivec2(fract(crossed + 0.5) * float(side) + 0.5) % side;
    int before = eye * PERIOD_X * PERIOD_Y * phases.x * phases.x + place_of(pixel) * side * side;
    return before + nearest.y * side + nearest.x;
}
#endif

// Where a table has signs (SIGNED) the offset to the right has one bit less: see signed().
ivec2 offset_in(uint word) {
#if SIGNED
    return ivec2(bitfieldExtract(int(word), 0, 15), bitfieldExtract(int(word), 16, 16));
#else
    return ivec2(bitfieldExtract(int(word), 0, 16), bitfieldExtract(int(word), 16, 16));
#endif
}

// SIGNED 2 takes all entries for their size.
float sign_in(uint word) {
#if SIGNED == 1
    return (word & 0x8000u) == 0u ? 1.0 : -1.0;
#else
    return 1.0;
#endif
}

// EXT_texture_shared_exponent: RGB9E5.
vec3 weight_in(uint word) {
    vec3 mantissa = vec3(word & 0x1ffu, (word >> 9) & 0x1ffu, (word >> 18) & 0x1ffu);
    return mantissa * uintBitsToFloat(((word >> 27) + (127u - 24u)) << 23);
}
