// The target sharpened before the forward prefilter: a small convolution, other for each eye.
//
// Reads:  target (linear), taps[eye][row][column]: what each colour of the target counts there.
// Writes: sharpened, within 0 and 1. Each eye reads its own viewport alone, edges repeated.
// Twin:   vrlf/reference/sharpen.py. The taps come from vrlf/solve/wiener.py.
//
// Defines: RADIUS, taps to each side. A group's pixels share what they read.

#include "block/Sharpen"
layout(local_size_x = GROUP_PX, local_size_y = GROUP_PX) in;

layout(binding = 0) uniform sampler2D target;
layout(binding = 0, rgba32f) writeonly uniform image2D sharpened;

layout(std430, binding = 0) readonly buffer Taps { vec4 taps[]; };

#include "include/viewport.glsl"

const int SIDE = 2 * RADIUS + 1;
// Each invocation makes PER_ROW neighbours of a row: a tap and a texel then serve all of them.
const int PER_ROW = 4;
const int LINE = SIDE + PER_ROW - 1;  // taps of a row, zeros after them
const ivec2 GROUP = ivec2(GROUP_PX * PER_ROW, GROUP_PX);
const ivec2 TILE = GROUP + 2 * RADIUS;
shared vec3 tile[TILE.x * TILE.y];

// The part of the viewport that the group's taps reach; `corner` is the group's own.
void read_tile(ivec2 corner, int eye) {
    ivec2 from = corner + shifts[eye].xy - RADIUS;
    for (int i = int(gl_LocalInvocationIndex); i < TILE.x * TILE.y; i += GROUP_PX * GROUP_PX) {
        ivec2 at = clamp(from + ivec2(i % TILE.x, i / TILE.x), ivec2(0), view_px - 1);
        tile[i] = texelFetch(target, at + ivec2(first_column(eye), 0), 0).rgb;
    }
}

// PER_ROW pixels, the first of them at `within` in the group.
vec3[PER_ROW] convolved(ivec2 within, int eye) {
    vec3 a = vec3(0.0), b = a, c = a, d = a;
    for (int row = 0; row < SIDE; row++) {
        int texel = (within.y + row) * TILE.x + within.x;
        int tap = (eye * SIDE + row) * LINE;
        // The taps that the texel finds in each of the four pixels.
        vec3 of_a = vec3(0.0), of_b = of_a, of_c = of_a, of_d = of_a;
        for (int column = 0; column < LINE; column++) {
            of_d = of_c;
            of_c = of_b;
            of_b = of_a;
            of_a = taps[tap + column].rgb;
            vec3 light = tile[texel + column];
            a += of_a * light;
            b += of_b * light;
            c += of_c * light;
            d += of_d * light;
        }
    }
    return vec3[PER_ROW](a, b, c, d);
}

void main() {
    int eye = int(gl_WorkGroupID.z);
    ivec2 corner = ivec2(gl_WorkGroupID.xy) * GROUP;
    read_tile(corner, eye);
    barrier();
    ivec2 within = ivec2(gl_LocalInvocationID.xy) * ivec2(PER_ROW, 1);
    ivec2 pixel = corner + within;
    if (pixel.y >= view_px.y) return;
    vec3 light[PER_ROW] = convolved(within, eye);
    for (int i = 0; i < PER_ROW && pixel.x + i < view_px.x; i++) {
        ivec2 at = pixel + ivec2(first_column(eye) + i, 0);
        imageStore(sharpened, at, vec4(clamp(light[i], 0.0, 1.0), 1.0));
    }
    // The middle column of an odd width is nobody's.
    if (eye == 0 && pixel.x == 0 && second_column > view_px.x) {
        imageStore(sharpened, ivec2(view_px.x, pixel.y), vec4(0.0, 0.0, 0.0, 1.0));
    }
}
