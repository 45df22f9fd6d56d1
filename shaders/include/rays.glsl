// The rays of a retinal pixel: through the pupil, the array and its barriers, to the panel.
//
// What happens where a ray lands is the includer's: it defines
//     vec3 at_landing(Retina at, vec2 place)              one ray, at a place of the panel
//     vec3 over_landing(Retina at, vec2 place, float side) all rays of a pixel, over a square
// with places in pixels from the retinal pixel's own centre.
//
// Needs of the block: RAY_FIELDS of vrlf/passes/perceive.py; of the shader: the buffers rays,
// within and bin_starts, lattice.glsl, and the defines ARRAY, COLOURS, AREA_MEANS.
// Twin: vrlf/reference/perceive.py. Derivation: vrlf/optics/samples.py.

struct Retina {
    ivec2 pixel;   // the retinal pixel, named by its panel point
    int eye;
    vec4 crossed;  // where its chief ray crosses the array
    vec4 owner;    // the same for the barriers
};

vec3 at_landing(Retina at, vec2 place);
vec3 over_landing(Retina at, vec2 place, float side);

// A lenslet, or hole, centred in a cell moves what it passes by -(g / f) (y - c).
vec2 bent(vec2 psi_px, vec2 in_cell) {
    return psi_px - bend * times(px_per_cell, in_cell);
}

#if ARRAY != 0
// One ray that stands for the whole retinal pixel, at one place in it.
vec3 sampled(Retina at, vec4 ray, vec2 place_px) {
    vec2 q = at.crossed.xy + ray.xy + array_from_panel * times(cells_per_px, place_px);
    vec2 cell = nearest_cell(q);
    if (!is_open(q - cell)) return vec3(0.0);  // blocked by the mask
    vec2 landing = bent(ray.zw + place_px, q - cell);
    if (barriers != 0) {
        vec2 off = nearest_cell(from_owner(at.owner, at.crossed, cell, landing));
        if (off != vec2(0.0)) return vec3(0.0);  // absorbed by a barrier
    }
    return at_landing(at, landing);
}
#endif

#if ARRAY == 1 && AREA_MEANS
// All rays of the retinal pixel through one pupil point: exact where they pass one lenslet.
vec3 through_lenslets(Retina at, vec4 ray, vec2 place_px) {
    vec2 q = at.crossed.xy + ray.xy;
    vec2 cell = nearest_cell(q);
    vec2 in_cell = q - cell;
    vec2 landing = bent(ray.zw, in_cell);
    bool whole = max(abs(in_cell.x), abs(in_cell.y)) <= whole_at_array;
    if (whole && barriers != 0) {
        vec2 off = abs(from_owner(at.owner, at.crossed, cell, landing));
        whole = max(off.x, off.y) <= whole_at_barrier;
    }
    if (whole) return over_landing(at, landing, footprint_px);
    return sampled(at, ray, place_px);
}
#endif

// The light of one ray of the table.
vec3 light_of(Retina at, int index) {
#if ARRAY == 0
    return over_landing(at, rays[index].zw, footprint_px);
#elif ARRAY == 1 && AREA_MEANS
    return through_lenslets(at, rays[index], within[index]);
#else
    return sampled(at, rays[index], within[index]);
#endif
}

#if ARRAY == 2
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
    vec2 low = ceil(start - half_aperture);
    vec2 high = floor(start + vec2(bin_count) * bin_cells + half_aperture);
    vec3 total = vec3(0.0);
    for (float row = low.y; row <= high.y; row += 1.0) {
        for (float column = low.x; column <= high.x; column += 1.0) {
            vec2 centre = vec2(column, row) - start;
            ivec2 from = max(ivec2(floor((centre - half_aperture) / bin_cells)), ivec2(0));
            ivec2 to = min(ivec2(floor((centre + half_aperture) / bin_cells)), bin_count - 1);
            if (from.x > to.x) continue;
            for (int y = from.y; y <= to.y; y++) {
                int line = bins + y * bin_count.x;
                int end = bin_starts[line + to.x + 1];
                for (int i = bin_starts[line + from.x]; i < end; i++) {
                    // A bin may lie under two holes: each takes its own rays only.
                    if (cell_of(at, i) == vec2(column, row)) total += light_of(at, i);
                }
            }
        }
    }
    return total;
}
#endif

vec3 gathered(Retina at, int set) {
#if ARRAY == 2
    if (bin_count.x != 0) return through_holes(at, set);
#endif
    vec3 total = vec3(0.0);
    int first = set * points + batch_first;
    for (int i = first; i < first + batch_points; i++) total += light_of(at, i);
    return total;
}
