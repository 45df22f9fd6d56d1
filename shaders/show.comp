// A rectangle of a window: one picture, two with a divider between them, or their difference.
//
// Reads:  first, second (linear, on the panel's raster).
// Writes: canvas (sRGB codes; row 0 is the lowest, as OpenGL's windows have it).
// Twin:   vrlf/reference/show.py.
//
// Defines: BACKGROUND, LINE, GREY: sRGB codes of what is no picture;
//          PICTURES 1 one, 2 two beside a divider, 3 the difference of two;
//          TAPS pixels a side that a window pixel may cover, 1 where none is shrunk;
//          GRIDS 1 where not every pixel is there yet; SUBPIXELS 1 shows where colours are emitted;
//          PERIOD_X, PERIOD_Y as in include/period.glsl.

#include "block/Show"
layout(local_size_x = GROUP_PX, local_size_y = GROUP_PX) in;

layout(binding = 0) uniform sampler2D first;
layout(binding = 1) uniform sampler2D second;
layout(binding = 0, rgba8) writeonly uniform image2D canvas;

#include "include/srgb_codes.glsl"
#include "include/viewport.glsl"
#include "include/period.glsl"

// The nearest pixel of the grid that is there; no pixel takes one of the other eye's.
ivec2 on_grid(ivec2 pixel, int stride) {
#if GRIDS
    int eye = eye_of(pixel.x);
    if (stride == 1 || eye == NO_EYE) return pixel;
    ivec2 corner = ivec2(first_column(eye), 0);
    // Strides are powers of two: a mask takes the place of a division.
    ivec2 last = (view_px - 1) & -stride;
    return corner + min((pixel - corner + stride / 2) & -stride, last);
#else
    return pixel;
#endif
}

// As far as a panel can show it: what is no number is dark, never a flash in a headset.
vec3 level_of(vec3 light) {
    return clamp(mix(light, vec3(0.0), isnan(light)), 0.0, 1.0);
}

vec3 first_at(ivec2 pixel) {
    return level_of(texelFetch(first, on_grid(pixel, strides.x), 0).rgb);
}

vec3 second_at(ivec2 pixel) {
    return level_of(texelFetch(second, on_grid(pixel, strides.y), 0).rgb);
}

vec3 light_at(ivec2 pixel, bool is_second) {
#if PICTURES == 1
    return first_at(pixel);
#elif PICTURES == 2
    return is_second ? second_at(pixel) : first_at(pixel);
#else
    return abs(first_at(pixel) - second_at(pixel));
#endif
}

bool in_crop(ivec2 pixel) {
    return all(greaterThanEqual(pixel, crop_box.xy)) && all(lessThan(pixel, crop_box.xy + crop_box.zw));
}

// What a window pixel's interval from `from` on shares with a pixel of the crop.
float shared_with(float from, int pixel, int low, int end) {
    float share = min(from + px_per_window_px, float(pixel + 1)) - max(from, float(pixel));
    return pixel >= low && pixel < end ? max(share, 0.0) : 0.0;
}

// The mean over the picture's pixels that a window pixel covers, those beside the crop left out.
vec3 mean_over(vec2 from, bool is_second) {
    ivec2 corner = ivec2(floor(from)), end = crop_box.xy + crop_box.zw;
    vec3 total = vec3(0.0);
    float area = 0.0;
    for (int j = 0; j < TAPS; j++) {
        int row = corner.y + j;
        float along = shared_with(from.y, row, crop_box.y, end.y);
        for (int i = 0; i < TAPS; i++) {
            int column = corner.x + i;
            float weight = along * shared_with(from.x, column, crop_box.x, end.x);
            ivec2 pixel = clamp(ivec2(column, row), crop_box.xy, end - 1);
            total += weight * light_at(pixel, is_second);
            area += weight;
        }
    }
    return total / max(area, 1e-12);
}

// Each colour where the panel emits it, as bright as the pixel's own value.
vec3 where_emitted(vec3 light, ivec2 pixel, vec2 within) {
    int first = first_box(pixel);
    for (int c = 0; c < 3; c++) {
        vec4 box = emitting[first + c];
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
#if TAPS > 1
    vec3 light = mean_over(from, is_second);
#else
    vec3 light = light_at(pixel, is_second);
#endif
#if SUBPIXELS
    light = where_emitted(light, pixel, middle - vec2(pixel));
#endif
    return vec3(quantised(light.r), quantised(light.g), quantised(light.b));
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
