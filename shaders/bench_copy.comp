// A plain copy of rgba32f pixels: how fast anything could move them.
//
// Reads:  source, a pixel each. Writes: copied, the same pixel. 32 bytes a pixel in all.
// Twin:   none is needed, the result is the source: tests/test_studies_limits.py.
// Driven by vrlf/studies/limits.py.

#include "block/BenchProbe"
layout(local_size_x = GROUP_PX, local_size_y = GROUP_PX) in;

layout(binding = 0) uniform sampler2D source;
layout(binding = 0, rgba32f) writeonly uniform image2D copied;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (pixel.x >= size_px.x || pixel.y >= size_px.y) return;
    imageStore(copied, pixel, texelFetch(source, pixel, 0));
}
