// One triangle over the whole canvas, behind everything; what it shows is a direction.

#include "block/Scene"

out vec3 direction;

void main() {
    vec2 corner = vec2((gl_VertexID << 1) & 2, gl_VertexID & 2);  // 0 to 2, the canvas is 0 to 1
    vec2 slope = mix(slopes.xy, slopes.zw, corner);
    direction = head_right.xyz * slope.x + head_up.xyz * slope.y - head_back.xyz;
    gl_Position = vec4(2.0 * corner - 1.0, 1.0, 1.0);
}
