// The perception operator, tabulated: which panel pixels a retinal pixel sees, and how much.
//
// That depends on nothing but where in its cell the pixel's chief ray crosses the array. One
// invocation takes one such place (a phase) and deposits its rays' weights in a window of
// panel offsets, which is its own: no atomics.
//
// Reads:  the ray tables. Writes: windows[phase][row][column][colour], added to.
// Twin:   vrlf/reference/optimal.py, which tabulates every pixel by itself.
//
// Defines: as in perceive.comp.

#include "block/Rows"
layout(local_size_x = 64) in;

layout(std430, binding = 0) readonly buffer Rays { vec4 rays[]; };
layout(std430, binding = 1) readonly buffer Within { vec2 within[]; };
layout(std430, binding = 4) readonly buffer Bins { int bin_starts[]; };
layout(std430, binding = 5) buffer Windows { float windows[]; };

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

vec3 at_landing(Retina at, vec2 place) {
    vec2 whole = floor(place + 0.5);
    deposit(whole, emission_at(place + 0.5 - whole));
    return vec3(0.0);
}

vec3 over_landing(Retina at, vec2 place, float side) {
    vec2 low = place + 0.5 - 0.5 * side;
    vec2 first = floor(low);
    for (int row = 0; row < FOOTPRINT_PX; row++) {
        for (int column = 0; column < FOOTPRINT_PX; column++) {
            vec2 pixel = first + vec2(column, row);
            deposit(pixel, emission_over(low - pixel, side));
        }
    }
    return vec3(0.0);
}

void main() {
    int index = int(gl_GlobalInvocationID.x);
    if (index >= phase_count) return;
    int phase = first_phase + index;
    vec2 place = vec2(phase % phases_a_side, phase / phases_a_side) / float(phases_a_side) - 0.5;
    window_start = index * window_px.x * window_px.y * 3;
    // The barriers of a phase are those of a cell: converging walls divide the panel as the
    // chief rays do.
    Retina at = Retina(ivec2(0), eye, vec4(place, 0.0, 0.0), vec4(place, 0.0, 0.0));
#if COLOURS == 1
    channel = vec3(1.0);
    gathered(at, eye);
#else
    for (int c = 0; c < 3; c++) {
        channel = vec3(c == 0, c == 1, c == 2);
        gathered(at, eye * 3 + c);
    }
#endif
}
