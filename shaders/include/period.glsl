// Which rectangles a panel pixel emits from: layouts repeat over the panel.
//
// Defines: PERIOD_X, PERIOD_Y, pixels of the period, 1 or 2 each way.
// Twin: vrlf/optics/subpixels.py, Layout.at.

// A pixel's place in the period, counted by rows; where it stands on the whole panel decides.
int place_of(ivec2 pixel) {
#if PERIOD_X * PERIOD_Y == 1
    return 0;
#else
    ivec2 place = pixel & ivec2(PERIOD_X - 1, PERIOD_Y - 1);
    return place.y * PERIOD_X + place.x;
#endif
}

// Where its three rectangles begin.
int first_box(ivec2 pixel) {
    return 3 * place_of(pixel);
}
