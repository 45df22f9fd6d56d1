// The operator or its adjoint, applied to a picture; less a target, if one is given.
//
// Reads:  light (on the panel's raster), target, the rows of the table; SLOPE also reached (P'1).
// Writes: result = table * light - subtracted * target. With SLOPE the table is P'P and target
//         P' of the picture: the result is the slope of the squared error.
// Twin:   vrlf/reference/optimal.py.
//
// Defines: as in include/table.glsl and include/gather.glsl; SLOPE.

#include "block/Apply"
layout(local_size_x = GROUP_LANES, local_size_y = GROUP_PX) in;

layout(binding = 0) uniform sampler2D light;
layout(binding = 1) uniform sampler2D target;
#if SLOPE
layout(binding = 2) uniform sampler2D reached;
#endif
layout(binding = 0) writeonly uniform image2D result;  // of whatever floats

#include "include/viewport.glsl"
#include "include/table.glsl"
#include "include/gather.glsl"

void main() {
    ivec2 pixel = own_pixel();
    int eye = eye_at(pixel), lane = own_lane();
    vec3 sum = gathered_light(pixel, eye, lane);
    if (lane != 0 || pixel.x >= panel_px.x || pixel.y >= panel_px.y) return;
    if (eye != NO_EYE && subtracted != 0.0) {
        vec3 meant = texelFetch(target, pixel, 0).rgb;
#if SLOPE
        vec3 ground = texelFetch(reached, pixel, 0).rgb;
#else
        vec3 ground = vec3(1.0);
#endif
        sum -= subtracted * (black_level * ground + (brightness - black_level) * meant);
    }
    imageStore(result, pixel, vec4(sum, 1.0));
}
