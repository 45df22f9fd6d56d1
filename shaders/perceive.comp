// What both eyes see of a panel image.
//
// Reads:  panel (the panel image, linear), the ray tables of both eyes.
// Writes: seen (added to, from batch to batch of rays; divided in the last one).
// Twin:   vrlf/reference/perceive.py. Derivation: vrlf/optics/samples.py.
//
// Defines: ARRAY 0 none, 1 lenslets, 2 holes; COLOURS 1 (all colours share their rays) or 3;
//          AREA_MEANS 1 where a retinal pixel's image at one pupil point is averaged exactly,
//          over FOOTPRINT_PX pixels a side;
//          TRACE 1 writes where the first ray of the batch lands instead (for the tests).

#include "block/Perceive"
layout(local_size_x = GROUP_PX, local_size_y = GROUP_PX) in;

layout(binding = 0) uniform sampler2D panel;
layout(binding = 0, rgba32f) uniform image2D seen;

// phi, in cells, and psi, in pixels, of each ray; then its place in the retinal pixel.
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

vec3 at_landing(Retina at, vec2 place) {
    return radiance_at(at.pixel, place, at.eye);
}

vec3 over_landing(Retina at, vec2 place, float side) {
    return mean_radiance(at.pixel, place, side, at.eye);
}

#if TRACE
// Place in the cell and landing, in pixels from the pixel's centre, of the batch's first ray.
vec4 landing_of(Retina at) {
    vec4 ray = rays[at.eye * COLOURS * points + batch_first];
#if ARRAY == 0
    return vec4(0.0, 0.0, ray.zw);
#else
    vec2 q = at.crossed.xy + ray.xy;
    vec2 in_cell = q - nearest_cell(q);
    return vec4(in_cell, bent(ray.zw, in_cell));
#endif
}
#endif

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy) + ivec2(0, first_row);
    if (pixel.x >= panel_px.x || pixel.y >= min(first_row + rows, panel_px.y)) return;
    int eye = eye_of(pixel.x);
    if (eye == NO_EYE) {
        imageStore(seen, pixel, vec4(0.0, 0.0, 0.0, 1.0));
        return;
    }
    Retina at = Retina(pixel, eye, vec4(0.0), vec4(0.0));
#if ARRAY != 0
    at.crossed = crossings[pixel.x] + crossings[panel_px.x + pixel.y];
    if (barriers != 0) at.owner = owners[pixel.x] + owners[panel_px.x + pixel.y];
#endif
#if TRACE
    imageStore(seen, pixel, landing_of(at));
#else
    vec3 light;
#if COLOURS == 1
    light = gathered(at, eye);
#else
    for (int c = 0; c < 3; c++) light[c] = gathered(at, eye * 3 + c)[c];
#endif
    if (is_first == 0) light += imageLoad(seen, pixel).rgb;
    imageStore(seen, pixel, vec4(light * scale, 1.0));
#endif
}
