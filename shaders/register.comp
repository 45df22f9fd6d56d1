// The bare panel's image where the lens magnifies the colours differently: each colour shows what
// belongs where it is seen. What the forward prefilter does without an array.
//
// Reads:  target (what the eyes should perceive, linear).
// Writes: shown (the panel image, linear).
// Twin:   vrlf/reference/forward.py. Derivation: vrlf/optics/lateral.py.

#include "block/Register"
layout(local_size_x = GROUP_PX, local_size_y = GROUP_PX) in;

layout(binding = 0) uniform sampler2D target;
layout(binding = 0, rgba32f) writeonly uniform image2D shown;

#include "include/viewport.glsl"

float texel(ivec2 pixel, int eye, int colour) {
    int first = first_column(eye);
    pixel = clamp(pixel, ivec2(first, 0), ivec2(first + view_px.x - 1, view_px.y - 1));
    return texelFetch(target, pixel, 0)[colour];
}

// Bilinear between pixel centres, `off` pixels from one; the edge pixel goes on to the viewport's
// border, black beyond.
float read_at(ivec2 pixel, int eye, int colour, vec2 off) {
    vec2 border = vec2(pixel - ivec2(first_column(eye), 0)) + 0.5 + off;
    if (any(lessThan(border, vec2(0.0))) || any(greaterThan(border, vec2(view_px)))) return 0.0;
    vec2 part = off - floor(off);
    ivec2 corner = pixel + ivec2(floor(off));
    float upper = mix(texel(corner, eye, colour),
                      texel(corner + ivec2(1, 0), eye, colour), part.x);
    float lower = mix(texel(corner + ivec2(0, 1), eye, colour),
                      texel(corner + ivec2(1, 1), eye, colour), part.x);
    return mix(upper, lower, part.y);
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (pixel.x >= panel_px.x || pixel.y >= panel_px.y) return;
    int eye = eye_of(pixel.x);
    vec3 light = vec3(0.0);
    if (eye != NO_EYE) {
        vec2 centre = vec2(pixel - ivec2(first_column(eye), 0)) + 0.5 - lens_axes_px[eye].xy;
        for (int c = 0; c < 3; c++) {
            vec4 map = maps[3 * eye + c];
            light[c] = read_at(pixel, eye, c, map.x * centre + map.yz);
        }
    }
    imageStore(shown, pixel, vec4(light, 1.0));
}
