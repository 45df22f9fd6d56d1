// The forward prefilter's samples: where a panel point's one lenslet shows it.
//
// Needs of the block: FORWARD of vrlf/passes/forward.py; of the shader: the buffers crossings and
// owners, viewport.glsl, lattice.glsl, and the defines of forward.comp.
// Twin: vrlf/reference/forward.py. Derivation: vrlf/optics/inverse.py.
//
// Places are in pixels, right and down, from the centre of the panel's own pixel: small numbers,
// of which 32-bit floats lose nothing. An eye is uniform for a group and the maps stand in the
// block: software GL reads a uniform place of that once for all lanes, a storage buffer lane by
// lane, once for each of 27 samples.

#include "include/period.glsl"
#include "include/lateral.glsl"

struct Pixel {
    ivec2 at;
    int eye;
    vec4 crossed;  // where the ray to the pupil's centre crosses the array
    vec4 owner;    // the same for the barriers
    vec4 law;        // how the pitch varies from the crossing on
    vec4 owner_law;  // and from the owner
#if LATERAL
    int colour;    // whose ray that is
    vec2 lateral;  // how far its magnification moves the pixel's centre in the target
#endif
};

Pixel pixel_at(ivec2 at, int eye) {
    ivec2 held = min(at, panel_px - 1);  // groups reach beyond the panel
    Pixel from;
    from.at = at;
    from.eye = eye;
    from.crossed = crossing_of(held, eye, 0);
    from.law = LAW_IN(crossings, held, eye);
    from.owner = from.owner_law = vec4(0.0);
#if WALLS
    from.owner = CROSSED_IN(owners, held, eye);
    from.owner_law = LAW_IN(owners, held, eye);
#endif
#if LATERAL
    from.colour = 0;
    from.lateral = lateral_of(held, eye, 0);
#endif
    return from;
}

// The same pixel's rays in a colour that may be magnified differently.
Pixel in_colour(Pixel from, int colour) {
#if LATERAL
    ivec2 held = min(from.at, panel_px - 1);
    from.crossed = crossing_of(held, from.eye, colour);
    from.colour = colour;
    from.lateral = lateral_of(held, from.eye, colour);
#endif
    return from;
}

// Groups reach beyond the panel and the viewport; the left eye's darken the middle column.
bool is_written_by(ivec2 at, int eye) {
    int owner = eye_of(at.x);
    return all(lessThan(at, panel_px)) && (owner == eye || (owner == NO_EYE && eye == 0));
}

int ray_set(int eye, int colour) {
    return eye * RAY_SETS + colour;
}

#include "include/displacement.glsl"

// By which a colour's places are multiplied in the target.
float magnification(Pixel from) {
#if LATERAL
    return magnified[from.colour].y;
#else
    return 1.0;
#endif
}

// Which of the samples are a colour's; where all emit alike, they are worked out once for all.
int box_of(ivec2 pixel, int colour) {
    return first_box(pixel) + (ONE_BOX == 1 ? 0 : colour);
}

// The place of a sample in its sub-pixel's grid; the middle one is at (GRID - 1) / 2.
vec2 sample_place(Pixel from, int colour, vec2 column_row) {
    vec4 grid = samples[box_of(from.at, colour)];
    return grid.xy + column_row * grid.zw;
}

// What a pixel lacks stays dark.
vec3 where_emitting(Pixel from, vec3 light) {
#if PERIOD_X * PERIOD_Y > 1
    int first = first_box(from.at);
    for (int c = 0; c < 3; c++) {
        if (samples[first + c].z == 0.0) light[c] = 0.0;
    }
#endif
    return light;
}

struct Ray {
    vec2 cell;     // the lenslet it takes, counted from crossed.zw
    bool met;      // the pupil, and no barrier
    vec2 seen;     // where it would land through a lenslet that moves nothing
    vec2 through;  // the place of which its displacement is a polynomial
    vec2 landing;  // X, the retinal point
};

// With a wavefront, pixels from the lenslet's middle: whatever the lattice's turn, the samples of a
// sub-pixel then stand in rows and columns.
vec2 through_of(vec2 in_cell, float crossing) {
#if DEGREE == 1
    return in_cell;
#else
    return times(px_per_cell, in_cell) / crossing;
#endif
}

Ray ray_at(Pixel from, vec2 place, int colour) {
#if LATERAL
    float crossing = magnified[from.colour].z;
    vec2 seen = from.lateral + magnified[from.colour].y * place;
    int pupil_map = ray_set(from.eye, colour);
#else
    float crossing = array_from_panel;
    vec2 seen = place;
    int pupil_map = ray_set(from.eye, 0);  // the same for all colours
#endif
    vec2 even = crossing * times(cells_per_px, place);
    vec2 q = from.crossed.xy + in_cells(even, from.law);
    vec2 cell = nearest_cell(q);
    vec2 in_cell = from_middle(q, cell, even, from.crossed, from.law);
    vec2 pupil = times(pupil_radii_per_cell[pupil_map], in_cell);
    bool met = dot(pupil, pupil) <= 1.0;
#if WALLS
    vec2 off = nearest_cell(from_owner(from.owner, from.owner_law, from.crossed, cell, place));
    met = met && off == vec2(0.0);  // else absorbed by a wall
#endif
    vec2 through = through_of(in_cell, crossing);
    return Ray(cell, met, seen, through, seen + displacement(through, from.eye, colour));
}

// Whether a ray meets the pupil and lands in its eye's viewport, the border included.
bool reads(Pixel from, Ray ray) {
    vec2 at = vec2(from.at - ivec2(first_column(from.eye), 0)) + 0.5 + ray.landing;
    return ray.met && all(greaterThanEqual(at, vec2(0.0))) && all(lessThanEqual(at, vec2(view_px)));
}
