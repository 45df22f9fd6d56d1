// Where the solver starts: the normalised backprojection.
//
// Reads:  light (P'i of the target i), reached (P'1).
// Writes: shown = stepped = ahead = P't / P'1 in bounds, t = black + (brightness - black) i,
//         dark where no ray reaches.
// Twin:   vrlf/reference/optimal.py.

#include "block/Start"
layout(local_size_x = GROUP_PX, local_size_y = GROUP_PX) in;

layout(binding = 0) uniform sampler2D light;
layout(binding = 1) uniform sampler2D reached;
layout(binding = 0, rgba32f) writeonly uniform image2D shown;
layout(binding = 1, rgba32f) writeonly uniform image2D stepped;
layout(binding = 2, rgba32f) writeonly uniform image2D ahead;

#include "include/quotient.glsl"

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (pixel.x >= size_px.x || pixel.y >= size_px.y) return;
    vec3 reach = texelFetch(reached, pixel, 0).rgb;
    // P't, so that a pixel without rays stays dark whatever the black level.
    vec3 back = black_level * reach + (brightness - black_level) * texelFetch(light, pixel, 0).rgb;
    vec4 start = vec4(clamp(where_reached(back, reach, reach), 0.0, 1.0), 1.0);
    imageStore(shown, pixel, start);
    imageStore(stepped, pixel, start);
    imageStore(ahead, pixel, start);
}
