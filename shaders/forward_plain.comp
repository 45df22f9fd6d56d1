// The forward prefilter as one would write it first: what forward.comp is timed against.
//
// Reads:  target (what the eyes should perceive, linear), the inverse maps of both eyes.
// Writes: shown (the panel image, linear).
// Twin:   vrlf/reference/forward.py. Derivation: vrlf/optics/inverse.py.
//
// Defines: DEGREE of the displacement polynomials; RAY_SETS 1 where all colours share their
//          samples (full sub-pixels, one wavelength), else 3; PERIOD_X, PERIOD_Y as in
//          include/period.glsl.

#include "block/ForwardPlain"
layout(local_size_x = GROUP_PX, local_size_y = GROUP_PX) in;

layout(binding = 0) uniform sampler2D target;
layout(binding = 0, rgba32f) writeonly uniform image2D shown;

layout(std430, binding = 0) readonly buffer Displacements { vec2 displacements[]; };
layout(std430, binding = 2) readonly buffer Crossings { vec4 crossings[]; };
layout(std430, binding = 3) readonly buffer Owners { vec4 owners[]; };

#include "include/viewport.glsl"
#include "include/period.glsl"
#include "include/lattice.glsl"
#include "include/crossings.glsl"

struct Pixel {
    ivec2 at;
    int eye;
    vec4 crossed;  // where the ray to the pupil's centre crosses the array
    vec4 owner;
    vec4 law;
    vec4 owner_law;
};

// X - x in pixels for a place in a cell: two polynomials at once, by Horner's rule.
vec2 displacement(vec2 t, int set) {
    int first = set * (DEGREE + 1) * (DEGREE + 1);
    vec2 value = vec2(0.0);
    for (int i = DEGREE; i >= 0; i--) {
        vec2 inner = vec2(0.0);
        for (int j = DEGREE - i; j >= 0; j--) {
            inner = inner * t.y + displacements[first + i * (DEGREE + 1) + j];
        }
        value = value * t.x + inner;
    }
    return value;
}

vec3 clamped_texel(ivec2 pixel, int eye) {
    int first = first_column(eye);
    pixel = clamp(pixel, ivec2(first, 0), ivec2(first + view_px.x - 1, view_px.y - 1));
    return texelFetch(target, pixel, 0).rgb;
}

// Bilinear between pixel centres; the edge pixel goes on to the viewport's border, black beyond.
vec3 read_target(Pixel from, vec2 place) {
    vec2 border = vec2(from.at - ivec2(first_column(from.eye), 0)) + 0.5 + place;
    if (any(lessThan(border, vec2(0.0))) || any(greaterThan(border, vec2(view_px)))) {
        return vec3(0.0);
    }
    vec2 whole = floor(place);
    vec2 part = place - whole;
    ivec2 corner = from.at + ivec2(whole);
    vec3 upper = mix(clamped_texel(corner, from.eye),
                     clamped_texel(corner + ivec2(1, 0), from.eye), part.x);
    vec3 lower = mix(clamped_texel(corner + ivec2(0, 1), from.eye),
                     clamped_texel(corner + ivec2(1, 1), from.eye), part.x);
    return mix(upper, lower, part.y);
}

// One sample: rgb is what it reads, a is 1 if its ray met the pupil.
vec4 sample_at(Pixel from, vec2 place_px, int set) {
    vec2 even = array_from_panel * times(cells_per_px, place_px);
    vec2 q = from.crossed.xy + in_cells(even, from.law);
    vec2 cell = nearest_cell(q);
    vec2 in_cell = from_middle(q, cell, even, from.crossed, from.law);
    vec2 pupil = times(pupil_radii_per_cell[from.eye], in_cell);
    if (dot(pupil, pupil) > 1.0) return vec4(0.0);  // missed the pupil
    if (barriers != 0) {
        vec2 off = from_owner(from.owner, from.owner_law, from.crossed, cell, place_px);
        if (nearest_cell(off) != vec2(0.0)) return vec4(0.0);  // absorbed by a wall
    }
    return vec4(read_target(from, place_px + displacement(in_cell, set)), 1.0);
}

// The mean over a grid of points in an emitting rectangle, of those that met the pupil.
vec3 mean_of(Pixel from, vec4 box, int set) {
    vec4 sum = vec4(0.0);
    for (int row = 0; row < subpixel_grid; row++) {
        for (int column = 0; column < subpixel_grid; column++) {
            vec2 part = (vec2(column, row) + 0.5) / float(subpixel_grid);
            sum += sample_at(from, mix(box.xy, box.zw, part) - 0.5, set);
        }
    }
    // What a pixel lacks stays dark.
    return sum.a > 0.0 && box.z > box.x ? sum.rgb / sum.a : vec3(0.0);
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (pixel.x >= panel_px.x || pixel.y >= panel_px.y) return;
    int eye = eye_of(pixel.x);
    vec3 light = vec3(0.0);
    if (eye != NO_EYE) {
        Pixel from = Pixel(pixel, eye, CROSSED_IN(crossings, pixel, eye), vec4(0.0),
                           LAW_IN(crossings, pixel, eye), vec4(0.0));
        if (barriers != 0) {
            from.owner = CROSSED_IN(owners, pixel, eye);
            from.owner_law = LAW_IN(owners, pixel, eye);
        }
#if RAY_SETS == 1
        light = mean_of(from, emitting[first_box(pixel)], eye);
#else
        int first = first_box(pixel);
        for (int c = 0; c < 3; c++) light[c] = mean_of(from, emitting[first + c], eye * 3 + c)[c];
#endif
    }
    imageStore(shown, pixel, vec4(light, 1.0));
}
