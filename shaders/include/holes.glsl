// Rays behind a mask: points of each hole, or those blind points that lie under a hole.
//
// Needs what rays.glsl needs. By hole, rays[i] is what a hole's point i adds to the place in
// the pupil (.xy, radii) and on the panel (.zw, pixels); hole_maps holds what the holes add.
// Twins: vrlf/reference/quadrature.py by hole, vrlf/reference/perceive.py else.

// One ray that lands at a place of the panel, in pixels from the retinal pixel's centre.
vec3 at_landing(Retina at, vec2 place, float weight) {
    vec2 whole = floor(place + 0.5);
    return shown(at, whole, weight * emission_at(at.pixel + ivec2(whole), place + 0.5 - whole));
}

// Whether a barrier absorbs what a cell lets through to a place of the panel.
bool is_walled_off(Retina at, vec2 cell, vec2 place) {
    vec2 off = from_owner(at.owner, at.owner_law, at.crossed, cell, place);
    return nearest_cell(off) != vec2(0.0);
}

#if BY_HOLE
// The light through one hole; `off` is its centre's even place from where the ray through the
// pupil's centre crosses the array.
vec3 through_hole(Retina at, int set, vec2 cell, vec2 off) {
    vec2 in_pupil = times(hole_maps[3 * set], off);
    vec4 middle = hole_maps[3 * set + 2];
    vec2 landing = landed(at, middle.xy + times(hole_maps[3 * set + 1], off));
    vec3 total = vec3(0.0);
    int first = set * points + batch_first;
    for (int i = first; i < first + batch_points; i++) {
        vec2 u = in_pupil + rays[i].xy;
        if (dot(u, u) > 1.0) continue;
        vec2 place = landing + rays[i].zw;
        if (barriers != 0) {
            if (is_walled_off(at, cell, place)) continue;
        }
        total += at_landing(at, place, middle.z);
    }
    return total;
}

vec3 through_each_hole(Retina at, int set) {
    vec4 seen = hole_seen[set];
#if VARYING
    vec2 low = ceil(at.crossed.xy + in_cells(seen.xy - seen.zw, at.law));
    vec2 high = floor(at.crossed.xy + in_cells(seen.xy + seen.zw, at.law));
#else
    vec2 centre = at.crossed.xy + seen.xy;
    vec2 low = ceil(centre - seen.zw), high = floor(centre + seen.zw);
#endif
    vec3 total = vec3(0.0);
    for (float row = low.y; row <= high.y; row += 1.0) {
        for (float column = low.x; column <= high.x; column += 1.0) {
            vec2 cell = vec2(column, row);
#if VARYING
            vec2 off = evenly(cell - at.crossed.xy, at.law) - seen.xy;
#else
            vec2 off = cell - centre;
#endif
            total += through_hole(at, set, cell, off);
        }
    }
    return total;
}
#else
// Where a ray crosses whose even places from the pixel's crossing are two together.
vec2 crossed_at(Retina at, vec2 even, vec2 moved) {
#if VARYING
    return at.crossed.xy + in_cells(even + moved, at.law);
#else
    return at.crossed.xy + even + moved;
#endif
}

// One ray that stands for the whole retinal pixel, at one place in it. With LATERAL the table has
// what the place moves in the ray itself, and the place is 0.
vec3 sampled(Retina at, vec4 ray, vec2 place_px) {
    vec2 moved = array_from_panel * times(cells_per_px, place_px);
    vec2 q = crossed_at(at, ray.xy, moved), cell = nearest_cell(q);
    vec2 in_cell = from_middle(q, cell, ray.xy + moved, at.crossed, at.law);
    if (!is_open(in_cell)) return vec3(0.0);  // blocked by the mask
    vec2 landing = landed(at, ray.zw + place_px);
    if (barriers != 0) {
        if (is_walled_off(at, cell, landing)) return vec3(0.0);
    }
    return at_landing(at, landing, 1.0);
}

// The cell that a ray crosses, counted from at.crossed.zw.
vec2 cell_of(Retina at, int index) {
    vec2 place = array_from_panel * times(cells_per_px, within[index]);
    return nearest_cell(crossed_at(at, rays[index].xy, place));
}

// Only the rays that holes can pass: hole by hole, the bins of rays that lie under it.
vec3 through_holes(Retina at, int set) {
    int bins = set * (bin_count.x * bin_count.y + 1);
    // All rays together cross within a rectangle of bins; these are the holes that touch it.
#if VARYING
    vec2 end = bin_origin + vec2(bin_count) * bin_cells;
    vec2 low = ceil(at.crossed.xy + in_cells(bin_origin - hole_reach, at.law));
    vec2 high = floor(at.crossed.xy + in_cells(end + hole_reach, at.law));
#else
    vec2 start = at.crossed.xy + bin_origin;
    vec2 low = ceil(start - hole_reach);
    vec2 high = floor(start + vec2(bin_count) * bin_cells + hole_reach);
#endif
    vec3 total = vec3(0.0);
    for (float row = low.y; row <= high.y; row += 1.0) {
        for (float column = low.x; column <= high.x; column += 1.0) {
#if VARYING
            vec2 centre = evenly(vec2(column, row) - at.crossed.xy, at.law) - bin_origin;
#else
            vec2 centre = vec2(column, row) - start;
#endif
            ivec2 from = max(ivec2(floor((centre - hole_reach) / bin_cells)), ivec2(0));
            ivec2 to = min(ivec2(floor((centre + hole_reach) / bin_cells)), bin_count - 1);
            if (from.x > to.x) continue;
            for (int y = from.y; y <= to.y; y++) {
                int line = bins + y * bin_count.x;
                int end = bin_starts[line + to.x + 1];
                for (int i = bin_starts[line + from.x]; i < end; i++) {
                    // A bin may lie under two holes: each takes its own rays only.
                    if (cell_of(at, i) == vec2(column, row)) total += sampled(at, rays[i], within[i]);
                }
            }
        }
    }
    return total;
}
#endif
