// The finished view of an eye: the mean over each pixel's samples, at the slopes it is seen at.
//
// Reads:  canvas (linear; row 0 is the lowest), drawn over the seen frustum.
// Writes: target, the eye's viewport of it (linear, 0 to 1, row 0 at the top), and behind the left
//         eye's the column that is nobody's.
// Twin:   resolved_by_hand in tests/test_scene_drawing.py.

#include "block/Resolve"
layout(local_size_x = GROUP_PX, local_size_y = GROUP_PX) in;

layout(binding = 0) uniform sampler2D canvas;
layout(binding = 0, rgba32f) writeonly uniform image2D target;

#include "include/distortion.glsl"

vec3 sample_at(vec2 in_view) {
    vec2 panel = mix(panel_slopes.xw, panel_slopes.zy, in_view);  // down from the top
    vec2 place = (as_seen(panel) - seen_slopes.xy) / (seen_slopes.zw - seen_slopes.xy);
    ivec2 size = textureSize(canvas, 0);
    return texelFetch(canvas, clamp(ivec2(floor(place * vec2(size))), ivec2(0), size - 1), 0).rgb;
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (pixel.x >= view_px.x + nobodys || pixel.y >= view_px.y) return;
    if (pixel.x >= view_px.x) {
        imageStore(target, pixel, vec4(0.0, 0.0, 0.0, 1.0));
        return;
    }
    vec3 total = vec3(0.0);
    for (int row = 0; row < samples; row++) {
        for (int column = 0; column < samples; column++) {
            vec2 at = vec2(pixel) + (vec2(column, row) + 0.5) / float(samples);
            total += sample_at(at / vec2(view_px));
        }
    }
    vec3 mean = exposure * total / float(samples * samples);
    mean = mix(mean, vec3(0.0), isnan(mean));
    imageStore(target, pixel + ivec2(first_column, 0), vec4(clamp(mean, 0.0, 1.0), 1.0));
}
