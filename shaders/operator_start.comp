// Where the solver starts: cold from the normalised backprojection, warm from the last frame.
//
//     c = P't / P'1 in bounds, t = black + (brightness - black) i, dark where no ray reaches
//
// Cold, all that is written is c. Warm, what the steps had added to the last frame's c is added
// to this one's, as far as the picture still stands where it stood: where c did not change,
// all of it, momentum too; where it changed much, nothing.
//
// Reads:  light (P'i of the target i), reached (P'1); WARM also before (the last frame's c).
// Writes: begun (c); shown, sought, stepped and ahead (see operator_step.comp).
// Twin:   vrlf/reference/optimal.py (cold).
//
// Defines: WARM 1 after another frame with the same tables; NEAR, how far a change is looked for.

#include "block/Start"
layout(local_size_x = GROUP_PX, local_size_y = GROUP_PX) in;

layout(binding = 0) uniform sampler2D light;
layout(binding = 1) uniform sampler2D reached;
layout(binding = 2) uniform sampler2D before;
layout(binding = 0, rgba32f) writeonly uniform image2D shown;
layout(binding = 1, rgba32f) uniform image2D stepped;
layout(binding = 2, rgba32f) uniform image2D ahead;
layout(binding = 3, rgba32f) writeonly uniform image2D begun;
layout(binding = 4, rgba16) writeonly uniform image2D sought;

#include "include/quotient.glsl"

vec3 backprojected(ivec2 pixel) {
    vec3 reach = texelFetch(reached, pixel, 0).rgb;
    // P't, so that a pixel without rays stays dark whatever the black level.
    vec3 back = black_level * reach + (brightness - black_level) * texelFetch(light, pixel, 0).rgb;
    return clamp(where_reached(back, reach, reach), 0.0, 1.0);
}

#if WARM
// How much of what was added is kept: by how much c changed, mean square, about the pixel.
float kept_share(ivec2 pixel) {
    float change = 0.0;
    for (int row = -NEAR; row <= NEAR; row++) {
        for (int column = -NEAR; column <= NEAR; column++) {
            ivec2 at = clamp(pixel + ivec2(column, row), ivec2(0), size_px - 1);
            vec3 moved = backprojected(at) - texelFetch(before, at, 0).rgb;
            change += dot(moved, moved);
        }
    }
    change /= 3.0 * float((2 * NEAR + 1) * (2 * NEAR + 1));
    return trust * trust / (trust * trust + change * change);
}
#endif

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (pixel.x >= size_px.x || pixel.y >= size_px.y) return;
    vec3 c = backprojected(pixel);
    // theta and gamma, see operator_step.comp.
    vec4 w = vec4(c, first_theta), z = vec4(c, 1.0);
#if WARM
    float share = kept_share(pixel);
    vec3 old = texelFetch(before, pixel, 0).rgb;
    w += share * (imageLoad(stepped, pixel) - vec4(old, first_theta));
    z += share * (imageLoad(ahead, pixel) - vec4(old, 1.0));
#endif
    imageStore(begun, pixel, vec4(c, 1.0));
    vec4 bounded = vec4(clamp(z.rgb, 0.0, 1.0), 1.0);
    imageStore(shown, pixel, bounded);
    imageStore(sought, pixel, bounded);
    imageStore(stepped, pixel, w);
    imageStore(ahead, pixel, z);
}
