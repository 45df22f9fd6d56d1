// A row of the table times a picture.
//
// Needs: viewport.glsl, table.glsl, sampler2D light, the buffers entries, starts, crossings.

vec3 gathered_light(ivec2 pixel, int eye) {
    vec4 crossed = crossings[pixel.x] + crossings[panel_px.x + pixel.y];
    Phase phase = phase_of(crossed.xy, eye);
    vec3 sum = vec3(0.0);
    for (int i = starts[phase.patch_row]; i < starts[phase.patch_row + 1]; i++) {
        Entry entry = entry_at(i, phase.corners);
        ivec2 at = pixel + entry.offset;
        if (in_viewport(at, eye)) sum += entry.weight * texelFetch(light, at, 0).rgb;
    }
    return sum;
}
