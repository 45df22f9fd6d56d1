// Darkens the listed pixels of the panel image.
//
// Reads:  which pixels to do.
// Writes: shown (the panel image, linear).
// A layer of groups is an eye.

#include "block/Forward"
layout(local_size_x = GROUP_PX, local_size_y = GROUP_PX) in;

layout(binding = 0, rgba32f) writeonly uniform image2D shown;

#include "include/listed.glsl"

void main() {
    ivec2 at;
    bool is_listed = find_listed(int(gl_WorkGroupID.z), at);
    if (is_listed && at.x < panel_px.x) imageStore(shown, at, vec4(0.0, 0.0, 0.0, 1.0));
}
