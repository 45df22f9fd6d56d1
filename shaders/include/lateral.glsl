// Colours that the headset's lens magnifies differently: where each crosses the array, and how far
// from its pixel it lands.
//
// Defines: LATERAL 0 where all colours are magnified alike; then nothing here costs anything.
// Beside a pitch that varies (VARYING) rigs with lateral colour are refused.
// Needs of the block: LATERAL_FIELDS of vrlf/passes/fields.py; of the shader: the buffer crossings,
// viewport.glsl.
// Twin: vrlf/reference/perceive.py, vrlf/reference/forward.py. Derivation: vrlf/optics/bench.py.

#include "include/crossings.glsl"

// Where a pixel's ray crosses the array, in cells: colour after colour, columns, then rows.
vec4 crossing_of(ivec2 pixel, int eye, int colour) {
#if LATERAL
    int first = colour * (panel_px.x + panel_px.y);
    return crossings[first + pixel.x] + crossings[first + panel_px.x + pixel.y];
#else
    return CROSSED_IN(crossings, pixel, eye);
#endif
}

#if LATERAL
// How far the magnification moves a pixel's centre, in pixels: right and down, from the axis.
vec2 lateral_of(ivec2 pixel, int eye, int colour) {
    vec2 centre = vec2(pixel - ivec2(first_column(eye), 0)) + 0.5;
    return magnified[colour].x * (centre - lens_axes_px[eye].xy);
}
#endif
