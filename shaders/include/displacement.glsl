// X - x of the forward prefilter: a polynomial for each direction, both at once.
//
// Needs of the block: moves, of FORWARD of vrlf/passes/forward.py; of the shader: ray_set(); the
// defines DEGREE, and ALIKE, 1 where an eye's colours differ in no term above the linear ones.
//
// Horner's rule, written out. For software GL each loop is slow, and so is each read of the block:
// read once and kept, coefficients cost less than what is done with them.

int first_move(int eye, int colour) {
    return ray_set(eye, colour) * (DEGREE + 1) * (DEGREE + 1);
}

// All but the powers above the first.
vec2 straight(vec2 place, int eye, int colour) {
    int first = first_move(eye, colour);
    return moves[first].xy + place.x * moves[first + DEGREE + 1].xy
         + place.y * moves[first + 1].xy;
}

#if DEGREE > 1
// Of x to the i and y to the j.
vec2 curve(const int i, const int j, int eye, int colour) {
    int first = first_move(eye, ALIKE == 1 ? 0 : colour);
    return i + j > 1 ? moves[first + i * (DEGREE + 1) + j].xy : vec2(0.0);
}

// Coefficients of x to the i: polynomials of y, from y to the j on, UP_n to the nth power above.
#define UP_0(i, j) curve(i, j, eye, colour)
#define UP_1(i, j) (UP_0(i, j) + y * UP_0(i, j + 1))
#define UP_2(i, j) (UP_0(i, j) + y * UP_1(i, j + 1))
#define UP_3(i, j) (UP_0(i, j) + y * UP_2(i, j + 1))
#define UP_4(i, j) (UP_0(i, j) + y * UP_3(i, j + 1))
#define UP_5(i, j) (UP_0(i, j) + y * UP_4(i, j + 1))
#define UP_6(i, j) (UP_0(i, j) + y * UP_5(i, j + 1))
#define UP_7(i, j) (UP_0(i, j) + y * UP_6(i, j + 1))

// All of them by their powers of x.
#if DEGREE == 2
#define BY_POWER vec2[](UP_2(0, 0), UP_1(1, 0), UP_0(2, 0))
#elif DEGREE == 3
#define BY_POWER vec2[](UP_3(0, 0), UP_2(1, 0), UP_1(2, 0), UP_0(3, 0))
#elif DEGREE == 4
#define BY_POWER vec2[](UP_4(0, 0), UP_3(1, 0), UP_2(2, 0), UP_1(3, 0), UP_0(4, 0))
#elif DEGREE == 5
#define BY_POWER vec2[](UP_5(0, 0), UP_4(1, 0), UP_3(2, 0), UP_2(3, 0), UP_1(4, 0), UP_0(5, 0))
#elif DEGREE == 6
#define BY_POWER vec2[](UP_6(0, 0), UP_5(1, 0), UP_4(2, 0), UP_3(3, 0), UP_2(4, 0), UP_1(5, 0), \
                        UP_0(6, 0))
#elif DEGREE == 7
#define BY_POWER vec2[](UP_7(0, 0), UP_6(1, 0), UP_5(2, 0), UP_4(3, 0), UP_3(4, 0), UP_2(5, 0), \
                        UP_1(6, 0), UP_0(7, 0))
#else
#error "DEGREE: wanted at most 7, as the slopes of wavefronts of order 8 have"
#endif

vec2[DEGREE + 1] curves(float y, int eye, int colour) {
    return BY_POWER;
}

vec2 curved(vec2 powers[DEGREE + 1], float x) {
    vec2 value = powers[DEGREE];
    for (int i = DEGREE - 1; i >= 0; i--) value = value * x + powers[i];
    return value;
}
#endif

// Of a place in a cell, or with DEGREE above 1 in pixels from where the lenslet stands.
vec2 displacement(vec2 place, int eye, int colour) {
#if DEGREE == 1
    return straight(place, eye, colour);
#else
    return straight(place, eye, colour) + curved(curves(place.y, eye, colour), place.x);
#endif
}
