// A rectangle of a window: one picture, two with a divider between them, or their difference.
//
// Reads:  first, second (linear, on the panel's raster).
// Writes: canvas (sRGB codes; row 0 is the lowest, as OpenGL's windows have it).
// Twin:   vrlf/reference/show.py.
//
// Defines: BACKGROUND, LINE, GREY: sRGB codes of what is no picture.

#include "block/Show"
layout(local_size_x = GROUP_PX, local_size_y = GROUP_PX) in;

layout(binding = 0) uniform sampler2D first;
layout(binding = 1) uniform sampler2D second;
layout(binding = 0, rgba8) writeonly uniform image2D canvas;

#include "include/srgb_codes.glsl"
#include "include/viewport.glsl"

// The nearest pixel of the grid that is there; no pixel takes one of the other eye's.
ivec2 on_grid(ivec2 pixel, int stride) {
    int eye = eye_of(pixel.x);
    if (stride == 1 || eye == NO_EYE) return pixel;
    ivec2 corner = ivec2(first_column(eye), 0);
    ivec2 last = (view_px - 1) / stride * stride;
    return corner + min((pixel - corner + stride / 2) / stride * stride, last);
}

vec3 difference_at(ivec2 pixel) {
    vec3 a = texelFetch(first, on_grid(pixel, strides.x), 0).rgb;
    return abs(a - texelFetch(second, on_grid(pixel, strides.y), 0).rgb);
}

vec3 light_at(ivec2 pixel, bool is_second) {
    if (difference != 0) return difference_at(pixel);
    return is_second ? texelFetch(second, on_grid(pixel, strides.y), 0).rgb
                     : texelFetch(first, on_grid(pixel, strides.x), 0).rgb;
}

bool in_crop(ivec2 pixel) {
    return all(greaterThanEqual(pixel, crop_box.xy)) && all(lessThan(pixel, crop_box.xy + crop_box.zw));
}

// The mean over the picture's pixels that a window pixel covers, those beside the crop left out.
vec3 mean_over(vec2 from, vec2 to, bool is_second) {
    vec3 total = vec3(0.0);
    float area = 0.0;
    for (int y = int(floor(from.y)); float(y) < to.y; y++) {
        for (int x = int(floor(from.x)); float(x) < to.x; x++) {
            ivec2 pixel = ivec2(x, y);
            if (!in_crop(pixel)) continue;
            vec2 low = max(from, vec2(pixel)), high = min(to, vec2(pixel) + 1.0);
            float weight = max(high.x - low.x, 0.0) * max(high.y - low.y, 0.0);
            total += weight * light_at(pixel, is_second);
            area += weight;
        }
    }
    return total / max(area, 1e-12);
}

// Each colour where the panel emits it, as bright as the pixel's own value.
vec3 where_emitted(vec3 light, vec2 within) {
    for (int c = 0; c < 3; c++) {
        vec4 box = emitting[c];
        bool lit = all(greaterThanEqual(within, box.xy)) && all(lessThan(within, box.zw));
        if (!lit) light[c] = 0.0;
    }
    return light;
}

vec3 codes_at(ivec2 in_tile) {
    vec2 from = start_px + px_per_window_px * vec2(in_tile);
    vec2 middle = from + 0.5 * px_per_window_px;
    ivec2 pixel = ivec2(floor(middle));
    if (!in_crop(pixel)) return vec3(BACKGROUND);
    int column = window_box.x + in_tile.x;
    if (abs(column - divider) <= 1) return vec3(LINE);
    bool is_second = column >= divider;
    vec3 light = px_per_window_px > 1.0 ? mean_over(from, from + px_per_window_px, is_second)
                                        : light_at(pixel, is_second);
    if (subpixels != 0) light = where_emitted(light, middle - vec2(pixel));
    vec3 codes;
    for (int c = 0; c < 3; c++) codes[c] = float(quantised(shown_level(light[c])));
    return codes;
}

void main() {
    ivec2 in_tile = ivec2(gl_GlobalInvocationID.xy);
    if (in_tile.x >= window_box.z || in_tile.y >= window_box.w) return;
    ivec2 size = imageSize(canvas);
    ivec2 at = window_box.xy + in_tile;
    if (any(lessThan(at, ivec2(0))) || any(greaterThanEqual(at, size))) return;
    vec3 codes = floor(mix(codes_at(in_tile), vec3(GREY), fade) + 0.5);
    imageStore(canvas, ivec2(at.x, size.y - 1 - at.y), vec4(codes / 255.0, 1.0));
}
