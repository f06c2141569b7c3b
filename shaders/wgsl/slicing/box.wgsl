// A box of the volume, to be sliced.

struct PlacedBox {
    low: vec3i,   // its least corner, lattice space
    texel: vec3i, // what turns a sample's index into its texel
}
