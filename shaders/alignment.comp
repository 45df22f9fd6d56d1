// Screens that show how array, panel and lenses stand to each other; see vrlf/optics/alignment.py.
//
// Reads:  crossings: cell coordinates of the pixels' chief rays at the array.
// Writes: panel (linear).
// Twin:   vrlf/reference/alignment.py.
//
// Defines: SCREEN 0, 1 fringes along the lattice's first or second axis, 2 pitch, 3 separation;
//          VARYING (include/crossings.glsl); and the sizes in millimetres.

#include "block/Alignment"
layout(local_size_x = GROUP_PX, local_size_y = GROUP_PX) in;

layout(binding = 0, rgba32f) writeonly uniform image2D panel;

layout(std430, binding = 2) readonly buffer Crossings { vec4 crossings[]; };

#include "include/viewport.glsl"
#include "include/crossings.glsl"

const float PI = 3.14159265358979;

// Moire verniers, King & Berry 1972: waves a little shorter than cells in one half, longer in the
// other. A whole number of cells changes no phase and is left out of the first term.
float fringes(ivec2 pixel, int eye, int axis) {
    vec4 crossed = CROSSED_IN(crossings, pixel, eye);
    float from_middle = crossed[axis] + (crossed[axis + 2] - middle_cells[eye][axis]);
    ivec2 in_view = pixel - ivec2(first_column(eye), 0);
    bool is_first = axis == 0 ? in_view.y < view_px.y / 2 : in_view.x < view_px.x / 2;
    float phase = crossed[axis] + (is_first ? from_middle : -from_middle) / fringe_cells;
    return 0.5 + 0.5 * cos(2.0 * PI * (phase - floor(phase)));
}

// Share of the interval [low, low + pixel) that lies in [from, to).
float share(float low, float from, float to) {
    return max(min(low + pixel_mm, to) - max(low, from), 0.0) / pixel_mm;
}

// Share of the pixel that lies in a rectangle about the origin.
float in_box(vec2 low, vec2 side) {
    return share(low.x, -0.5 * side.x, 0.5 * side.x) * share(low.y, -0.5 * side.y, 0.5 * side.y);
}

float outline(vec2 low, vec2 side, float line) {
    return in_box(low, side) - in_box(low, side - 2.0 * line);
}

// Ticks down from the middle line, at each millimetre from the panel's middle.
float ruler(vec2 low) {
    float total = 0.0;
    int first = int(floor(low.x - TICK_MM)), last = int(ceil(low.x + pixel_mm + TICK_MM));
    for (int k = first; k <= last; k++) {
        int number = abs(k);  // of a negative number GLSL leaves the remainder open
        float length_mm = number % 10 == 0 ? TICK_TEN_MM : number % 5 == 0 ? TICK_FIVE_MM : TICK_ONE_MM;
        float middle = float(k);
        total += share(low.x, middle - 0.5 * TICK_MM, middle + 0.5 * TICK_MM)
               * share(low.y, -length_mm, 0.0);
    }
    return total;
}

float nonius(vec2 low, int eye) {
    float across = share(low.x, -0.5 * NONIUS_MM, 0.5 * NONIUS_MM);
    return across * (eye == 0 ? share(low.y, NONIUS_FROM_MM, NONIUS_TO_MM)
                              : share(low.y, -NONIUS_TO_MM, -NONIUS_FROM_MM));
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (pixel.x >= panel_px.x || pixel.y >= panel_px.y) return;
    int eye = eye_of(pixel.x);
    // The pixel's lower left corner, from the panel's middle, x right and y up.
    vec2 low = pixel_mm * vec2(float(pixel.x) - 0.5 * float(panel_px.x),
                               0.5 * float(panel_px.y) - float(pixel.y) - 1.0);
    vec3 light = vec3(0.0);
#if SCREEN < 2
    // Green alone: lenslets would show each colour's stripe at a place of its own.
    if (eye != NO_EYE) light.g = fringes(pixel, eye, SCREEN);
#elif SCREEN == 2
    light = vec3(clamp(outline(low, vec2(CARD_X_MM, CARD_Y_MM), CARD_LINE_MM) + ruler(low), 0.0, 1.0));
#else
    if (eye != NO_EYE) {
        vec2 from_axis = low - axes_mm[eye].xy;
        light = vec3(outline(from_axis, vec2(FRAME_MM), FRAME_LINE_MM) + nonius(from_axis, eye));
    }
#endif
    imageStore(panel, pixel, vec4(light, 1.0));
}
