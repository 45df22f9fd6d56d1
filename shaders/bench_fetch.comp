// Many texels fetched from a texture that stays in the nearest cache: how fast texels come.
//
// Reads:  source, a small texture, `fetches` texels for each pixel of the result, by rows from
//         the pixel's own place on: neighbours fetch neighbours, as the passes do.
// Writes: sums, what was fetched, added up (so that no fetch can be left out).
// Twin:   tests/test_studies_limits.py adds up the same texels.
// Driven by vrlf/studies/limits.py.

#include "block/BenchProbe"
layout(local_size_x = GROUP_PX, local_size_y = GROUP_PX) in;

layout(binding = 0) uniform sampler2D source;
layout(binding = 0, rgba32f) writeonly uniform image2D sums;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (pixel.x >= size_px.x || pixel.y >= size_px.y) return;
    vec4 sum = vec4(0.0);
    // SOURCE_PX is a power of two: the mask keeps the place inside at the cost of one bit.
    for (int n = 0; n < fetches; n++) {
        ivec2 place = (pixel + ivec2(n, n / SOURCE_PX)) & (SOURCE_PX - 1);
        sum += texelFetch(source, place, 0);
    }
    imageStore(sums, pixel, sum);
}
