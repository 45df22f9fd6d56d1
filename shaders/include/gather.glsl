// A row of the table times a picture.
//
// LANES invocations share a pixel: they read pairs that lie side by side, each every LANES-th,
// and the first adds up what they found. All of a group must come here, those beyond the panel too.
//
// Defines: LANES; GROUP_LANES, LANES times GROUP_PX, the width of a group.
// Needs: viewport.glsl, table.glsl, sampler2D light.

#if LANES > 1
shared vec3 found[GROUP_LANES * GROUP_PX];
#endif

ivec2 own_pixel() {
    return ivec2(int(gl_GlobalInvocationID.x) / LANES, int(gl_GlobalInvocationID.y));
}

int own_lane() {
    return int(gl_GlobalInvocationID.x) % LANES;
}

// Whose the pixel is, and NO_EYE beyond the panel.
int eye_at(ivec2 pixel) {
    if (pixel.x >= panel_px.x || pixel.y >= panel_px.y) return NO_EYE;
    return eye_of(pixel.x);
}

// Fetched wherever it is, and then not counted: fetches wait for nothing but their offsets.
vec3 seen_by(ivec2 pixel, int eye, uvec2 entry) {
    ivec2 at = pixel + offset_in(entry.x);
    vec3 seen = weight_in(entry.y) * texelFetch(light, at, 0).rgb;
#if SIGNED
    seen *= sign_in(entry.x);
#endif
    return in_viewport(at, eye) ? seen : vec3(0.0);
}

vec3 own_part(ivec2 pixel, int eye, int lane) {
    if (eye == NO_EYE) return vec3(0.0);
    int row = row_of(pixel, eye), end = starts[row + 1];
    vec3 sum = vec3(0.0);
    for (int i = starts[row] + lane; i < end; i += LANES) {
        uvec4 pair = entries[i];
        sum += seen_by(pixel, eye, pair.xy) + seen_by(pixel, eye, pair.zw);
    }
    return sum;
}

// Whole in lane 0.
vec3 gathered_light(ivec2 pixel, int eye, int lane) {
    vec3 sum = own_part(pixel, eye, lane);
#if LANES > 1
    int own = int(gl_LocalInvocationIndex);
    found[own] = sum;
    barrier();
    if (lane == 0) {
        for (int other = 1; other < LANES; other++) sum += found[own + other];
    }
#endif
    return sum;
}
