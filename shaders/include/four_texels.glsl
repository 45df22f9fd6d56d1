// One colour of the four texels about a corner of the target's raster.
//
// Needs of the block: ivec2 panel_px; of the shader: sampler2D target.
//
// A gather is one instruction where four fetches are four, and it asks for one colour of four.
// At a corner all four texels are equally near: no hardware's rounding chooses others.

// Upper left (w), upper right (z), lower left (x), lower right (y); `pixel` is the upper left.
vec4 four_texels(vec2 pixel, int colour) {
    vec2 corner = (pixel + 1.0) * (1.0 / vec2(panel_px));
    switch (colour) {  // the component must be a constant; calls give one, and one case is left
        case 0: return textureGather(target, corner, 0);
        case 1: return textureGather(target, corner, 1);
        default: return textureGather(target, corner, 2);
    }
}
