// The operator or its adjoint, applied to a picture; less a target, if one is given.
//
// Reads:  light (on the panel's raster), target, the rows of the table.
// Writes: result = table * light - subtracted * target.
// Twin:   vrlf/reference/optimal.py.
//
// Defines: as in include/table.glsl.

#include "block/Apply"
layout(local_size_x = GROUP_PX, local_size_y = GROUP_PX) in;

layout(binding = 0) uniform sampler2D light;
layout(binding = 1) uniform sampler2D target;
layout(binding = 0, rgba32f) writeonly uniform image2D result;

#include "include/viewport.glsl"
#include "include/table.glsl"
#include "include/gather.glsl"

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (pixel.x >= panel_px.x || pixel.y >= panel_px.y) return;
    int eye = eye_of(pixel.x);
    vec3 sum = vec3(0.0);
    if (eye != NO_EYE) {
        sum = gathered_light(pixel, eye);
        if (subtracted != 0.0) {
            vec3 meant = texelFetch(target, pixel, 0).rgb;
            sum -= subtracted * (black_level + (brightness - black_level) * meant);
        }
    }
    imageStore(result, pixel, vec4(sum, 1.0));
}
