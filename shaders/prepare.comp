// The target: each eye's picture fitted into its viewport.
//
// Reads:  pictures of the left and the right eye (linear, or sRGB encoded).
// Writes: target (linear, on the panel's raster).
// Twin:   vrlf/reference/prepare.py.

#include "block/Prepare"
layout(local_size_x = GROUP_PX, local_size_y = GROUP_PX) in;

layout(binding = 0) uniform sampler2D left_picture;
layout(binding = 1) uniform sampler2D right_picture;
layout(binding = 0, rgba32f) writeonly uniform image2D target;

#include "include/viewport.glsl"
#include "include/distortion.glsl"

// IEC 61966-2-1.
vec3 decoded(vec3 v) {
    if (encoded == 0) return v;
    return mix(pow((v + 0.055) / 1.055, vec3(2.4)), v / 12.92, lessThanEqual(v, vec3(0.04045)));
}

vec3 picture_texel(ivec2 at, int eye) {
    return decoded(eye == 0 ? texelFetch(left_picture, at, 0).rgb : texelFetch(right_picture, at, 0).rgb);
}

// Keys 1981, cubic convolution with a = -1/2.
float cubic(float x) {
    x = abs(x);
    if (x < 1.0) return (1.5 * x - 2.5) * x * x + 1.0;
    if (x < 2.0) return ((-0.5 * x + 2.5) * x - 4.0) * x + 2.0;
    return 0.0;
}

// Where the lens shows a place of the viewport, as a place of it.
vec2 place_as_seen(vec2 at, vec2 axis) {
    if (distortion == vec2(0.0)) return at;
    return axis + as_seen((at - axis) / px_per_slope) * px_per_slope;
}

// The picture at a place of it, over the area that one target pixel covers.
vec3 filtered(vec2 at, ivec2 size, vec2 source_px, int eye) {
    vec2 widen = max(source_px, 1.0);
    ivec2 low = max(ivec2(ceil(at - 0.5 - 2.0 * widen)), ivec2(0));
    ivec2 high = min(ivec2(floor(at - 0.5 + 2.0 * widen)), size - 1);
    vec3 total = vec3(0.0);
    float weight = 0.0;
    for (int row = low.y; row <= high.y; row++) {
        float across = cubic((float(row) + 0.5 - at.y) / widen.y);
        for (int column = low.x; column <= high.x; column++) {
            float w = across * cubic((float(column) + 0.5 - at.x) / widen.x);
            total += w * picture_texel(ivec2(column, row), eye);
            weight += w;
        }
    }
    // The kernel's lobes overshoot at edges; light is neither negative nor above full drive.
    return clamp(total / weight, 0.0, 1.0);
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (pixel.x >= panel_px.x || pixel.y >= panel_px.y) return;
    int eye = eye_of(pixel.x);
    vec3 light = vec3(0.0);
    if (eye != NO_EYE) {
        vec2 at = vec2(pixel - ivec2(first_column(eye), 0)) + 0.5;
        at = place_as_seen(at, axes_px[eye].xy);
        vec4 fit = fits[eye];  // where the picture starts in the viewport; its pixels per target pixel
        vec2 source = (at - fit.xy) * fit.zw;
        ivec2 size = picture_px[eye].xy;
        if (all(greaterThanEqual(source, vec2(0.0))) && all(lessThan(source, vec2(size)))) {
            light = filtered(source, size, fit.zw, eye);
        }
    }
    imageStore(target, pixel, vec4(light, 1.0));
}
