// One step of the bounded solver: down the gradient, ahead with momentum, into the bounds.
//
// Reads:  light (the residual P x - t), reached (P'1), curvature (P'P1); TOLERANT also varied (V x).
// Writes: shown (x, the panel image, in [0, 1] after every step), sought (x again, in 16 bits
//         for the next product), stepped (w) and ahead (z, x before it was bounded), each pixel
//         its own. The alphas of stepped and ahead keep POGM's theta and gamma: over frames each
//         pixel has a momentum of its own.
// Twin:   vrlf/reference/optimal.py. Taylor, Hendrickx & Glineur 2017, POGM, diagonal metric.
//
// Defines: as in include/table.glsl and include/gather.glsl; TOLERANT.

#include "block/Step"
layout(local_size_x = GROUP_LANES, local_size_y = GROUP_PX) in;

layout(binding = 0) uniform sampler2D light;
layout(binding = 1) uniform sampler2D reached;
layout(binding = 2) uniform sampler2D curvature;
#if TOLERANT
layout(binding = 3) uniform sampler2D varied;
#endif
layout(binding = 0, rgba32f) writeonly uniform image2D shown;
layout(binding = 1, rgba32f) uniform image2D stepped;
layout(binding = 2, rgba32f) uniform image2D ahead;
layout(binding = 3, rgba16) writeonly uniform image2D sought;

#include "include/viewport.glsl"
#include "include/table.glsl"
#include "include/gather.glsl"
#include "include/quotient.glsl"

void main() {
    ivec2 pixel = own_pixel();
    int eye = eye_at(pixel), lane = own_lane();
    vec3 slope = gathered_light(pixel, eye, lane);
    if (lane != 0 || eye == NO_EYE) return;
#if TOLERANT
    slope += texelFetch(varied, pixel, 0).rgb;
#endif
    vec3 down = where_reached(slope, texelFetch(curvature, pixel, 0).rgb,
                              texelFetch(reached, pixel, 0).rgb);
    vec4 w_before = imageLoad(stepped, pixel), z_before = imageLoad(ahead, pixel);
    vec3 x = clamp(z_before.rgb, 0.0, 1.0);
    float theta = w_before.a, gamma = z_before.a;
    float following = 0.5 + 0.5 * sqrt(1.0 + 4.0 * theta * theta);
    float inertia = (theta - 1.0) / following, overshoot = theta / following;
    vec3 w = x - down;
    vec3 z = w + inertia * (w - w_before.rgb) + overshoot * (w - x)
           + inertia / gamma * (z_before.rgb - x);
    vec4 bounded = vec4(clamp(z, 0.0, 1.0), 1.0);
    imageStore(shown, pixel, bounded);
    imageStore(sought, pixel, bounded);
    imageStore(stepped, pixel, vec4(w, min(following, most_theta)));
    imageStore(ahead, pixel, vec4(z, (2.0 * theta + following - 1.0) / following));
}
