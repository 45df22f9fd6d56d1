// How far diffraction at an opening moves a ray on the panel.
//
// Needs of the block: float half_opening (cells), int round_holes, vec4 diffraction_unit
// (lambda g / w of each colour, in cells), vec4 fresnel_number (N of each colour for a shadow as
// large as the opening), ivec2 spread_size (rows, columns), float roots_per_unit, float edge; of
// the shader: the buffer spread, r (1 - rho) by rows of sqrt N and columns of rho.
// Derivation and twin: vrlf/optics/fresnel.py; vrlf/reference/traced.py, diffracted_cells.

// r, in lambda g / w, at a place from 0 in the middle to 1 at the border.
float residual(float rho, float number) {
    float root = sqrt(number);
    float most = float(spread_size.x - 1) / roots_per_unit;
    float larger = max(root / most, 1.0);
    float from_border = max(1.0 - rho, edge) * larger;
    if (from_border >= 1.0) return 0.0;
    float row = min(root, most) * roots_per_unit;
    float column = (1.0 - from_border) * float(spread_size.y - 1);
    int top = min(int(row), spread_size.x - 2), left = min(int(column), spread_size.y - 2);
    int at = top * spread_size.y + left, below = at + spread_size.y;
    float right = column - float(left);
    float upper = mix(spread[at], spread[at + 1], right);
    float lower = mix(spread[below], spread[below + 1], right);
    return larger * mix(upper, lower, row - float(top)) / from_border;
}

// In cells, lattice frame.
//   in_cell  where the ray passes, from the opening's centre
//   scale    how much larger than the opening its shadow is, along the lattice's axes
vec2 diffracted(vec2 in_cell, vec2 scale, int colour) {
    vec2 number = fresnel_number[colour] * abs(scale), place = in_cell / half_opening;
    vec2 way = mix(vec2(1.0), vec2(-1.0), lessThan(scale, vec2(0.0)));
    float unit = diffraction_unit[colour];
    if (round_holes != 0) {
        float rho = length(place);
        return unit * way * place * (residual(rho, number.x) / max(rho, 1e-12));
    }
    vec2 rho = abs(place);
    return unit * way * sign(place)
         * vec2(residual(rho.x, number.x), residual(rho.y, number.y));
}
