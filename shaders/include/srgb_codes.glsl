// Linear light to the nearest 8-bit sRGB code, exactly whatever a GPU's pow does.
//
// thresholds[k]: the least value that is shown as code k + 1; from 256 on, what the codes stand for.
// Twin: vrlf/reference/encode.py, where the thresholds come from too.

layout(std430, binding = 0) readonly buffer Thresholds { float thresholds[]; };

// Binary search among the 255 thresholds.
uint quantised(float value) {
    uint low = 0u;
    for (uint step_size = 128u; step_size > 0u; step_size >>= 1u) {
        uint next = low + step_size;
        if (next <= 255u && value >= thresholds[next - 1u]) low = next;
    }
    return low;
}

// A value that is no number is shown dark: never a flash in a headset.
float shown_level(float value) {
    return isnan(value) ? 0.0 : clamp(value, 0.0, 1.0);
}
