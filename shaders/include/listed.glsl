// Which pixel of a list an invocation does; a layer of groups is an eye.
//
// Twin: PixelList of vrlf/passes/forward_lists.py.

// How many of the left eye's and of the right eye's, then those: column + 65536 row.
layout(std430, binding = 4) readonly buffer Listed { uint listed[]; };

// False beyond the list's end.
bool find_listed(int eye, out ivec2 at) {
    uint group = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    uint index = group * uint(GROUP_PX * GROUP_PX) + gl_LocalInvocationIndex;
    at = ivec2(0);
    if (index >= listed[eye]) return false;
    uint place = listed[2u + (eye == 0 ? 0u : listed[0]) + index];
    at = ivec2(place & 0xffffu, place >> 16);
    return true;
}
