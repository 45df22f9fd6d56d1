// Surfaces of a glTF scene: a sun, a sky above and a ground below.
//
// Reads:  base_colour (sRGB, decoded by the sampler; white where there is no picture).
// Writes: canvas (linear).

#include "block/Model"

layout(binding = 0) uniform sampler2D base_colour;

in vec3 position;
in vec3 normal;
in vec2 uv;
in vec4 tint;
out vec4 light;

const vec3 SUN = vec3(0.85, 0.80, 0.72);
const vec3 SKY = vec3(0.34, 0.38, 0.44);
const vec3 GROUND = vec3(0.16, 0.15, 0.13);

// Schlick 1994.
vec3 fresnel(vec3 straight_on, float cosine) {
    return straight_on + (1.0 - straight_on) * pow(1.0 - clamp(cosine, 0.0, 1.0), 5.0);
}

// Blinn 1977; the exponent of a roughness by Karis 2013: 2 / roughness^4 - 2.
float highlight(float cosine, float roughness) {
    float rough = max(roughness, 0.1);
    float exponent = max(2.0 / (rough * rough * rough * rough) - 2.0, 1.0);
    return pow(max(cosine, 0.0), exponent) * (exponent + 8.0) / 25.0;
}

vec3 around(vec3 direction) {
    return mix(GROUND, SKY, 0.5 + 0.5 * direction.y);
}

void main() {
    vec4 base = texture(base_colour, uv) * colour * tint;
    if (base.a < cutoff) discard;
    vec3 to_eye = normalize(eye.xyz - position);
    vec3 n = normal * inversesqrt(max(dot(normal, normal), 1e-12));
    if (dot(n, to_eye) < 0.0) n = -n;  // seen from behind: both sides are the same surface
    float facing = max(dot(n, to_sun.xyz), 0.0);
    vec3 mirrored = mix(vec3(0.04), base.rgb, metallic);
    vec3 matte = base.rgb * (1.0 - metallic);
    vec3 middle = normalize(to_sun.xyz + to_eye);
    vec3 glint = fresnel(mirrored, dot(middle, to_eye)) * highlight(dot(n, middle), roughness);
    vec3 sheen = fresnel(mirrored, dot(n, to_eye)) * around(reflect(-to_eye, n));
    light = vec4(matte * (SUN * facing + around(n)) + (SUN * facing) * glint + sheen, 1.0);
}
