// Surfaces of a glTF scene.

#include "block/Model"

in vec3 in_position;
in vec3 in_normal;
in vec2 in_uv;
in vec4 in_colour;

out vec3 position;
out vec3 normal;
out vec2 uv;
out vec4 tint;

void main() {
    vec4 in_world = world_from_node * vec4(in_position, 1.0);
    position = in_world.xyz;
    normal = (normal_from_node * vec4(in_normal, 0.0)).xyz;
    uv = in_uv;
    tint = in_colour;
    gl_Position = clip_from_world * in_world;
}
