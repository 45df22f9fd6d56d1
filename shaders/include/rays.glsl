// The rays of a retinal pixel: through the pupil, the array and its barriers, to the panel.
//
// What a panel pixel is worth is the includer's: it defines
//     vec3 shown(Retina at, vec2 offset, vec3 weight)
// the light of the panel pixel at this offset (whole pixels, right and down) from the retinal
// pixel, each colour with its weight.
//
// Needs of the block: RAY_FIELDS of vrlf/passes/rays.py; of the shader: the buffers rays,
// within, bin_starts, crossings and owners, viewport.glsl, subpixels.glsl, lattice.glsl, and the
// defines ARRAY, COLOURS, BY_HOLE, LATERAL, VARYING.
// Twins: vrlf/reference/perceive.py for points, vrlf/reference/quadrature.py for the rest.
// Derivation: vrlf/optics/samples.py, vrlf/optics/quadrature.py.

#include "include/lateral.glsl"

struct Retina {
    ivec2 pixel;   // the retinal pixel, named by its panel point; or one at its place of a period
    int eye;
    vec4 crossed;  // where its chief ray crosses the array
    vec4 owner;    // the same for the barriers
    vec4 law;        // how the pitch varies from the crossing on
    vec4 owner_law;  // and from the owner
#if LATERAL
    vec2 lateral;  // how far from the pixel its colour lands, in pixels
    float side;    // of the retinal pixel's image on a bare panel
#endif
};

// A pixel's rays in one colour.
Retina retina_of(ivec2 pixel, int eye, int colour) {
    Retina at;
    at.pixel = pixel;
    at.eye = eye;
    at.crossed = at.owner = at.law = at.owner_law = vec4(0.0);
#if ARRAY != 0
    at.crossed = crossing_of(pixel, eye, colour);
    at.law = LAW_IN(crossings, pixel, eye);
    if (barriers != 0) {
        at.owner = CROSSED_IN(owners, pixel, eye);
        at.owner_law = LAW_IN(owners, pixel, eye);
    }
#endif
#if LATERAL
    at.lateral = lateral_of(pixel, eye, colour);
    at.side = magnified[colour].y;
#endif
    return at;
}

// Where a ray lands, in pixels from the retinal pixel.
vec2 landed(Retina at, vec2 landing) {
#if LATERAL
    return landing + at.lateral;
#else
    return landing;
#endif
}

vec3 shown(Retina at, vec2 offset, vec3 weight);

#if ARRAY == 0
// All rays of a pixel, over a square of its image's size about a place.
vec3 over_landing(Retina at, vec2 place) {
#if LATERAL
    const int met = 3;  // the image is some thousandths larger than a pixel, or smaller
    float side = at.side;
    place += 0.5 - 0.5 * side;
#else
    const int met = 2;
    const float side = 1.0;
#endif
    vec2 first = floor(place);
    vec3 total = vec3(0.0);
    for (int row = 0; row < met; row++) {
        for (int column = 0; column < met; column++) {
            vec2 pixel = first + vec2(column, row);
            vec3 weight = emission_over(at.pixel + ivec2(pixel), place - pixel, side);
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
        total += over_landing(at, landed(at, rays[i].zw));
#elif ARRAY == 1
        total += along(at, i);
#else
        total += sampled(at, rays[i], within[i]);
#endif
    }
    return total;
#endif
}
