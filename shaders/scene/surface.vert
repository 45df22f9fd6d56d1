// Walls, ground, furniture: anything with a material and a place on it in metres.

#include "block/Scene"

in vec3 in_position;
in vec3 in_normal;
in vec2 in_place;      // metres along the surface
in float in_material;  // see materials.glsl

out vec3 position;
out vec3 normal;
out vec2 place;
flat out int material;

void main() {
    position = in_position;
    normal = in_normal;
    place = in_place;
    material = int(in_material + 0.5);
    gl_Position = clip_from_world * vec4(in_position, 1.0);
}
