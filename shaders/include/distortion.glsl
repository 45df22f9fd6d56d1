// Where the headset's lens shows what.
//
// Needs of the block: vec2 distortion (k1, k2).
// Twin: vrlf/optics/distortion.py, where the way back is too.

// Brown 1966, radial terms: the lens shows panel slope r at r (1 + k1 r^2 + k2 r^4).
vec2 as_seen(vec2 slope) {
    float r2 = dot(slope, slope);
    return slope * (1.0 + r2 * (distortion.x + r2 * distortion.y));
}
