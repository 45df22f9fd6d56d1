// The light of the panel at a point and over a square.
//
// Needs: viewport.glsl, subpixels.glsl, sampler2D panel.
// Twin: vrlf/reference/perceive.py.

vec3 texel(ivec2 pixel, int eye) {
    return in_viewport(pixel, eye) ? texelFetch(panel, pixel, 0).rgb : vec3(0.0);
}

// Radiance at a place, in pixels from the centre of `pixel`.
vec3 radiance_at(ivec2 pixel, vec2 place, int eye) {
    vec2 whole = floor(place + 0.5);
    return emission_at(place + 0.5 - whole) * texel(pixel + ivec2(whole), eye);
}

// Mean radiance over a square about a place, which FOOTPRINT_PX x FOOTPRINT_PX pixels hold.
vec3 mean_radiance(ivec2 pixel, vec2 place, float side, int eye) {
    vec2 low = place + 0.5 - 0.5 * side;
    vec2 first = floor(low);
    vec3 total = vec3(0.0);
    for (int row = 0; row < FOOTPRINT_PX; row++) {
        for (int column = 0; column < FOOTPRINT_PX; column++) {
            vec2 at = first + vec2(column, row);
            total += emission_over(low - at, side) * texel(pixel + ivec2(at), eye);
        }
    }
    return total;
}
