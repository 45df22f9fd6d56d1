// The operator or its adjoint, applied to a picture; less a target, if one is given.
//
// Reads:  light (on the panel's raster), target, the rows of the table.
// Writes: result = table * light - subtracted * target.
// Twin:   vrlf/reference/optimal.py.
//
// Defines: as in include/table.glsl and include/gather.glsl.

#include "block/Apply"
layout(local_size_x = GROUP_LANES, local_size_y = GROUP_PX) in;

layout(binding = 0) uniform sampler2D light;
layout(binding = 1) uniform sampler2D target;
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
        sum -= subtracted * (black_level + (brightness - black_level) * meant);
    }
    imageStore(result, pixel, vec4(sum, 1.0));
}
