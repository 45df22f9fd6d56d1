// The perception operator, tabulated: which panel pixels a retinal pixel sees, and how much.
//
// That depends on nothing but where in its cell the pixel's chief ray crosses the array, and on
// its place in the layout's period. One invocation takes one such place in a cell (a phase), or
// one pixel, and deposits its rays' weights in
// a window of panel offsets, which is its own: no atomics.
//
// Reads:  the ray tables. Writes: windows[row][line][column][colour], added to.
// Twin:   vrlf/reference/optimal.py, which tabulates every pixel by itself.
//
// Defines: as in perceive.comp.

#include "block/Rows"
layout(local_size_x = 64) in;

layout(std430, binding = 0) readonly buffer Rays { vec4 rays[]; };
layout(std430, binding = 1) readonly buffer Within { vec2 within[]; };
layout(std430, binding = 2) readonly buffer Crossings { vec4 crossings[]; };
layout(std430, binding = 3) readonly buffer Owners { vec4 owners[]; };
layout(std430, binding = 4) readonly buffer Bins { int bin_starts[]; };
layout(std430, binding = 5) buffer Windows { float windows[]; };

#include "include/viewport.glsl"
#include "include/subpixels.glsl"
#include "include/lattice.glsl"
#include "include/rays.glsl"

int window_start;
vec3 channel;  // the colours that the rays at hand stand for

void deposit(vec2 offset, vec3 weight) {
    ivec2 at = ivec2(offset) - window_low;
    if (any(lessThan(at, ivec2(0))) || any(greaterThanEqual(at, window_px))) return;
    int first = window_start + 3 * (at.y * window_px.x + at.x);
    for (int c = 0; c < 3; c++) windows[first + c] += weight[c] * channel[c];
}

vec3 shown(Retina at, vec2 offset, vec3 weight) {
    deposit(offset, weight);
    return vec3(0.0);
}

// Where perpendicular walls divide the panel by another measure than the chief rays, where the
// colours are magnified differently and where the pitch varies, a row is a pixel's own
// (phases_a_side is 0).
Retina of_pixel(int row, int colour) {
    ivec2 pixel = ivec2(first_column(eye) + row % view_px.x, row / view_px.x);
    return retina_of(pixel, eye, colour);
}

// The barriers of a phase are those of a cell: converging walls divide the panel as the
// chief rays do.
Retina of_phase(int row) {
    int phase = row;
    ivec2 pixel = ivec2(0);
#if PERIOD_X * PERIOD_Y > 1
    int of_place = phases_a_side * phases_a_side;
    phase = row % of_place;
    pixel = ivec2(row / of_place % PERIOD_X, row / of_place / PERIOD_X);
#endif
    vec2 place = vec2(phase % phases_a_side, phase / phases_a_side) / float(phases_a_side) - 0.5;
    place -= moved_cells;
    place -= floor(place + 0.5);
    Retina at;
    at.pixel = pixel;
    at.eye = eye;
    at.crossed = at.owner = vec4(place, 0.0, 0.0);
    at.law = at.owner_law = vec4(1.0, 1.0, 0.0, 0.0);
#if LATERAL
    at.lateral = vec2(0.0);
    at.side = 1.0;
#endif
    return at;
}

Retina of_row(int row, int colour) {
    if (phases_a_side == 0) return of_pixel(row, colour);
    return of_phase(row);
}

void main() {
    int index = int(gl_GlobalInvocationID.x);
    if (index >= row_count) return;
    Retina at = of_row(first_row + index, 0);
    window_start = index * window_px.x * window_px.y * 3;
#if COLOURS == 1
    channel = vec3(1.0);
    gathered(at, eye);
#else
    for (int c = 0; c < 3; c++) {
        channel = vec3(c == 0, c == 1, c == 2);
#if LATERAL
        at = of_row(first_row + index, c);
#endif
        gathered(at, eye * 3 + c);
    }
#endif
}
