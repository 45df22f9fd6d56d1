// X - x of the forward prefilter: a polynomial for each direction, both at once.
//
// Needs of the block: moves, of FORWARD of vrlf/passes/forward.py; the define DEGREE.
//
// Horner's rule, written out, for software GL leaves nested loops as they are: those took four
// times as long.

#define FROM_2(DO) DO(2) DO(1) DO(0)
#define FROM_3(DO) DO(3) FROM_2(DO)
#define FROM_4(DO) DO(4) FROM_3(DO)
#define FROM_5(DO) DO(5) FROM_4(DO)
#define FROM_6(DO) DO(6) FROM_5(DO)
#define FROM_7(DO) DO(7) FROM_6(DO)

// EACH_POWER(DO): DO(i) for all powers, from DEGREE down to 0.
#if DEGREE == 2
#define EACH_POWER(DO) FROM_2(DO)
#elif DEGREE == 3
#define EACH_POWER(DO) FROM_3(DO)
#elif DEGREE == 4
#define EACH_POWER(DO) FROM_4(DO)
#elif DEGREE == 5
#define EACH_POWER(DO) FROM_5(DO)
#elif DEGREE == 6
#define EACH_POWER(DO) FROM_6(DO)
#elif DEGREE == 7
#define EACH_POWER(DO) FROM_7(DO)
#elif DEGREE > 7
#error "DEGREE: wanted at most 7, as the slopes of wavefronts of order 8 have"
#endif

int first_move(int set) {
    return set * (DEGREE + 1) * (DEGREE + 1);
}

#if DEGREE == 1
// Of a place in a cell.
vec2 displacement(vec2 t, int set) {
    int first = first_move(set);
    return moves[first].xy + t.x * moves[first + 2].xy + t.y * moves[first + 1].xy;
}
#else
// The coefficient of s.x to the i: a polynomial of s.y.
vec2 of_power(const int i, float y, int set) {
    int first = first_move(set) + i * (DEGREE + 1);
    vec2 value = moves[first + DEGREE - i].xy;
    for (int j = DEGREE - i - 1; j >= 0; j--) value = value * y + moves[first + j].xy;
    return value;
}

// Of a place in pixels from where the lenslet stands.
vec2 displacement(vec2 s, int set) {
    vec2 value = vec2(0.0);
#define ADD(i) value = value * s.x + of_power(i, s.y, set);
    EACH_POWER(ADD)
#undef ADD
    return value;
}
#endif
