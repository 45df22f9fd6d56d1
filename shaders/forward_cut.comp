// Which pixels have a sub-pixel that is cut: footprints cannot do them. Once for a prescription.
//
// Reads:  the inverse maps of both eyes.
// Writes: cut (an unsigned byte a pixel), 1 or 0.
// Derivation: vrlf/optics/footprint.py.
//
// Defines: as in forward_footprints.comp.
// A layer of groups is an eye.

#include "block/Forward"
layout(local_size_x = GROUP_PX, local_size_y = GROUP_PX) in;

layout(std430, binding = 2) readonly buffer Crossings { vec4 crossings[]; };
layout(std430, binding = 3) readonly buffer Owners { vec4 owners[]; };
layout(binding = 0, r8ui) writeonly uniform uimage2D cut;

#include "include/viewport.glsl"
#include "include/lattice.glsl"
#include "include/forward_rays.glsl"
#include "include/each_sample.glsl"

// Whether a landing has four texels of its own eye about it, so that nothing is repeated.
bool lands_within(Pixel from, vec2 landing) {
    vec2 texel = vec2(from.at - ivec2(first_column(from.eye), 0)) + landing;
    return all(greaterThanEqual(texel, vec2(0.0))) && all(lessThanEqual(texel, vec2(view_px - 1)));
}

// Not cut: all samples read with the middle, in its cell, or none reads and the middle doesn't.
bool follows(Pixel from, Ray middle, vec2 place, int colour) {
    Ray ray = ray_at(from, place, colour);
    bool same = ray.met && ray.cell == middle.cell && lands_within(from, ray.landing);
    return reads(from, middle) ? same : !reads(from, ray);
}

bool is_cut(Pixel pixel, int colour) {
    Pixel from = in_colour(pixel, colour);
    Ray middle = ray_at(from, sample_place(from, colour, vec2(0.5 * float(GRID - 1))), colour);
    bool all_follow = true;
#define TEST(column, row) \
    all_follow = all_follow \
              && follows(from, middle, sample_place(from, colour, vec2(column, row)), colour);
    EACH_SAMPLE(TEST)
#undef TEST
    return !all_follow;
}

void main() {
    int eye = int(gl_WorkGroupID.z);
    ivec2 at = ivec2(gl_GlobalInvocationID.xy) + ivec2(first_column(eye), 0);
    Pixel from = pixel_at(at, eye);
    bool any_cut = is_cut(from, 0);
#if RAY_SETS == 3
    any_cut = is_cut(from, 1) || any_cut;
    any_cut = is_cut(from, 2) || any_cut;
#endif
    if (is_written_by(at, eye)) imageStore(cut, at, uvec4(any_cut && eye_of(at.x) == eye));
}
