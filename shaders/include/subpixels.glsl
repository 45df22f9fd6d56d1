// Where in a pixel each colour emits, and how strongly.
//
// Needs of the block: vec4 emitting[12] (left, top, right, bottom of each colour's rectangle in
// its pixel, three for each place of the period) and vec4 gain.
// Twin: vrlf/optics/subpixels.py; vrlf/reference/perceive.py, _emitting and _over_area.

#include "include/period.glsl"

// Emission at a place in a pixel of the panel, from the pixel's upper left corner; the mean of a
// white field is 1.
vec3 emission_at(ivec2 pixel, vec2 within) {
    int first = first_box(pixel);
    vec3 lit;
    for (int c = 0; c < 3; c++) {
        vec4 box = emitting[first + c];
        bool inside = within.x >= box.x && within.x < box.z && within.y >= box.y && within.y < box.w;
        lit[c] = inside ? gain[c] : 0.0;
    }
    return lit;
}

// What the interval [low, high], in pixels, shares with an emitting interval of one pixel.
float shared_length(float low, float high, float from, float to) {
    return max(min(min(high, 1.0), to) - max(max(low, 0.0), from), 0.0);
}

// The part of the mean over a square that one pixel's emission makes up; the square starts at
// `start`, from that pixel's upper left corner.
vec3 emission_over(ivec2 pixel, vec2 start, float side) {
    int first = first_box(pixel);
    vec2 end = start + side;
    vec3 area;
    for (int c = 0; c < 3; c++) {
        vec4 box = emitting[first + c];
        area[c] = shared_length(start.x, end.x, box.x, box.z)
                * shared_length(start.y, end.y, box.y, box.w);
    }
    return area * gain.rgb / (side * side);
}
