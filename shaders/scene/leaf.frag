// Shades a leaf from both sides: what the sun sends through it is yellower.
//
// Writes: light (linear).

#include "block/Scene"

in vec3 position;
in vec3 normal;
in vec2 blade;
in vec2 extent;
flat in vec3 tint;
flat in float open_sky;

out vec4 light;

#include "scene/noise.glsl"
#include "scene/light.glsl"

// The midrib and the side veins that leave it forward.
float veins(vec2 place) {
    float t = place.x, s = abs(place.y);
    float midrib = 1.0 - smoothstep(0.02, 0.06, s);
    float side = abs(fract((t - 0.25 * s) * 9.0) - 0.5) * 2.0;
    return max(midrib, 0.6 * smoothstep(0.86, 0.97, side) * (1.0 - s));
}

void main() {
    // A pixel sees either face; the one that it sees is lit from its own side.
    vec3 to_eye = normalize(eye.xyz - position);
    vec3 up = normalize(normal);
    up *= dot(up, to_eye) < 0.0 ? -1.0 : 1.0;
    vec2 place = blade * extent;
    float footprint = covered(place);
    float seen = 1.0 - smoothstep(0.002, 0.012, footprint);  // veins fade when a pixel holds many
    float n = pink(place * 40.0 + tint.rg * 700.0, footprint * 40.0, 0.95);
    vec3 albedo = tint * exp(0.16 * n) * (1.0 + 0.55 * seen * veins(blade));
    float sun = dappled(position, sunlight(position));
    vec3 shade = shaded(albedo, up, position, sun, open_sky, 0.5);
    float behind = max(-dot(up, to_sun.xyz), 0.0);
    shade += SUN * sun * behind * albedo * vec3(0.75, 0.80, 0.30);
    light = vec4(through_air(shade, position), 1.0);
}
