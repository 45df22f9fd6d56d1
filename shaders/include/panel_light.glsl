// The light of the panel's pixels.
//
// Needs: viewport.glsl, sampler2D panel.
// Twin: vrlf/reference/perceive.py, texels.

vec3 texel(ivec2 pixel, int eye) {
    return in_viewport(pixel, eye) ? texelFetch(panel, pixel, 0).rgb : vec3(0.0);
}
