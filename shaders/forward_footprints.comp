// The forward prefilter by footprints: a sub-pixel whose samples all take one lenslet and land in
// the viewport sees them through one map, so its mean of bilinear reads is one weighted sum over a
// small window of texels: each is fetched once, not once for every sample it serves. Without a
// wavefront the map is affine; with one its polynomial is shared by rows of samples.
//
// Reads:  target (what the eyes should perceive, linear), the inverse maps of both eyes; with
//         LISTED the pixels to do.
// Writes: shown (the panel image, linear). Pixels with a sub-pixel that is cut, by the border of a
//         cell, of the pupil or of the viewport, get nonsense: forward.comp does them again, or
//         they aren't listed.
// Twin:   vrlf/reference/forward.py. Derivation: vrlf/optics/footprint.py.
//
// Defines: as in forward.comp; WINDOW_X and WINDOW_Y, the texels that hold every footprint, even
//          numbers; ALIGNED 1 where sample rows and columns stay such in the target (DEGREE is 1
//          then).
// A layer of groups is an eye.

#include "block/Forward"
layout(local_size_x = GROUP_PX, local_size_y = GROUP_PX) in;

layout(binding = 0) uniform sampler2D target;
layout(std430, binding = 2) readonly buffer Crossings { vec4 crossings[]; };
layout(std430, binding = 3) readonly buffer Owners { vec4 owners[]; };
layout(binding = 0, rgba32f) writeonly uniform image2D shown;

#include "include/viewport.glsl"
#include "include/lattice.glsl"
#include "include/forward_rays.glsl"
#include "include/each_sample.glsl"
#include "include/four_texels.glsl"
#include "include/forward_main.glsl"

const float MIDDLE = 0.5 * float(GRID - 1);

struct Footprint {
    vec2 pixel;                            // the window's upper left texel
    float weights[WINDOW_X * WINDOW_Y];
    bool reads;
};

// What linear interpolation gives the texel at 0 of a sample at x.
float hat(float x) {
    return max(1.0 - abs(x), 0.0);
}

#if ALIGNED
// The sum over a row, or a column, of samples.
float hats(float first, float step, float texel) {
    float sum = 0.0;
    for (int k = 0; k < GRID; k++) sum += hat(first + float(k) * step - texel);
    return sum;
}
#else
void add_sample(inout Footprint to, vec2 at) {
    float across[WINDOW_X];
    for (int x = 0; x < WINDOW_X; x++) across[x] = hat(at.x - float(x));
    for (int y = 0; y < WINDOW_Y; y++) {
        float down = hat(at.y - float(y));
        for (int x = 0; x < WINDOW_X; x++) to.weights[y * WINDOW_X + x] += down * across[x];
    }
}
#endif

// The window moves in at a border: what it loses weighs nothing, and the other eye's texels don't
// even count as nothing.
vec2 held_within(vec2 low, Pixel from) {
    vec2 border = vec2(first_column(from.eye), 0) - vec2(from.at);
    return max(min(low, border + vec2(view_px - ivec2(WINDOW_X, WINDOW_Y))), border);
}

#if DEGREE == 1
Footprint footprint_of(Pixel pixel, int colour) {
    Pixel from = in_colour(pixel, colour);
    // In the target, along a row (xy) and down a column (zw).
    vec4 steps = target_steps[place_of(from.at) * 2 * RAY_SETS + ray_set(from.eye, colour)];
    Ray middle = ray_at(from, sample_place(from, colour, vec2(MIDDLE)), colour);
    vec2 low = floor(middle.landing - MIDDLE * (abs(steps.xy) + abs(steps.zw)));
    low = held_within(low, from);
    vec2 first = middle.landing - MIDDLE * (steps.xy + steps.zw) - low;
    Footprint made;
    made.pixel = vec2(from.at) + low;
    made.reads = reads(from, middle);
#if ALIGNED
    float across[WINDOW_X];
    for (int x = 0; x < WINDOW_X; x++) across[x] = hats(first.x, steps.x, float(x));
    for (int y = 0; y < WINDOW_Y; y++) {
        float down = hats(first.y, steps.w, float(y));
        for (int x = 0; x < WINDOW_X; x++) made.weights[y * WINDOW_X + x] = down * across[x];
    }
#else
    for (int i = 0; i < WINDOW_X * WINDOW_Y; i++) made.weights[i] = 0.0;
#define ADD(column, row) add_sample(made, first + float(column) * steps.xy + float(row) * steps.zw);
    EACH_SAMPLE(ADD)
#undef ADD
#endif
    return made;
}
#else
// Where a row of samples lands: y is the same for all, so the powers' coefficients are.
void land_row(inout vec2 landings[GRID * GRID], Ray middle, Pixel from, int colour, int row) {
    vec2 step = samples[box_of(from.at, colour)].zw, seen_step = magnification(from) * step;
    float down = float(row) - MIDDLE;
    float y = middle.through.y + down * step.y;
    vec2 powers[DEGREE + 1] = curves(y, from.eye, colour);
    for (int column = 0; column < GRID; column++) {
        vec2 off = vec2(float(column) - MIDDLE, down);
        float x = middle.through.x + off.x * step.x;
        vec2 moved = straight(vec2(x, y), from.eye, colour) + curved(powers, x);
        landings[row * GRID + column] = middle.seen + off * seen_step + moved;
    }
}

Footprint footprint_of(Pixel pixel, int colour) {
    Pixel from = in_colour(pixel, colour);
    Ray middle = ray_at(from, sample_place(from, colour, vec2(MIDDLE)), colour);
    vec2 landings[GRID * GRID];
#define LAND(row) land_row(landings, middle, from, colour, row);
    EACH_ROW(LAND)
#undef LAND
    vec2 low = landings[0];
#define LOWER(column, row) low = min(low, landings[(row) * GRID + (column)]);
    EACH_SAMPLE(LOWER)
#undef LOWER
    low = held_within(floor(low), from);
    Footprint made;
    made.pixel = vec2(from.at) + low;
    made.reads = middle.met;
    for (int i = 0; i < WINDOW_X * WINDOW_Y; i++) made.weights[i] = 0.0;
#define ADD(column, row) add_sample(made, landings[(row) * GRID + (column)] - low);
    EACH_SAMPLE(ADD)
#undef ADD
    return made;
}
#endif

float light_of(Footprint read, int colour) {
    float sum = 0.0;
    for (int y = 0; y < WINDOW_Y; y += 2) {
        for (int x = 0; x < WINDOW_X; x += 2) {
            int i = y * WINDOW_X + x;
            vec4 weights = vec4(read.weights[i + WINDOW_X], read.weights[i + WINDOW_X + 1],
                                read.weights[i + 1], read.weights[i]);
            sum += dot(weights, four_texels(read.pixel + vec2(x, y), colour));
        }
    }
    return read.reads ? sum / float(GRID * GRID) : 0.0;
}

vec3 light_at(Pixel from) {
#if RAY_SETS == 1
    Footprint shared_by_all = footprint_of(from, 0);
    return vec3(light_of(shared_by_all, 0), light_of(shared_by_all, 1), light_of(shared_by_all, 2));
#else
    return vec3(light_of(footprint_of(from, 0), 0),
                light_of(footprint_of(from, 1), 1),
                light_of(footprint_of(from, 2), 2));
#endif
}
