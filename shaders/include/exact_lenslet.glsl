// A plano-convex lenslet, refracted exactly, and the gap behind it.
//
// Needs of the block: vec4 lens_index (of each colour, and of the gap), vec4 lens_shape (radius,
// thickness, from the array's plane back to the first vertex, from the last one to the panel;
// mm); of the shader: the define CURVED_FIRST, 1 where the curved side is toward the eye.
// Derivation and twin: vrlf/optics/exact_lenslet.py.

// A ray in a plane across the axis: its place in mm, how deep behind the last vertex, its
// direction; `passes` turns false where there is none.
struct GlassRay {
    vec2 at;
    float z;
    vec3 direction;
    bool passes;
};

void through_plane(inout GlassRay ray, float ratio) {
    vec2 across = ratio * ray.direction.xy;
    float along = 1.0 - dot(across, across);
    ray.passes = ray.passes && along > 0.0;
    ray.direction = vec3(across, sqrt(max(along, 1e-12)));
}

// `ray.at` lies in the plane through the vertex; the root near the vertex is taken.
void through_sphere(inout GlassRay ray, float radius, float ratio) {
    float squared = dot(ray.at, ray.at);
    float nearest = radius * ray.direction.z - dot(ray.at, ray.direction.xy);
    float chord = nearest * nearest - squared;
    ray.passes = ray.passes && chord > 0.0;
    float root = sign(radius) * sqrt(max(chord, 0.0));
    float way = chord > 0.0 ? squared / (nearest + root) : 0.0;
    ray.at += way * ray.direction.xy;
    ray.z = way * ray.direction.z;
    vec3 normal = vec3(-ray.at, radius - ray.z) / radius;
    float cosine = dot(normal, ray.direction);
    float beyond = 1.0 - ratio * ratio * (1.0 - cosine * cosine);
    ray.passes = ray.passes && beyond > 0.0;
    ray.direction = ratio * ray.direction + (sqrt(max(beyond, 0.0)) - ratio * cosine) * normal;
}

void advance(inout GlassRay ray, float by) {
    ray.at += (by - ray.z) / ray.direction.z * ray.direction.xy;
    ray.z = 0.0;
}

// Where a ray lands on the panel, in mm from the lenslet's centre.
//   place  on the array's plane from the centre, mm, lattice frame
//   slope  before the array, lattice frame
vec2 exact_landing(vec2 place, vec2 slope, int colour, out bool passes) {
    float radius = lens_shape.x, thickness = lens_shape.y, n = lens_index[colour];
    GlassRay ray = GlassRay(place - lens_shape.z * slope, 0.0, normalize(vec3(slope, 1.0)), true);
#if CURVED_FIRST
    through_sphere(ray, radius, 1.0 / n);
    advance(ray, thickness);
    through_plane(ray, n / lens_index.w);
#else
    through_plane(ray, 1.0 / n);
    advance(ray, thickness);
    through_sphere(ray, -radius, n / lens_index.w);
#endif
    advance(ray, lens_shape.w);
    passes = ray.passes;
    return ray.at;
}
