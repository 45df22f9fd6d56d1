// What both eyes see of a panel image, ray by ray: with diffraction, through real lenslets.
//
// Reads:  panel (the panel image, linear), the points of both eyes.
// Writes: seen (added to, from batch to batch of points; divided in the last one).
// Twin:   vrlf/reference/traced.py.
//
// Defines: ARRAY 0 none, 1 lenslets, 2 holes; SETS 1 (all colours share their points) or 3;
//          DIFFRACTION, EXACT 0 or 1; CURVED_FIRST (include/exact_lenslet.glsl);
//          PERIOD_X, PERIOD_Y (include/period.glsl); HEXAGONAL, VARYING 0.

#include "block/PerceiveTraced"
layout(local_size_x = GROUP_PX, local_size_y = GROUP_PX) in;

layout(binding = 0) uniform sampler2D panel;
layout(binding = 0, rgba32f) uniform image2D seen;

// phi, in cells, and psi, in pixels; then the slope before the array without the pixel's part,
// and M, both along the lattice's axes. See vrlf/optics/samples.py, vrlf/optics/beams.py.
layout(std430, binding = 0) readonly buffer Rays { vec4 rays[]; };
layout(std430, binding = 1) readonly buffer Within { vec2 within[]; };
layout(std430, binding = 2) readonly buffer Crossings { vec4 crossings[]; };
layout(std430, binding = 3) readonly buffer Owners { vec4 owners[]; };
layout(std430, binding = 4) readonly buffer Spread { float spread[]; };

#include "include/viewport.glsl"
#include "include/subpixels.glsl"
#include "include/panel_light.glsl"
#include "include/lattice.glsl"
#if DIFFRACTION
#include "include/diffraction.glsl"
#endif
#if EXACT
#include "include/exact_lenslet.glsl"
#endif

struct Retina {
    ivec2 pixel;
    int eye;
    vec4 crossed;  // where its chief ray crosses the array
    vec4 owner;    // the same for the barriers
    vec2 slope;    // the chief ray's before the array
};

// What one colour of a panel place sends, in pixels from the retinal pixel's centre.
float light_at(Retina at, vec2 place, int colour) {
    vec2 whole = floor(place + 0.5);
    ivec2 pixel = at.pixel + ivec2(whole);
    float emitted = emission_at(pixel, place + 0.5 - whole)[colour];
    return emitted == 0.0 ? 0.0 : emitted * texel(pixel, at.eye)[colour];
}

#if ARRAY != 0
// One colour of a ray through `cell`, `in_cell` from its centre, that would land at `straight`.
float through_opening(Retina at, int index, vec2 cell, vec2 in_cell, vec2 straight, int colour) {
    vec2 moved = vec2(0.0);  // on the panel, cells
#if EXACT
    bool passes;
    vec2 slope = at.slope + times(slope_per_px, within[index]) + rays[2 * index + 1].xy;
    vec2 place_mm = in_cell * pitch_mm;
    vec2 landed = exact_landing(place_mm, slope, colour, passes);
    if (!passes) return 0.0;
    moved = (landed - place_mm - reduced_gap_mm * slope) / pitch_mm;
#else
    moved = -bends[colour] * in_cell;
#endif
#if DIFFRACTION
    moved += diffracted(in_cell, rays[2 * index + 1].zw, colour);
#endif
    vec2 place = straight + times(px_per_cell, moved);
    if (barriers != 0) {
        vec2 strayed = nearest_cell(from_owner(at.owner, vec4(0.0), at.crossed, cell, place));
        if (strayed != vec2(0.0)) return 0.0;  // absorbed by a barrier
    }
    return light_at(at, place, colour);
}
#endif

// Colours from `first` to before `end` of one point.
vec3 traced(Retina at, int index, int first, int end) {
    vec3 light = vec3(0.0);
    vec2 place_px = within[index], straight = rays[2 * index].zw + place_px;
#if ARRAY == 0
    for (int c = first; c < end; c++) light[c] = light_at(at, straight, c);
#else
    vec2 q = at.crossed.xy + rays[2 * index].xy
           + array_from_panel * times(cells_per_px, place_px);
    vec2 cell = nearest_cell(q);
    if (ARRAY == 2 && !is_open(q - cell)) return light;  // blocked by the mask
    for (int c = first; c < end; c++) {
        light[c] = through_opening(at, index, cell, q - cell, straight, c);
    }
#endif
    return light;
}

void main() {
    ivec2 place = ivec2(gl_GlobalInvocationID.xy), pixel = place + ivec2(0, first_row);
    if (pixel.x >= panel_px.x || place.y >= rows || pixel.y >= panel_px.y) return;
    int eye = eye_of(pixel.x);
    if (eye == NO_EYE) {
        imageStore(seen, pixel, vec4(0.0, 0.0, 0.0, 1.0));
        return;
    }
    Retina at = Retina(pixel, eye, vec4(0.0), vec4(0.0), vec2(0.0));
#if ARRAY != 0
    at.crossed = crossings[pixel.x] + crossings[panel_px.x + pixel.y];
    if (barriers != 0) at.owner = owners[pixel.x] + owners[panel_px.x + pixel.y];
    vec2 from_axis = vec2(pixel - ivec2(first_column(eye), 0)) - (eye == 0 ? axes_px.xy : axes_px.zw);
    at.slope = times(slope_per_px, from_axis);
#endif
    vec3 light = is_first == 0 ? imageLoad(seen, pixel).rgb : vec3(0.0);
    for (int set = 0; set < SETS; set++) {
        int begin = (eye * SETS + set) * batch_points;
        for (int i = begin; i < begin + batch_points; i++) {
            light += traced(at, i, set, SETS == 1 ? 3 : set + 1);
        }
    }
    imageStore(seen, pixel, vec4(light * scale, 1.0));
}
