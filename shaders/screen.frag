// A picture of the window's size, pixel for pixel.
//
// Reads:  canvas (sRGB codes; row 0 is the lowest, as in the window).
// Writes: the window.

layout(binding = 0) uniform sampler2D canvas;

out vec4 code;

void main() {
    code = vec4(texelFetch(canvas, ivec2(gl_FragCoord.xy), 0).rgb, 1.0);
}
