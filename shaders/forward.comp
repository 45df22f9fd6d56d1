// The forward prefilter, sample by sample: each sub-pixel shows what the one lenslet that serves
// it needs. Takes any map and any pixel.
//
// Reads:  target (what the eyes should perceive, linear), the inverse maps of both eyes; with
//         LISTED the pixels to do.
// Writes: shown (the panel image, linear); with LISTED the listed pixels of it.
// Twin:   vrlf/reference/forward.py. Derivation: vrlf/optics/inverse.py.
//
// Defines: DEGREE of the displacement polynomials; RAY_SETS 1 where all colours share their
//          samples (full sub-pixels, one wavelength), else 3; GRID, the samples along a side;
//          WALLS 1 with barriers that absorb; PERIOD_X, PERIOD_Y (include/period.glsl); LISTED;
//          LATERAL 1 where the colours are magnified differently; ALIKE 1 where they differ in no
//          term above the linear ones; ONE_BOX 1 where they emit from the same places.
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

// Between which texels a landing lies; the edge pixel goes on to the viewport's border.
struct Read {
    vec2 pixel;  // the upper left texel
    vec2 part;   // of the way to the lower right one
};

Read read_at(Pixel from, vec2 landing) {
    vec2 low = vec2(first_column(from.eye), 0) - vec2(from.at);
    vec2 high = low + vec2(view_px) - 1.0;
    landing = clamp(landing, low, high);
    // At the far edge the last two texels, not the last and the other eye's first.
    vec2 whole = min(floor(landing), high - 1.0);
    return Read(vec2(from.at) + whole, landing - whole);
}

// Bilinear between pixel centres.
float light_of(Read read, int colour) {
    vec4 texels = four_texels(read.pixel, colour);
    vec2 columns = mix(texels.wx, texels.zy, read.part.x);
    return mix(columns.x, columns.y, read.part.y);
}

// Sums over the samples of a sub-pixel: light in all but the last, those that met the pupil there.
void add_shared(inout vec4 sum, Pixel from, vec2 column_row) {
    Ray ray = ray_at(from, sample_place(from, 0, column_row), 0);
    Read read = read_at(from, ray.landing);
    vec3 light = vec3(light_of(read, 0), light_of(read, 1), light_of(read, 2));
    sum.rgb += reads(from, ray) ? light : vec3(0.0);
    sum.a += float(ray.met);
}

void add(inout vec2 sum, Pixel from, int colour, vec2 column_row) {
    Ray ray = ray_at(from, sample_place(from, colour, column_row), colour);
    float light = light_of(read_at(from, ray.landing), colour);
    sum.x += reads(from, ray) ? light : 0.0;
    sum.y += float(ray.met);
}

float mean_of(Pixel pixel, int colour) {
    Pixel from = in_colour(pixel, colour);
    vec2 sum = vec2(0.0);
#define ADD(column, row) add(sum, from, colour, vec2(column, row));
    EACH_SAMPLE(ADD)
#undef ADD
    return sum.y > 0.0 ? sum.x / sum.y : 0.0;
}

vec3 light_at(Pixel from) {
#if RAY_SETS == 1
    vec4 sum = vec4(0.0);
#define ADD(column, row) add_shared(sum, from, vec2(column, row));
    EACH_SAMPLE(ADD)
#undef ADD
    return sum.a > 0.0 ? sum.rgb / sum.a : vec3(0.0);
#else
    return vec3(mean_of(from, 0), mean_of(from, 1), mean_of(from, 2));
#endif
}
