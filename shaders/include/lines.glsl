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

#if HEXAGONAL
// Along the normals of a cell's borders: the cell is where all are within 1/2.
#define BORDERS vec3
vec3 along_normals(vec2 v) {
    return vec3(toward_neighbours(v), 0.5 * (v.y - v.x));
}

vec3 moving(vec3 v) {
    return mix(v, vec3(1e-9), lessThan(abs(v), vec3(1e-9)));
}

float first_of(vec3 until) {
    return min(until.x, min(until.y, until.z));
}

vec2 inside(vec3 low, vec3 high, vec3 from, vec3 inverse_step) {
    vec3 a = (low - from) * inverse_step, b = (high - from) * inverse_step;
    vec3 enter = min(a, b), leave = max(a, b);
    return vec2(max(enter.x, max(enter.y, enter.z)), first_of(leave));
}

// Which border comes first, as the step to the neighbour beyond it.
vec2 across(vec3 until, vec3 toward) {
    if (until.x <= min(until.y, until.z)) return vec2(toward.x, 0.0);
    return until.y <= until.z ? vec2(0.0, toward.y) : vec2(-toward.z, toward.z);
}
#else
#define BORDERS vec2
vec2 along_normals(vec2 v) {
    return v;
}
#endif

float first_of(vec2 until) {
    return min(until.x, until.y);
}

// Where a moving point is within a box, as an interval of its way.
vec2 inside(vec2 low, vec2 high, vec2 from, vec2 inverse_step) {
    vec2 a = (low - from) * inverse_step, b = (high - from) * inverse_step;
    vec2 enter = min(a, b), leave = max(a, b);
    return vec2(max(enter.x, enter.y), min(leave.x, leave.y));
}

// The emission that a stretch meets on [low, high] of its way in the pixel at `corner`.
vec3 emission_along(vec2 from, vec2 inverse_step, float low, float high, vec2 corner, int first) {
    vec3 lit;
    for (int c = 0; c < 3; c++) {
        vec4 box = emitting[first + c];
        vec2 part = inside(corner + box.xy, corner + box.zw, from, inverse_step);
        lit[c] = max(min(part.y, high) - max(part.x, low), 0.0);
    }
    return lit * gain.rgb;
}

// Where the stretch, landing from `place` on, stays in the area that barriers leave to a cell.
vec2 between_walls(Retina at, vec2 cell, vec2 place, vec2 landing_step) {
    if (barriers == 0) return vec2(0.0, 1.0);
    BORDERS step = moving(along_normals(barrier_scale * times(cells_per_px, landing_step)));
#if VARYING
    vec2 middle = cell - (at.owner.zw - at.crossed.zw) - at.owner.xy;
    vec2 low = evenly(middle - 0.5, at.owner_law), high = evenly(middle + 0.5, at.owner_law);
    return inside(low, high, barrier_scale * times(cells_per_px, place), 1.0 / step);
#else
    BORDERS owned = along_normals(from_owner(at.owner, at.owner_law, at.crossed, cell, place));
    return inside(BORDERS(-0.5), BORDERS(0.5), owned, 1.0 / step);
#endif
}

// Which of two borders comes first, as a step across it.
vec2 across(vec2 until, vec2 toward) {
    return until.x <= until.y ? vec2(toward.x, 0.0) : vec2(0.0, toward.y);
}

// Where the stretch meets the borders of a cell that lie ahead.
BORDERS until_borders(Retina at, vec2 cell, BORDERS toward, BORDERS start, BORDERS inverse) {
#if VARYING
    return (evenly(cell + 0.5 * toward - at.crossed.xy, at.law) - start) * inverse;
#else
    return (along_normals(cell) + 0.5 * toward - start) * inverse;
#endif
}

// Where a stretch that begins at `landing` lands behind a cell.
vec2 behind(Retina at, int index, vec2 cell, vec2 landing) {
    return landing + BEND_OF(index) * times(px_per_cell, evenly(cell - at.crossed.xy, at.law));
}

vec3 along(Retina at, int index) {
    vec2 q = at.crossed.xy + in_cells(rays[2 * index].xy, at.law);
    BORDERS q_step = moving(along_normals(rays[2 * index].zw));
#if VARYING
    vec2 start = rays[2 * index].xy;
#else
    BORDERS start = along_normals(q);
#endif
    vec2 landing = landed(at, rays[2 * index + 1].xy);
    vec2 landing_step = moving(rays[2 * index + 1].zw);
    BORDERS q_inverse = 1.0 / q_step, q_toward = sign(q_step);
    vec2 landing_inverse = 1.0 / landing_step, landing_toward = sign(landing_step);

    vec2 cell = nearest_cell(q);
    vec2 place = behind(at, index, cell, landing);
    vec2 pixel = floor(place + 0.5);
    vec2 walls = between_walls(at, cell, place, landing_step);
    float from = 0.0;
    vec3 total = vec3(0.0);
    for (int piece = 0; piece < most_pieces; piece++) {
        BORDERS until_border = until_borders(at, cell, q_toward, start, q_inverse);
        vec2 until_edge = (pixel + 0.5 * landing_toward - place) * landing_inverse;
        float border = first_of(until_border), edge = first_of(until_edge);
        float to = min(min(border, edge), 1.0);
        vec3 weight = emission_along(place, landing_inverse, max(from, walls.x),
                                     min(to, walls.y), pixel - 0.5,
                                     first_box(at.pixel + ivec2(pixel)));
        total += shown(at, pixel, weight * within[index].x);
        if (to >= 1.0) break;
        from = max(from, to);
        if (border <= edge) {
            cell += across(until_border, q_toward);
            place = behind(at, index, cell, landing);
            pixel = floor(place + from * landing_step + 0.5);
            walls = between_walls(at, cell, place, landing_step);
        } else {
            pixel += across(until_edge, landing_toward);
        }
    }
    return total;
}
