// One step of the bounded solver: down the gradient, into the bounds, and on with momentum.
//
// Reads:  light (the residual P y - t), inverse (1 / P'P1, 0 where no ray reaches).
// Writes: shown (the panel image, in [0, 1] after every step) and ahead (where the next
//         gradient is taken), each pixel its own.
// Twin:   vrlf/reference/optimal.py. Beck & Teboulle 2009, FISTA, with a diagonal metric.

#include "block/Step"
layout(local_size_x = GROUP_PX, local_size_y = GROUP_PX) in;

layout(binding = 0) uniform sampler2D light;
layout(binding = 1) uniform sampler2D inverse;
layout(binding = 0, rgba32f) uniform image2D shown;
layout(binding = 1, rgba32f) uniform image2D ahead;

layout(std430, binding = 0) readonly buffer Entries { uvec2 entries[]; };
layout(std430, binding = 1) readonly buffer Starts { int starts[]; };
layout(std430, binding = 2) readonly buffer Crossings { vec4 crossings[]; };

#include "include/viewport.glsl"
vec2 nearest_cell(vec2 q) { return floor(q + 0.5); }
#include "include/table.glsl"
#include "include/gather.glsl"

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (pixel.x >= panel_px.x || pixel.y >= panel_px.y) return;
    int eye = eye_of(pixel.x);
    if (eye == NO_EYE) return;
    vec3 gradient = gathered_light(pixel, eye);
    vec3 step_size = texelFetch(inverse, pixel, 0).rgb;
    vec3 before = imageLoad(shown, pixel).rgb;
    vec3 next = clamp(imageLoad(ahead, pixel).rgb - step_size * gradient, 0.0, 1.0);
    imageStore(shown, pixel, vec4(next, 1.0));
    imageStore(ahead, pixel, vec4(next + momentum * (next - before), 1.0));
}
