// Sums over each eye's pixels inside its border: what tells a perceived picture from the target.
//
// Reads:  target, seen (linear, on the panel's raster).
// Writes: partial[eye][group]: with t the target and d = seen - t, over all three colours,
//         the sums of t t, t d and d d of the pixels that the group looked at.
// Twin:   vrlf/reference/squares.py.
//
// Defines: GROUPS for each eye; GROUP_PX as everywhere.

#include "block/Squares"
layout(local_size_x = GROUP_PX, local_size_y = GROUP_PX) in;

layout(binding = 0) uniform sampler2D target;
layout(binding = 1) uniform sampler2D seen;

layout(std430, binding = 0) writeonly buffer Partial { vec4 partial[]; };

#include "include/viewport.glsl"

const int THREADS = GROUP_PX * GROUP_PX;
shared vec3 sums[THREADS];

// Every GROUPS-th of the inner rows; neighbouring invocations read neighbouring pixels.
vec3 summed(int eye, int group, int thread) {
    int border = borders[eye];
    ivec2 end = view_px - border;
    vec3 total = vec3(0.0);
    for (int row = border + group; row < end.y; row += GROUPS) {
        for (int column = border + thread; column < end.x; column += THREADS) {
            ivec2 pixel = ivec2(first_column(eye) + column, row);
            vec3 t = texelFetch(target, pixel, 0).rgb;
            vec3 d = texelFetch(seen, pixel, 0).rgb - t;
            total += vec3(dot(t, t), dot(t, d), dot(d, d));
        }
    }
    return total;
}

void main() {
    int eye = int(gl_WorkGroupID.z), group = int(gl_WorkGroupID.x);
    int thread = int(gl_LocalInvocationIndex);
    sums[thread] = summed(eye, group, thread);
    barrier();
    for (int half_of = THREADS / 2; half_of > 0; half_of /= 2) {
        if (thread < half_of) sums[thread] += sums[thread + half_of];
        barrier();
    }
    if (thread == 0) partial[eye * GROUPS + group] = vec4(sums[0], 0.0);
}
