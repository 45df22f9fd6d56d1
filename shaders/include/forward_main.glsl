// What the forward prefilter's programs begin and end with: all pixels or listed ones.
//
// Needs: forward_rays.glsl, image2D shown; the define LISTED; a layer of groups is an eye.

vec3 light_at(Pixel from);

#if LISTED
#include "include/listed.glsl"

void main() {
    int eye = int(gl_WorkGroupID.z);
    ivec2 at;
    if (!find_listed(eye, at)) return;
    Pixel from = pixel_at(at, eye);
    imageStore(shown, at, vec4(where_emitting(from, light_at(from)), 1.0));
}
#else
void main() {
    int eye = int(gl_WorkGroupID.z);
    ivec2 at = ivec2(gl_GlobalInvocationID.xy) + ivec2(first_column(eye), 0);
    Pixel from = pixel_at(at, eye);
    vec3 light = where_emitting(from, light_at(from));
    if (eye_of(at.x) != eye) light = vec3(0.0);
    if (is_written_by(at, eye)) imageStore(shown, at, vec4(light, 1.0));
}
#endif
