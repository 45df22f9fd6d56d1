// A row of the table times a picture.
//
// Needs: viewport.glsl, table.glsl, sampler2D light.

vec3 gathered_light(ivec2 pixel, int eye) {
    Row row = row_of(pixel, eye);
    vec3 sum = vec3(0.0);
    for (int i = starts[row.index]; i < starts[row.index + 1]; i++) {
        Entry entry = entry_at(i, row);
        ivec2 at = pixel + entry.offset;
        if (in_viewport(at, eye)) sum += entry.weight * texelFetch(light, at, 0).rgb;
    }
    return sum;
}
