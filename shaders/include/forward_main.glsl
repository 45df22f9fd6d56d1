// What the forward prefilter's programs begin and end with: all pixels or listed ones.
//
// Needs: forward_rays.glsl, image2D shown; the define LISTED; a layer of groups is an eye.

#if LISTED
// How many of the left eye's and of the right eye's, then those: column + 65536 row.
layout(std430, binding = 4) readonly buffer Listed { uint listed[]; };
#endif

vec3 light_at(Pixel from);

#if LISTED
void main() {
    int eye = int(gl_WorkGroupID.z);
    uint group = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    uint index = group * uint(GROUP_PX * GROUP_PX) + gl_LocalInvocationIndex;
    if (index >= listed[eye]) return;
    uint place = listed[2u + (eye == 0 ? 0u : listed[0]) + index];
    ivec2 at = ivec2(place & 0xffffu, place >> 16);
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
