// Where the headset's lens shows what.
//
// Needs of the block: vec2 distortion (k1, k2).
// Twin: vrlf/scene/camera.py, vrlf/reference/prepare.py, vrlf/reference/panorama.py.

// Brown 1966, radial terms: the lens shows panel slope r at r (1 + k1 r^2 + k2 r^4).
vec2 as_seen(vec2 slope) {
    float r2 = dot(slope, slope);
    return slope * (1.0 + r2 * (distortion.x + r2 * distortion.y));
}
