// A quotient where rays reach, 0 where none does.
//
// Needs of the block: float least, the share of a pixel's light below which it counts as dark.

vec3 where_reached(vec3 dividend, vec3 divisor, vec3 reach) {
    return mix(dividend / max(divisor, vec3(1e-12)), vec3(0.0), lessThan(reach, vec3(least)));
}
