// Where the solver starts, and how far its steps may go.
//
// Reads:  light (P'i of the target i), reached (P'1), and curvature (P'P1).
// Writes: shown = ahead = P't / P'1 in bounds, with t = black + (brightness - black) i, dark
//         where no ray reaches; inverse = 1 / P'P1.
// Twin:   vrlf/reference/optimal.py.

#include "block/Start"
layout(local_size_x = GROUP_PX, local_size_y = GROUP_PX) in;

layout(binding = 0) uniform sampler2D light;
layout(binding = 1) uniform sampler2D reached;
layout(binding = 2) uniform sampler2D curvature;
layout(binding = 0, rgba32f) writeonly uniform image2D shown;
layout(binding = 1, rgba32f) writeonly uniform image2D ahead;
layout(binding = 2, rgba32f) writeonly uniform image2D inverse;

vec3 quotient(vec3 a, vec3 b) {
    return mix(a / max(b, least), vec3(0.0), lessThan(b, vec3(least)));
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (pixel.x >= size_px.x || pixel.y >= size_px.y) return;
    vec3 reach = texelFetch(reached, pixel, 0).rgb;
    vec3 back = quotient(texelFetch(light, pixel, 0).rgb, reach);
    back = black_level + (brightness - black_level) * back;
    vec3 start = mix(clamp(back, 0.0, 1.0), vec3(0.0), lessThan(reach, vec3(least)));
    imageStore(shown, pixel, vec4(start, 1.0));
    imageStore(ahead, pixel, vec4(start, 1.0));
    imageStore(inverse, pixel, vec4(quotient(vec3(1.0), texelFetch(curvature, pixel, 0).rgb), 1.0));
}
