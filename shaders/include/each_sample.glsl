// EACH_SAMPLE(DO): DO(column, row) for all samples of a sub-pixel's GRID x GRID, by rows.
// EACH_ROW(DO): DO(row) for all rows.
//
// Written out, for software GL leaves a loop with so long a body as it is: samples that read the
// target took 1.5 to 1.8 times as long. Above 4 x 4 the program would grow too long.

#if GRID == 1
#define EACH_SAMPLE(DO) DO(0, 0)
#define EACH_ROW(DO) DO(0)
#elif GRID == 2
#define SAMPLE_ROW(DO, row) DO(0, row) DO(1, row)
#define EACH_SAMPLE(DO) SAMPLE_ROW(DO, 0) SAMPLE_ROW(DO, 1)
#define EACH_ROW(DO) DO(0) DO(1)
#elif GRID == 3
#define SAMPLE_ROW(DO, row) DO(0, row) DO(1, row) DO(2, row)
#define EACH_SAMPLE(DO) SAMPLE_ROW(DO, 0) SAMPLE_ROW(DO, 1) SAMPLE_ROW(DO, 2)
#define EACH_ROW(DO) DO(0) DO(1) DO(2)
#elif GRID == 4
#define SAMPLE_ROW(DO, row) DO(0, row) DO(1, row) DO(2, row) DO(3, row)
#define EACH_SAMPLE(DO) SAMPLE_ROW(DO, 0) SAMPLE_ROW(DO, 1) SAMPLE_ROW(DO, 2) SAMPLE_ROW(DO, 3)
#define EACH_ROW(DO) DO(0) DO(1) DO(2) DO(3)
#else
#define EACH_SAMPLE(DO) \
    for (int row = 0; row < GRID; row++) { \
        for (int column = 0; column < GRID; column++) { DO(column, row) } \
    }
#define EACH_ROW(DO) for (int row = 0; row < GRID; row++) { DO(row) }
#endif
