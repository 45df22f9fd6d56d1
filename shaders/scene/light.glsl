// Sun, sky and the shade of crowns.
//
// Needs of the block: vec4 eye, vec4 to_sun, vec4 crowns[], vec4 crown_radii[]; of the
// defines: CROWNS; and noise.glsl.

const vec3 SUN = vec3(2.15, 1.95, 1.60);
const vec3 SKY = vec3(0.32, 0.40, 0.52);
const vec3 BOUNCE = vec3(0.16, 0.16, 0.10);
const vec3 HAZE = vec3(0.50, 0.60, 0.70);
const float HAZE_M = 160.0;

// The stretch of a ray that lies in an ellipsoid (a unit sphere in scaled space), in metres.
float chord_m(vec3 from, vec3 direction, vec3 centre, vec3 radii) {
    vec3 o = (from - centre) / radii, d = direction / radii;
    float a = dot(d, d), b = dot(o, d), c = dot(o, o) - 1.0;
    float root = b * b - a * c;
    if (root <= 0.0) return 0.0;
    root = sqrt(root);
    return max(0.0, (root - b) / a - max(0.0, (-root - b) / a));
}

// Beer 1852 and Lambert 1760: what foliage of so much optical depth lets through of the sun.
float sunlight(vec3 position) {
    float depth = 0.0;
    for (int i = 0; i < CROWNS; i++) {
        depth += crowns[i].w * chord_m(position, to_sun.xyz, crowns[i].xyz, crown_radii[i].xyz);
    }
    return exp(-depth);
}

// Flecks of sun: the same mean light, but let through in spots (gaps seen along the sun).
float dappled(vec3 position, float through) {
    vec3 along = position - to_sun.xyz * (position.y / to_sun.y);
    float gap = 0.5 + 0.5 * noise(along.xz * 9.0) + 0.25 * noise(along.xz * 23.0);
    float edge = 1.0 - through;
    return through > 0.98 ? through : smoothstep(edge - 0.25, edge + 0.25, gap);
}

// Blinn 1977: the highlight of a surface whose roughness is in the exponent.
float highlight(vec3 normal, vec3 to_eye, float exponent) {
    vec3 middle = normalize(to_sun.xyz + to_eye);
    return pow(max(dot(normal, middle), 0.0), exponent) * (exponent + 8.0) / 25.0;
}

// Schlick 1994: more is mirrored at a grazing glance.
float fresnel(float cosine) {
    return 0.04 + 0.96 * pow(1.0 - clamp(cosine, 0.0, 1.0), 5.0);
}

// Light from above and from below onto a surface that faces ``normal``.
vec3 ambient(vec3 normal) {
    return mix(BOUNCE, SKY, 0.5 + 0.5 * normal.y);
}

// Lambert 1760, with a highlight of strength ``gloss``.
vec3 shaded(vec3 albedo, vec3 normal, vec3 position, float sun, float open_sky, float gloss) {
    vec3 to_eye = normalize(eye.xyz - position);
    float facing = max(dot(normal, to_sun.xyz), 0.0);
    vec3 light = albedo * (SUN * facing * sun + ambient(normal) * open_sky);
    float mirrored = gloss * fresnel(dot(normal, to_eye));
    return light + mirrored * (SUN * sun * facing * highlight(normal, to_eye, 40.0) + SKY * open_sky);
}

// Koschmieder 1924: air veils what is far.
vec3 through_air(vec3 light, vec3 position) {
    return mix(HAZE, light, exp(-distance(eye.xyz, position) / HAZE_M));
}
