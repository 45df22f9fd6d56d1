// Shades a surface: its material in sun and skylight.
//
// Reads:  print_sums, the summed-area table of the pages.
// Writes: light (linear).

#include "block/Scene"

layout(binding = 0) uniform sampler2D print_sums;

in vec3 position;
in vec3 normal;
in vec2 place;
flat in int material;

out vec4 light;

#include "scene/noise.glsl"
#include "scene/light.glsl"
#include "scene/print.glsl"
#include "scene/materials.glsl"

void main() {
    float footprint = covered(place);
    vec2 box = abs(dFdx(place)) + abs(dFdy(place));
    vec3 up = normalize(gl_FrontFacing ? normal : -normal);
    Material m = material_at(material, place, footprint, box);
    float through = dappled(position, sunlight(position));
    vec3 shade = shaded(m.albedo, up, position, through * m.relief, m.open_sky, m.gloss);
    light = vec4(through_air(shade, position), 1.0);
}
