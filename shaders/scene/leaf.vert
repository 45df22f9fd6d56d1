// Leaves, blades of grass and petals: one folded blade, drawn once an instance.

#include "block/Scene"

in vec2 in_blade;    // along the midrib 0 to 1, across it -1, 0 or 1
in vec3 in_origin;   // where the stalk ends, metres
in vec3 in_along;    // to the tip, metres
in vec3 in_across;   // half the widest width, metres
in vec3 in_tint;     // albedo
in vec4 in_traits;   // taper (0 leaf, 1 grass), bend, share of skylight, sway in metres

out vec3 position;
out vec3 normal;
out vec2 blade;
out vec2 extent;
flat out vec3 tint;
flat out float open_sky;

// Half the width along a leaf: round at the stalk, pointed at the tip; grass only tapers.
float outline(float t, float taper) {
    float leaf = 1.5 * sqrt(t) * (1.0 - t) * (1.0 + t * 0.9);
    return mix(leaf, 1.0 - t * t, taper);
}

// Wind: each blade swings by itself, a gust runs over all of them.
vec3 wind(vec3 origin, float sway) {
    float phase = 1.7 * origin.x + 2.3 * origin.z + 41.0 * in_tint.g;
    return sway * vec3(sin(1.9 * time_s + phase), 0.0, 0.6 * sin(1.3 * time_s + 1.7 * phase));
}

void main() {
    float t = in_blade.x, s = in_blade.y;
    vec3 face = normalize(cross(in_along, in_across));
    float span = length(in_along);
    float bend = in_traits.y;
    vec3 across = in_across * (s * outline(t, in_traits.x));
    // The tip hangs by bend * span; the two halves fold up from the midrib.
    vec3 fold = face * (0.35 * length(across));
    position = in_origin + in_along * t + across + fold;
    position.y -= bend * span * t * t;
    position += wind(in_origin, in_traits.w) * t;
    vec3 slope = in_along - vec3(0.0, 2.0 * bend * span * t, 0.0);
    normal = normalize(cross(slope, in_across) - 0.35 * s * span * in_across);
    blade = in_blade;
    extent = vec2(span, 2.0 * length(in_across));
    tint = in_tint;
    open_sky = in_traits.z;
    gl_Position = clip_from_world * vec4(position, 1.0);
}
