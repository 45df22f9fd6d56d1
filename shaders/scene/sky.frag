// The sky with clouds, and hills under it, all infinitely far.
//
// Writes: light (linear).

#include "block/Scene"

in vec3 direction;

out vec4 light;

#include "scene/noise.glsl"

const float CLOUD_PLANE = 0.9;

// Deep above, pale at the horizon.
vec3 clear_sky(float elevation) {
    return mix(vec3(0.60, 0.70, 0.80), vec3(0.13, 0.27, 0.58), pow(clamp(elevation, 0.0, 1.0), 0.55));
}

// Clouds on a plane overhead, warped by slower noise (Quilez 2002).
vec3 clouded(vec3 sky, vec2 p, float footprint, float elevation) {
    vec2 warp = vec2(noise(p * 0.8 + 3.0), noise(p * 0.8 + 9.0));
    float n = pink(p * 0.9 + 0.5 * warp, footprint * 0.9, 0.68);
    float cover = smoothstep(-0.25, 1.1, n) * smoothstep(0.0, 0.12, elevation);
    float thick = smoothstep(0.2, 1.9, n);
    vec3 cloud = mix(vec3(0.88, 0.88, 0.87), vec3(0.50, 0.52, 0.56), thick);
    return mix(sky, cloud, cover);
}

// A wooded ridge: the height of the horizon along the compass.
vec3 hills(vec3 ray, vec3 sky, float pixel) {
    float compass = atan(ray.x, -ray.z);
    float ridge = 0.045 + 0.030 * noise(vec2(compass * 2.5, 1.0))
                + 0.005 * pink(vec2(compass * 16.0, 7.0), pixel * 16.0, 0.75);
    float under = smoothstep(-pixel, pixel, ridge - ray.y);
    float woods = pink(vec2(compass, ray.y * 2.2) * 26.0, pixel * 40.0, 0.95);
    vec3 green = vec3(0.105, 0.15, 0.13) * exp(0.22 * woods);
    return mix(sky, mix(green, vec3(0.36, 0.44, 0.52), 0.35), under);
}

void main() {
    vec3 ray = normalize(direction);
    float elevation = max(ray.y, 0.0);
    vec2 p = ray.xz / (elevation + 0.16) * CLOUD_PLANE + vec2(0.012, 0.004) * time_s;
    float pixel = covered(ray.xy);
    vec3 sky = clouded(clear_sky(elevation), p, covered(p), elevation);
    light = vec4(hills(ray, sky, pixel), 1.0);
}
