// How the forward prefilter may do each pixel of an eye with a wavefront. Once for a prescription.
//
// Reads:  the inverse maps of both eyes.
// Writes: kinds (an unsigned byte a pixel): 0, shows nothing; 1, is cut, only right sample by
//         sample; else by footprints, so many columns + 16 times so many rows of texels.
// Derivation: vrlf/optics/footprint.py.
//
// Defines: as in forward.comp.
// A layer of groups is an eye.

#include "block/Forward"
layout(local_size_x = GROUP_PX, local_size_y = GROUP_PX) in;

layout(std430, binding = 2) readonly buffer Crossings { vec4 crossings[]; };
layout(std430, binding = 3) readonly buffer Owners { vec4 owners[]; };
layout(binding = 0, r8ui) writeonly uniform uimage2D kinds;

#include "include/viewport.glsl"
#include "include/lattice.glsl"
#include "include/forward_rays.glsl"

const int DARK = 0, CUT = 1, WIDEST = 15;
// What float32 may move a landing by; the programs sum in another order.
const float ROUNDING = 1e-4;

struct Kind {
    bool any_reads;
    bool is_cut;
    ivec2 texels;  // of the widest footprint
};

// Whether a landing has four texels of its own eye about it, so that nothing is repeated.
bool lands_within(Pixel from, vec2 landing) {
    vec2 texel = vec2(from.at - ivec2(first_column(from.eye), 0)) + landing;
    return all(greaterThanEqual(texel, vec2(0.0))) && all(lessThanEqual(texel, vec2(view_px - 1)));
}

// Not cut: all samples meet the pupil in the middle's cell, or none reads and the middle misses.
void add_colour(inout Kind kind, Pixel pixel, int colour) {
    Pixel from = in_colour(pixel, colour);
    Ray middle = ray_at(from, sample_place(from, colour, vec2(0.5 * float(GRID - 1))), colour);
    vec2 low = middle.landing, high = middle.landing;
    for (int row = 0; row < GRID; row++) {
        for (int column = 0; column < GRID; column++) {
            Ray ray = ray_at(from, sample_place(from, colour, vec2(column, row)), colour);
            bool one_reads = reads(from, ray);
            bool same = ray.met && ray.cell == middle.cell && lands_within(from, ray.landing);
            kind.any_reads = kind.any_reads || one_reads;
            kind.is_cut = kind.is_cut || (middle.met ? !same : one_reads);
            low = min(low, ray.landing);
            high = max(high, ray.landing);
        }
    }
    ivec2 texels = ivec2(floor(high + ROUNDING) - floor(low - ROUNDING)) + 2;
    if (middle.met) kind.texels = max(kind.texels, texels);
}

void main() {
    int eye = int(gl_WorkGroupID.z);
    ivec2 at = ivec2(gl_GlobalInvocationID.xy) + ivec2(first_column(eye), 0);
    Pixel from = pixel_at(at, eye);
    Kind kind = Kind(false, false, ivec2(2));
    for (int colour = 0; colour < RAY_SETS; colour++) add_colour(kind, from, colour);
    bool is_wide = any(greaterThan(kind.texels, ivec2(WIDEST)));
    int code = kind.is_cut || is_wide ? CUT : kind.texels.x + 16 * kind.texels.y;
    if (eye_of(at.x) != eye || !kind.any_reads) code = DARK;
    if (is_written_by(at, eye)) imageStore(kinds, at, uvec4(code));
}
