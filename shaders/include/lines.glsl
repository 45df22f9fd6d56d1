// The light along a straight stretch through pupil and retinal pixel, behind lenslets.
//
// The stretch is cut where it leaves a cell or a panel pixel: each piece shows one pixel
// through one lenslet. Places along it run from 0 to 1.
//
// Needs what rays.glsl needs; rays[2 i] is where stretch i crosses the array (cells) and how
// far that moves, rays[2 i + 1] the same on the panel (pixels), within[i].x its share,
// within[i].y how much its colour's lenslets bend.
// Twin: vrlf/reference/quadrature.py. Derivation: vrlf/optics/lines.py.

// g / f of the lenslets that a line passes; one for all lines, or with BENDS its colour's own.
#if BENDS
#define BEND_OF(index) within[index].y
#else
#define BEND_OF(index) bend
#endif

// No component so small that its inverse is not finite.
vec2 moving(vec2 v) {
    return mix(v, vec2(1e-9), lessThan(abs(v), vec2(1e-9)));
}

// Where a moving point is within a box, as an interval of its way.
vec2 inside(vec2 low, vec2 high, vec2 from, vec2 inverse_step) {
    vec2 a = (low - from) * inverse_step, b = (high - from) * inverse_step;
    vec2 enter = min(a, b), leave = max(a, b);
    return vec2(max(enter.x, enter.y), min(leave.x, leave.y));
}

// The emission that a stretch meets on [low, high] of its way in the pixel at `corner`.
vec3 emission_along(vec2 from, vec2 inverse_step, float low, float high, vec2 corner) {
    vec3 lit;
    for (int c = 0; c < 3; c++) {
        vec2 part = inside(corner + emitting[c].xy, corner + emitting[c].zw, from, inverse_step);
        lit[c] = max(min(part.y, high) - max(part.x, low), 0.0);
    }
    return lit * gain.rgb;
}

// Where the stretch, landing from `place` on, stays in the area that barriers leave to a cell.
vec2 between_walls(Retina at, vec2 cell, vec2 place, vec2 landing_step) {
    if (barriers == 0) return vec2(0.0, 1.0);
    vec2 owned = from_owner(at.owner, at.crossed, cell, place);
    vec2 owned_step = moving(barrier_scale * times(cells_per_px, landing_step));
    return inside(vec2(-0.5), vec2(0.5), owned, 1.0 / owned_step);
}

// Which of two borders comes first, as a step across it.
vec2 across(vec2 until, vec2 toward) {
    return until.x <= until.y ? vec2(toward.x, 0.0) : vec2(0.0, toward.y);
}

vec3 along(Retina at, int index) {
    vec2 q = at.crossed.xy + rays[2 * index].xy, q_step = moving(rays[2 * index].zw);
    vec2 landing = landed(at, rays[2 * index + 1].xy);
    vec2 landing_step = moving(rays[2 * index + 1].zw);
    vec2 q_inverse = 1.0 / q_step, landing_inverse = 1.0 / landing_step;
    vec2 q_toward = sign(q_step), landing_toward = sign(landing_step);

    vec2 cell = nearest_cell(q);
    vec2 place = landing + BEND_OF(index) * times(px_per_cell, cell - at.crossed.xy);
    vec2 pixel = floor(place + 0.5);
    vec2 walls = between_walls(at, cell, place, landing_step);
    float from = 0.0;
    vec3 total = vec3(0.0);
    for (int piece = 0; piece < most_pieces; piece++) {
        vec2 until_border = (cell + 0.5 * q_toward - q) * q_inverse;
        vec2 until_edge = (pixel + 0.5 * landing_toward - place) * landing_inverse;
        float border = min(until_border.x, until_border.y);
        float edge = min(until_edge.x, until_edge.y);
        float to = min(min(border, edge), 1.0);
        vec3 weight = emission_along(place, landing_inverse, max(from, walls.x),
                                     min(to, walls.y), pixel - 0.5);
        total += shown(at, pixel, weight * within[index].x);
        if (to >= 1.0) break;
        from = max(from, to);
        if (border <= edge) {
            cell += across(until_border, q_toward);
            place = landing + BEND_OF(index) * times(px_per_cell, cell - at.crossed.xy);
            pixel = floor(place + from * landing_step + 0.5);
            walls = between_walls(at, cell, place, landing_step);
        } else {
            pixel += across(until_edge, landing_toward);
        }
    }
    return total;
}
