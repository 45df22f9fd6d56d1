// Where chief rays cross the lattice: what a pixel's column and its row contribute.
//
// Needs of the block: ivec2 panel_px; define VARYING.
// Twin: vrlf/optics/raster.py.

#if VARYING
// Cell coordinates where the pitch varies: rests, wholes; the first is a column's, the second a
// row's.
#define CROSSED_IN(table, pixel, eye) vec4( \
    table[(pixel).x].x, table[row_index(pixel, eye)].x, \
    table[(pixel).x].y, table[row_index(pixel, eye)].y)
// How they go on from there: a of both axes, b of both.
#define LAW_IN(table, pixel, eye) vec4( \
    table[(pixel).x].z, table[row_index(pixel, eye)].z, \
    table[(pixel).x].w, table[row_index(pixel, eye)].w)

int row_index(ivec2 pixel, int eye) {
    return panel_px.x + max(eye, 0) * panel_px.y + pixel.y;
}
#else
#define CROSSED_IN(table, pixel, eye) (table[(pixel).x] + table[panel_px.x + (pixel).y])
#define LAW_IN(table, pixel, eye) vec4(1.0, 1.0, 0.0, 0.0)
#endif
