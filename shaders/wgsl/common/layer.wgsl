// Layer: a cell so thin that f32 gives a ray no length in it, or goes back in it by rounding.
//
// What it adds to light and optical depth is lost with its length, and is as little. Its greatest
// value and its surfaces are not little: the scalar goes all the way from one side to the other.
// A layer is wholly seen, or not at all.
// With: common/optics_model.wgsl

// Normalized lengths: depths are at most 4, sums of three rounded products.
const THIN: f32 = 1.0 / 2097152.0; // 2⁻²¹

// Less than this is what rounding makes of two scalars at one point: a ray through an edge or a
// vertex meets two faces there. Scalars are in the unit of `ScalarMap`.
const GRAZED: f32 = 1.0 / 1048576.0; // 2⁻²⁰

// The length of a layer: more than none. A share of it is a number, too.
const LAYER: f32 = 1e-20;

// Whether the ray crosses a layer between `near` and `far`, each (z, scalar).
fn is_layer(near: vec2f, far: vec2f) -> bool {
    return (MODEL == MAXIMUM_INTENSITY || MODEL == ISOSURFACES)
        && abs(far.x - near.x) <= THIN && abs(far.y - near.y) > GRAZED;
}
