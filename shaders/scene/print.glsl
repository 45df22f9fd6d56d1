// Print on a page, filtered over the box that a pixel covers.
//
// Needs: sampler2D print_sums; of the defines: TEXEL_M, PRINT_MEAN.
// Twin:  ink_by_hand in tests/test_scene_print.py; the table is made in vrlf/scene/glyphs.py.

// The table between its entries. By hand: hardware's weights are too coarse for differences.
float sum_until(vec2 at) {
    ivec2 last = textureSize(print_sums, 0) - 1;
    at = clamp(at, vec2(0.0), vec2(last));
    ivec2 low = min(ivec2(at), last - 1);
    vec2 t = at - vec2(low);
    float a = texelFetch(print_sums, low, 0).r, b = texelFetch(print_sums, low + ivec2(1, 0), 0).r;
    float c = texelFetch(print_sums, low + ivec2(0, 1), 0).r, d = texelFetch(print_sums, low + 1, 0).r;
    return mix(mix(a, b, t.x), mix(c, d, t.x), t.y);
}

// Crow 1984: the mean over a box is four corners of the summed-area table.
float ink_over(vec2 place, vec2 box) {
    vec2 centre = place / TEXEL_M, half_box = max(0.5 * box / TEXEL_M, 0.5);
    vec2 low = centre - half_box, high = centre + half_box;
    float sum = sum_until(high) - sum_until(vec2(high.x, low.y))
              - sum_until(vec2(low.x, high.y)) + sum_until(low);
    return clamp(PRINT_MEAN + sum / (4.0 * half_box.x * half_box.y), 0.0, 1.0);
}
