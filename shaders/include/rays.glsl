// The rays of a retinal pixel: through the pupil, the array and its barriers, to the panel.
//
// What a panel pixel is worth is the includer's: it defines
//     vec3 shown(Retina at, vec2 offset, vec3 weight)
// the light of the panel pixel at this offset (whole pixels, right and down) from the retinal
// pixel, each colour with its weight.
//
// Needs of the block: RAY_FIELDS of vrlf/passes/rays.py; of the shader: the buffers rays,
// within, bin_starts, crossings and owners, subpixels.glsl, lattice.glsl, crossings.glsl, and the
// defines ARRAY, COLOURS, BY_HOLE.
// Twins: vrlf/reference/perceive.py for points, vrlf/reference/quadrature.py for the rest.
// Derivation: vrlf/optics/samples.py, vrlf/optics/quadrature.py.

struct Retina {
    ivec2 pixel;   // the retinal pixel, named by its panel point; or one at its place of a period
    int eye;
    vec4 crossed;  // where its chief ray crosses the array
    vec4 owner;    // the same for the barriers
    vec4 law;        // how the pitch varies from the crossing on
    vec4 owner_law;  // and from the owner
};

vec3 shown(Retina at, vec2 offset, vec3 weight);

// A pixel as it stands on the panel.
Retina retina_at(ivec2 pixel, int eye) {
    Retina at = Retina(pixel, eye, vec4(0.0), vec4(0.0), vec4(0.0), vec4(0.0));
#if ARRAY != 0
    at.crossed = CROSSED_IN(crossings, pixel, eye);
    at.law = LAW_IN(crossings, pixel, eye);
    if (barriers != 0) {
        at.owner = CROSSED_IN(owners, pixel, eye);
        at.owner_law = LAW_IN(owners, pixel, eye);
    }
#endif
    return at;
}

#if ARRAY == 0
// All rays of a pixel, over a square of a pixel's size about a place.
vec3 over_landing(Retina at, vec2 place) {
    vec2 first = floor(place);
    vec3 total = vec3(0.0);
    for (int row = 0; row < 2; row++) {
        for (int column = 0; column < 2; column++) {
            vec2 pixel = first + vec2(column, row);
            vec3 weight = emission_over(at.pixel + ivec2(pixel), place - pixel, 1.0);
            total += shown(at, pixel, weight);
        }
    }
    return total;
}
#elif ARRAY == 1
#include "include/lines.glsl"
#else
#include "include/holes.glsl"
#endif

vec3 gathered(Retina at, int set) {
#if ARRAY == 2 && BY_HOLE
    return through_each_hole(at, set);
#else
#if ARRAY == 2
    if (bin_count.x != 0) return through_holes(at, set);
#endif
    vec3 total = vec3(0.0);
    int first = set * points + batch_first;
    for (int i = first; i < first + batch_points; i++) {
#if ARRAY == 0
        total += over_landing(at, rays[i].zw);
#elif ARRAY == 1
        total += along(at, i);
#else
        total += sampled(at, rays[i], within[i]);
#endif
    }
    return total;
#endif
}
