// Linear light to 8-bit sRGB, exactly: a code is the number of thresholds that a value reaches.
//
// Reads:  light (linear), thresholds[k]: the least value that is shown as k + 1.
// Writes: code (8-bit unsigned).
// Twin:   vrlf/reference/encode.py.

#include "block/Encode"
layout(local_size_x = GROUP_PX, local_size_y = GROUP_PX) in;

layout(binding = 0) uniform sampler2D light;
layout(binding = 0, rgba8ui) writeonly uniform uimage2D code;

#include "include/srgb_codes.glsl"

// O'Neill 2014, PCG-RXS-M-XS: a hash of well-mixed bits.
uint pcg(uint v) {
    uint state = v * 747796405u + 2891336453u;
    uint word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
    return (word >> 22u) ^ word;
}

// Uniform in [0, 1), fixed for a pixel and channel.
float noise_of(ivec2 pixel, int channel) {
    uint hash = pcg(uint(pixel.x) + pcg(uint(pixel.y) + pcg(uint(channel))));
    return float(hash >> 8u) / 16777216.0;
}

// Dither: between codes k and k + 1 the nearer one, in linear light, is the likelier.
uint dithered(float value, float noise) {
    uint below = quantised(value);
    // quantised() rounds; from the rounded code find the codes that enclose the value.
    float centre = thresholds[256u + below];
    if (value < centre && below > 0u) below -= 1u;
    if (below >= 255u) return 255u;
    float start = thresholds[256u + below];
    float end = thresholds[257u + below];
    return below + ((value - start) / (end - start) > noise ? 1u : 0u);
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (pixel.x >= size_px.x || pixel.y >= size_px.y) return;
    vec3 value = texelFetch(light, pixel, 0).rgb;
    uvec4 result = uvec4(0u, 0u, 0u, 255u);
    for (int c = 0; c < 3; c++) {
        float v = shown_level(value[c]);
        result[c] = dither != 0 ? dithered(v, noise_of(pixel, c)) : quantised(v);
    }
    imageStore(code, pixel, result);
}
