// A stack of scalars.

@group(0) @binding(1) var layers: texture_storage_2d_array<r32float, write>;
