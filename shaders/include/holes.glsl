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

#if BY_HOLE
// The light through one hole; `off` is its centre's place from where the ray through the
// pupil's centre crosses the array, in cells.
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
            vec2 strayed = nearest_cell(from_owner(at.owner, at.crossed, cell, place));
            if (strayed != vec2(0.0)) continue;  // absorbed by a barrier
        }
        total += at_landing(at, place, middle.z);
    }
    return total;
}

vec3 through_each_hole(Retina at, int set) {
    vec4 seen = hole_seen[set];
    vec2 centre = at.crossed.xy + seen.xy;
    vec2 low = ceil(centre - seen.zw), high = floor(centre + seen.zw);
    vec3 total = vec3(0.0);
    for (float row = low.y; row <= high.y; row += 1.0) {
        for (float column = low.x; column <= high.x; column += 1.0) {
            vec2 cell = vec2(column, row);
            total += through_hole(at, set, cell, cell - centre);
        }
    }
    return total;
}
#else
// One ray that stands for the whole retinal pixel, at one place in it. With LATERAL the table has
// what the place moves in the ray itself, and the place is 0.
vec3 sampled(Retina at, vec4 ray, vec2 place_px) {
    vec2 q = at.crossed.xy + ray.xy + array_from_panel * times(cells_per_px, place_px);
    vec2 cell = nearest_cell(q);
    if (!is_open(q - cell)) return vec3(0.0);  // blocked by the mask
    vec2 landing = landed(at, ray.zw + place_px);
    if (barriers != 0) {
        vec2 strayed = nearest_cell(from_owner(at.owner, at.crossed, cell, landing));
        if (strayed != vec2(0.0)) return vec3(0.0);  // absorbed by a barrier
    }
    return at_landing(at, landing, 1.0);
}

// The cell that a ray crosses, counted from at.crossed.zw.
vec2 cell_of(Retina at, int index) {
    vec2 place = array_from_panel * times(cells_per_px, within[index]);
    return nearest_cell(at.crossed.xy + rays[index].xy + place);
}

// Only the rays that holes can pass: hole by hole, the bins of rays that lie under it.
vec3 through_holes(Retina at, int set) {
    int bins = set * (bin_count.x * bin_count.y + 1);
    // All rays together cross within a rectangle of bins; these are the holes that touch it.
    vec2 start = at.crossed.xy + bin_origin;
    vec2 low = ceil(start - hole_reach);
    vec2 high = floor(start + vec2(bin_count) * bin_cells + hole_reach);
    vec3 total = vec3(0.0);
    for (float row = low.y; row <= high.y; row += 1.0) {
        for (float column = low.x; column <= high.x; column += 1.0) {
            vec2 centre = vec2(column, row) - start;
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
