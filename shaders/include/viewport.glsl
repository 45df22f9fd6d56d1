// Which eye sees a column, and what it may fetch from the panel.
//
// Needs of the block: ivec2 panel_px, ivec2 view_px, int second_column.
// Raster coordinates run right and down; a pixel's centre is at (column + 1/2, row + 1/2).
// Twin: vrlf/optics/viewport.py.

const int NO_EYE = -1;

// 0 the left eye, 1 the right one; the middle column of an odd width is nobody's.
int eye_of(int column) {
    if (column < view_px.x) return 0;
    if (column >= second_column) return 1;
    return NO_EYE;
}

int first_column(int eye) {
    return eye == 0 ? 0 : second_column;
}

// The septum: an eye sees its own half of the panel and nothing beside it.
bool in_viewport(ivec2 pixel, int eye) {
    int column = pixel.x - first_column(eye);
    return column >= 0 && column < view_px.x && pixel.y >= 0 && pixel.y < view_px.y;
}
