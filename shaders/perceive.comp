// What both eyes see of a panel image.
//
// Reads:  panel (the panel image, linear), the ray tables of both eyes.
// Writes: seen (added to, from batch to batch of rays; divided in the last one).
// Twin:   vrlf/reference/perceive.py. Derivation: vrlf/optics/samples.py.
//
// Defines: ARRAY 0 none, 1 lenslets, 2 holes; COLOURS 1 (all colours share their rays) or 3;
//          AREA_MEANS 1 where a retinal pixel's image at one pupil point is averaged exactly;
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
#include "include/lattice.glsl"

struct Retina {
    ivec2 pixel;   // the retinal pixel, named by its panel point
    int eye;
    vec4 crossed;  // where its chief ray crosses the array
    vec4 owner;    // the same for the barriers
};

// A lenslet, or hole, centred in a cell moves what it passes by -(g / f) (y - c).
vec2 bent(vec2 psi_px, vec2 in_cell) {
    return psi_px - bend * times(px_per_cell, in_cell);
}

#if ARRAY != 0
// One ray that stands for the whole retinal pixel, at one place in it.
vec3 sampled(Retina at, vec4 ray, vec2 place_px) {
    vec2 q = at.crossed.xy + ray.xy + array_from_panel * times(cells_per_px, place_px);
    vec2 cell = nearest_cell(q);
    if (!is_open(q - cell)) return vec3(0.0);  // blocked by the mask
    vec2 landing = bent(ray.zw + place_px, q - cell);
    if (barriers != 0) {
        vec2 off = nearest_cell(from_owner(at.owner, at.crossed, cell, landing));
        if (off != vec2(0.0)) return vec3(0.0);  // absorbed by a barrier
    }
    return radiance_at(at.pixel, landing, at.eye);
}
#endif

#if ARRAY == 1 && AREA_MEANS
// All rays of the retinal pixel through one pupil point: exact where they pass one lenslet.
vec3 through_lenslets(Retina at, vec4 ray, vec2 place_px) {
    vec2 q = at.crossed.xy + ray.xy;
    vec2 cell = nearest_cell(q);
    vec2 in_cell = q - cell;
    vec2 landing = bent(ray.zw, in_cell);
    bool whole = max(abs(in_cell.x), abs(in_cell.y)) <= whole_at_array;
    if (whole && barriers != 0) {
        vec2 off = abs(from_owner(at.owner, at.crossed, cell, landing));
        whole = max(off.x, off.y) <= whole_at_barrier;
    }
    if (whole) return mean_radiance(at.pixel, landing, footprint_px, at.eye);
    return sampled(at, ray, place_px);
}
#endif

// The light of one ray of the table.
vec3 light_of(Retina at, int index) {
#if ARRAY == 0
    return mean_radiance(at.pixel, rays[index].zw, footprint_px, at.eye);
#elif ARRAY == 1 && AREA_MEANS
    return through_lenslets(at, rays[index], within[index]);
#else
    return sampled(at, rays[index], within[index]);
#endif
}

#if ARRAY == 2
// Only the rays that holes can pass: hole by hole, the bins of rays that lie under it.
vec3 through_holes(Retina at, int set) {
    int bins = set * (bin_count.x * bin_count.y + 1);
    // All rays together cross within a rectangle of bins; these are the holes that touch it.
    vec2 start = at.crossed.xy + bin_origin;
    vec2 low = ceil(start - half_aperture);
    vec2 high = floor(start + vec2(bin_count) * bin_cells + half_aperture);
    vec3 total = vec3(0.0);
    for (float row = low.y; row <= high.y; row += 1.0) {
        for (float column = low.x; column <= high.x; column += 1.0) {
            vec2 centre = vec2(column, row) - start;
            ivec2 from = max(ivec2(floor((centre - half_aperture) / bin_cells)), ivec2(0));
            ivec2 to = min(ivec2(floor((centre + half_aperture) / bin_cells)), bin_count - 1);
            if (from.x > to.x) continue;
            for (int y = from.y; y <= to.y; y++) {
                int line = bins + y * bin_count.x;
                int end = bin_starts[line + to.x + 1];
                for (int i = bin_starts[line + from.x]; i < end; i++) {
                    total += light_of(at, i);
                }
            }
        }
    }
    return total;
}
#endif

vec3 gathered(Retina at, int set) {
#if ARRAY == 2
    return through_holes(at, set);
#else
    vec3 total = vec3(0.0);
    int first = set * points + batch_first;
    for (int i = first; i < first + batch_points; i++) total += light_of(at, i);
    return total;
#endif
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
