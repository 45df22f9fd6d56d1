// What surfaces are made of. Each material is a colour with equal energy in all octaves.
//
// Needs noise.glsl and print.glsl. Numbers as in ``Material`` of vrlf/scene/solids.py.

const int LAWN = 0, BRICK = 1, PLASTER = 2, WOOD = 3, PAPER = 4, BARK = 5, CLAY = 6, GLASS = 7,
          CLOTH = 8, STONE = 9;

struct Material {
    vec3 albedo;
    float relief;    // how much sun the small shape lets it have
    float open_sky;  // how much skylight
    float gloss;
};

// A colour whose logarithm is noise: no colour is negative, and contrast looks equal everywhere.
vec3 mottled(vec3 albedo, float strength, float noise_sum) {
    return albedo * exp(strength * noise_sum);
}

Material lawn(vec2 p, float footprint) {
    float n = pink(p * 0.7, footprint * 0.7, 0.95);
    float dry = 0.5 + 0.5 * noise(p * 0.35 + 4.0);
    vec3 green = mix(vec3(0.060, 0.115, 0.022), vec3(0.140, 0.140, 0.045), dry);
    return Material(mottled(green, 0.26, n), 1.0, 0.85, 0.0);
}

// Bricks of 215 x 65 mm in 10 mm of mortar, each course moved by half a brick.
Material brick(vec2 p, float footprint) {
    vec2 pitch = vec2(0.225, 0.075);
    vec2 at = p / pitch;
    float course = floor(at.y);
    at.x += 0.5 * mod(course, 2.0);
    ivec2 cell = ivec2(floor(at));
    vec2 border = (0.5 - abs(fract(at) - 0.5)) * pitch;
    float n = pink(p * 5.0, footprint * 5.0, 0.95);
    float edge = 0.005 + 0.0015 * n;
    float inside = smoothstep(edge - 0.5 * footprint - 0.001, edge + 0.5 * footprint + 0.001,
                              min(border.x, border.y));
    float own = cell_value(cell), burnt = cell_value(cell + 991);
    vec3 clay = mix(vec3(0.34, 0.13, 0.075), vec3(0.19, 0.075, 0.055), own * own);
    clay *= 0.75 + 0.5 * burnt;
    float stain = pink(p * 0.45, footprint * 0.45, 0.9);
    vec3 albedo = mix(mottled(vec3(0.40, 0.36, 0.30), 0.16, n), mottled(clay, 0.2, n), inside);
    return Material(mottled(albedo, 0.14, stain), mix(0.65, 1.0, inside), 0.95, 0.05);
}

Material plaster(vec2 p, float footprint) {
    float n = pink(p * 0.6, footprint * 0.6, 0.95);
    float streaks = pink(p * vec2(4.0, 0.5), footprint * 4.0, 0.8);
    vec3 albedo = mottled(vec3(0.50, 0.42, 0.31), 0.085, n + 0.7 * streaks);
    return Material(albedo, 1.0 + 0.1 * clamp(n, -2.0, 2.0), 1.0, 0.0);
}

// Boards 110 mm wide; the grain is noise drawn out along them and bent by slower noise.
Material wood(vec2 p, float footprint) {
    float board = floor(p.y / 0.11);
    float across = fract(p.y / 0.11);
    vec2 grain = vec2(p.x * 3.0 + 37.0 * board, p.y * 90.0 + 2.5 * noise(p * vec2(5.0, 14.0)));
    float n = pink(grain, footprint * 90.0, 0.85) + pink(p * 6.0, footprint * 6.0, 0.9);
    float seam = smoothstep(0.0, 0.018, min(across, 1.0 - across));
    float own = cell_value(ivec2(int(board), 5));
    vec3 albedo = mix(vec3(0.30, 0.175, 0.085), vec3(0.22, 0.115, 0.055), own);
    return Material(mottled(albedo, 0.17, n) * (0.25 + 0.75 * seam), 1.0, 0.4 + 0.6 * seam, 0.35);
}

Material paper(vec2 p, float footprint, vec2 box) {
    float fibre = pink(p * 60.0, footprint * 60.0, 0.95);
    float ink = ink_over(p, box);
    vec3 sheet = mottled(vec3(0.60, 0.57, 0.50), 0.02, fibre);
    return Material(mix(sheet, vec3(0.030, 0.028, 0.032), ink), 1.0, 1.0, 0.02);
}

Material bark(vec2 p, float footprint) {
    float n = pink(p * vec2(22.0, 5.0), footprint * 12.0, 0.9);
    float cracks = abs(noise(p * vec2(30.0, 4.0) + n));
    vec3 albedo = mottled(vec3(0.135, 0.098, 0.066), 0.35, n);
    return Material(albedo * (0.35 + 0.65 * smoothstep(0.0, 0.35, cracks)), 1.0, 0.8, 0.0);
}

Material clay(vec2 p, float footprint) {
    float n = pink(p * 14.0, footprint * 14.0, 0.95);
    float lime = smoothstep(0.3, 1.6, pink(p * 9.0 + 3.0, footprint * 9.0, 0.9));
    vec3 albedo = mix(mottled(vec3(0.42, 0.17, 0.085), 0.1, n), vec3(0.55, 0.46, 0.38), 0.5 * lime);
    return Material(albedo, 1.0, 0.9, 0.1);
}

Material glass(vec2 p, float footprint) {
    float inside = pink(p * 2.5, footprint * 2.5, 0.8);
    return Material(mottled(vec3(0.030, 0.034, 0.040), 0.5, inside), 1.0, 1.0, 1.0);
}

Material cloth(vec2 p, float footprint) {
    float n = pink(p * 18.0, footprint * 18.0, 0.95);
    return Material(mottled(vec3(0.055, 0.085, 0.19), 0.13, n), 1.0, 1.0, 0.1);
}

Material stone(vec2 p, float footprint) {
    float n = pink(p * 3.0, footprint * 3.0, 0.97);
    return Material(mottled(vec3(0.36, 0.34, 0.30), 0.17, n), 1.0, 0.95, 0.02);
}

Material material_at(int kind, vec2 p, float footprint, vec2 box) {
    switch (kind) {
        case LAWN: return lawn(p, footprint);
        case BRICK: return brick(p, footprint);
        case PLASTER: return plaster(p, footprint);
        case WOOD: return wood(p, footprint);
        case PAPER: return paper(p, footprint, box);
        case BARK: return bark(p, footprint);
        case CLAY: return clay(p, footprint);
        case GLASS: return glass(p, footprint);
        case CLOTH: return cloth(p, footprint);
        default: return stone(p, footprint);
    }
}
