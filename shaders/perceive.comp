// What both eyes see of a panel image.
//
// Reads:  panel (the panel image, linear), the ray tables of both eyes.
// Writes: seen (added to, from batch to batch of rays; divided in the last one).
// Twins:  vrlf/reference/perceive.py, vrlf/reference/quadrature.py (see include/rays.glsl).
//
// Defines: ARRAY 0 none, 1 lenslets, 2 holes; COLOURS 1 (all colours share their rays) or 3;
//          BY_HOLE 1 where holes have their own points; PERIOD_X, PERIOD_Y (include/period.glsl);
//          LATERAL 1 where the colours are magnified differently;
//          TRACE 1 writes where the first ray of the batch lands instead (for the tests).

#include "block/Perceive"
layout(local_size_x = GROUP_PX, local_size_y = GROUP_PX) in;

layout(binding = 0) uniform sampler2D panel;
layout(binding = 0, rgba32f) uniform image2D seen;

// Points: phi, in cells, and psi, in pixels; their places in the retinal pixel. What else these
// may hold is said in include/lines.glsl and include/holes.glsl.
layout(std430, binding = 0) readonly buffer Rays { vec4 rays[]; };
layout(std430, binding = 1) readonly buffer Within { vec2 within[]; };
// Cell coordinates of the pixels' chief rays at the array, and as the barriers divide them.
layout(std430, binding = 2) readonly buffer Crossings { vec4 crossings[]; };
layout(std430, binding = 3) readonly buffer Owners { vec4 owners[]; };
// Where each bin's rays begin; holes only.
layout(std430, binding = 4) readonly buffer Bins { int bin_starts[]; };

#include "include/viewport.glsl"
#include "include/subpixels.glsl"
#include "include/panel_light.glsl"
#include "include/lattice.glsl"
#include "include/rays.glsl"

vec3 shown(Retina at, vec2 offset, vec3 weight) {
    return weight * texel(at.pixel + ivec2(offset), at.eye);
}

// The panel column of the patch's column: the left eye's, the right eye's, what is nobody's.
int patch_column(int column) {
    int in_view = (view_px.x - patch_first.x + patch_stride - 1) / patch_stride;
    if (column >= 2 * in_view) return view_px.x + column - 2 * in_view < second_column
        ? view_px.x + column - 2 * in_view : panel_px.x;
    int eye = column / in_view;
    return first_column(eye) + patch_first.x + patch_stride * (column - eye * in_view);
}

#if TRACE
// The batch's first ray, from the pixel's centre: its place in the cell (in the pupil where
// holes have points; there the ray is that of the hole nearest the pupil's centre), and its
// landing in pixels.
vec4 landing_of(Retina at) {
    int set = at.eye * COLOURS;
    int index = set * points + batch_first;
#if ARRAY == 0
    return vec4(0.0, 0.0, landed(at, rays[index].zw));
#elif ARRAY == 1
    vec2 q = at.crossed.xy + in_cells(rays[2 * index].xy, at.law);
    vec2 cell = nearest_cell(q);
    vec2 bent = BEND_OF(index) * times(px_per_cell, evenly(cell - at.crossed.xy, at.law));
    return vec4(q - cell, landed(at, rays[2 * index + 1].xy + bent));
#elif BY_HOLE
    vec2 centre = at.crossed.xy + in_cells(hole_seen[set].xy, at.law);
    vec2 off = -from_middle(centre, nearest_cell(centre), hole_seen[set].xy, at.crossed, at.law);
    return vec4(times(hole_maps[3 * set], off) + rays[index].xy,
                landed(at, hole_maps[3 * set + 2].xy + times(hole_maps[3 * set + 1], off)
                           + rays[index].zw));
#else
    vec2 q = at.crossed.xy + in_cells(rays[index].xy, at.law);
    return vec4(q - nearest_cell(q), landed(at, rays[index].zw));
#endif
}
#endif

void main() {
    ivec2 place = ivec2(gl_GlobalInvocationID.xy);
    ivec2 pixel = ivec2(patch_column(place.x), patch_first.y + patch_stride * place.y);
    if (pixel.x >= panel_px.x || place.y >= rows || pixel.y >= panel_px.y) return;
    int eye = eye_of(pixel.x);
    if (eye == NO_EYE) {
        imageStore(seen, pixel, vec4(0.0, 0.0, 0.0, 1.0));
        return;
    }
    Retina at = retina_of(pixel, eye, 0);
#if TRACE
    imageStore(seen, pixel, landing_of(at));
#else
    vec3 light;
#if COLOURS == 1
    light = gathered(at, eye);
#else
    for (int c = 0; c < 3; c++) {
#if LATERAL
        at = retina_of(pixel, eye, c);
#endif
        light[c] = gathered(at, eye * 3 + c)[c];
    }
#endif
    if (is_first == 0) light += imageLoad(seen, pixel).rgb;
    imageStore(seen, pixel, vec4(light * scale, 1.0));
#endif
}
