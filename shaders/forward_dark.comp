// Darkens the panel image, before listed pixels of it are written.
//
// Writes: shown (the panel image, linear).

#include "block/Forward"
layout(local_size_x = GROUP_PX, local_size_y = GROUP_PX) in;

layout(binding = 0, rgba32f) writeonly uniform image2D shown;

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (all(lessThan(at, panel_px))) imageStore(shown, at, vec4(0.0, 0.0, 0.0, 1.0));
}
