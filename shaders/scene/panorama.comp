// What both eyes see of the world all around: an equirectangular picture for each.
//
// Reads:  the panoramas of the left and the right eye (linear).
// Writes: target (linear, on the panel's raster).
// Twin:   vrlf/reference/panorama.py.

#include "block/Panorama"
layout(local_size_x = GROUP_PX, local_size_y = GROUP_PX) in;

layout(binding = 0) uniform sampler2D left_world;
layout(binding = 1) uniform sampler2D right_world;
layout(binding = 0, rgba32f) writeonly uniform image2D target;

#include "include/viewport.glsl"
#include "include/distortion.glsl"

const float PI = 3.14159265358979;

// Snyder 1987, 12, plate carree: the middle is straight ahead, right is right, up is up.
vec2 place_of(vec3 direction, vec2 size) {
    float longitude = atan(direction.x, -direction.z);
    float latitude = atan(direction.y, length(direction.xz));
    return vec2(longitude / (2.0 * PI) + 0.5, 0.5 - latitude / PI) * size;
}

// A texel, round the world: beyond a pole lies the other side's meridian.
vec3 texel_round(ivec2 at, ivec2 size, int eye) {
    if (at.y < 0 || at.y >= size.y) {
        at.y = at.y < 0 ? -1 - at.y : 2 * size.y - 1 - at.y;
        at.x += size.x / 2;
    }
    at.x = at.x - size.x * int(floor(float(at.x) / float(size.x)));
    return eye == 0 ? texelFetch(left_world, at, 0).rgb : texelFetch(right_world, at, 0).rgb;
}

vec3 bilinear(vec2 place, ivec2 size, int eye) {
    vec2 from_centres = place - 0.5;
    ivec2 corner = ivec2(floor(from_centres));
    vec2 part = from_centres - vec2(corner);
    vec3 above = mix(texel_round(corner, size, eye), texel_round(corner + ivec2(1, 0), size, eye), part.x);
    vec3 below = mix(texel_round(corner + ivec2(0, 1), size, eye),
                     texel_round(corner + ivec2(1, 1), size, eye), part.x);
    return mix(above, below, part.y);
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (pixel.x >= panel_px.x || pixel.y >= panel_px.y) return;
    int eye = eye_of(pixel.x);
    vec3 total = vec3(0.0);
    if (eye != NO_EYE) {
        vec2 corner = vec2(pixel - ivec2(first_column(eye), 0)) - axes_px[eye].xy;
        ivec2 size = textureSize(left_world, 0);
        for (int row = 0; row < samples; row++) {
            for (int column = 0; column < samples; column++) {
                vec2 at = corner + (vec2(column, row) + 0.5) / float(samples);
                vec2 slope = as_seen(vec2(at.x, -at.y) / px_per_slope);
                vec3 direction = slope.x * head_right.xyz + slope.y * head_up.xyz - head_back.xyz;
                total += bilinear(place_of(direction, vec2(size)), size, eye);
            }
        }
    }
    vec3 mean = total / float(samples * samples);
    imageStore(target, pixel, vec4(clamp(mean, 0.0, 1.0), 1.0));
}
