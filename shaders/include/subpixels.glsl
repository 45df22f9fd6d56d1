// The light of the panel at a point and over a square.
//
// Needs of the block: what viewport.glsl needs, vec4 emitting[3] (left, top, right, bottom of
// each colour's rectangle in its pixel) and vec4 gain; of the shader: sampler2D panel.
// Twin: vrlf/reference/perceive.py, _emitted and _area_mean.

vec3 texel(ivec2 pixel, int eye) {
    return in_viewport(pixel, eye) ? texelFetch(panel, pixel, 0).rgb : vec3(0.0);
}

// Radiance at a place, in pixels from the centre of `pixel`.
vec3 radiance_at(ivec2 pixel, vec2 place, int eye) {
    vec2 from_corner = place + 0.5;
    vec2 whole = floor(from_corner);
    vec2 within = from_corner - whole;
    vec3 lit;
    for (int c = 0; c < 3; c++) {
        vec4 box = emitting[c];
        bool inside = within.x >= box.x && within.x < box.z && within.y >= box.y && within.y < box.w;
        lit[c] = inside ? gain[c] : 0.0;
    }
    return lit * texel(pixel + ivec2(whole), eye);
}

// What the interval [low, high], in pixels, shares with an emitting interval of one pixel.
float shared_length(float low, float high, float from, float to) {
    return max(min(min(high, 1.0), to) - max(max(low, 0.0), from), 0.0);
}

// Mean radiance over a square about a place; its side is at most a pixel, so four pixels hold it.
vec3 mean_radiance(ivec2 pixel, vec2 place, float side, int eye) {
    vec2 low = place + 0.5 - 0.5 * side;
    vec2 first = floor(low);
    low -= first;
    ivec2 corner = pixel + ivec2(first);
    vec3 total = vec3(0.0);
    for (int row = 0; row < 2; row++) {
        for (int column = 0; column < 2; column++) {
            vec2 start = low - vec2(column, row);
            vec2 end = start + side;
            vec3 area;
            for (int c = 0; c < 3; c++) {
                vec4 box = emitting[c];
                area[c] = shared_length(start.x, end.x, box.x, box.z)
                        * shared_length(start.y, end.y, box.y, box.w);
            }
            total += area * texel(corner + ivec2(column, row), eye);
        }
    }
    return total * gain.rgb / (side * side);
}
