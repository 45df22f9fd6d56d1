// Hashed noise and its sum over octaves; no table, so detail goes down to the pixel.

// O'Neill 2014, PCG-RXS-M-XS: a hash of well-mixed bits.
uint pcg(uint v) {
    uint state = v * 747796405u + 2891336453u;
    uint word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
    return (word >> 22u) ^ word;
}

// Uniform in [0, 1), fixed for a cell of the plane.
float cell_value(ivec2 cell) {
    return float(pcg(uint(cell.x) + pcg(uint(cell.y))) >> 8u) / 16777216.0;
}

// Perlin 2002: the quintic whose first and second derivatives vanish at both ends.
vec2 quintic(vec2 t) {
    return t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
}

// The gradient at a lattice point, from the two halves of its hash, times an offset from it.
float slope_at(uint hash, vec2 offset) {
    vec2 gradient = vec2(hash & 0xffffu, hash >> 16u) / 32767.5 - 1.0;
    return dot(gradient, offset);
}

// Perlin 1985, 2002: gradient noise, scaled to a standard deviation of about 0.35.
float noise(vec2 p) {
    vec2 base = floor(p), t = p - base;
    ivec2 cell = ivec2(base);
    uint low = pcg(uint(cell.y)), high = pcg(uint(cell.y + 1));
    vec2 left = vec2(slope_at(pcg(uint(cell.x) + low), t),
                     slope_at(pcg(uint(cell.x) + high), t - vec2(0.0, 1.0)));
    vec2 right = vec2(slope_at(pcg(uint(cell.x + 1) + low), t - vec2(1.0, 0.0)),
                      slope_at(pcg(uint(cell.x + 1) + high), t - vec2(1.0)));
    vec2 weight = quintic(t);
    vec2 row = mix(left, right, weight.x);
    return 1.6 * mix(row.x, row.y, weight.y);
}

const int OCTAVES = 12;
const mat2 NEXT_OCTAVE = mat2(1.6, 1.2, -1.2, 1.6);  // twice as fine, turned by a 3-4-5 triangle

// Field 1987: natural amplitudes fall as 1/f, so every octave holds the same energy. ``gain``
// 1 is that; less is smoother. Octaves finer than the pixel are faded out: p moves by
// ``footprint`` a pixel, and an octave's finest wave is two cells long.
float pink(vec2 p, float footprint, float gain) {
    float total = 0.0, weight = 1.0, cells = footprint;
    for (int octave = 0; octave < OCTAVES && cells < 1.0; octave++) {
        total += weight * (1.0 - smoothstep(0.5, 1.0, cells)) * noise(p);
        p = NEXT_OCTAVE * p + vec2(17.3, -31.7);
        weight *= gain;
        cells *= 2.0;
    }
    return total;
}

// What a pixel covers of p: the geometric mean of its two sides.
float covered(vec2 p) {
    return sqrt(length(dFdx(p)) * length(dFdy(p)));
}
