// A stack of scalars with their coverage.

@group(0) @binding(1) var layers: texture_storage_2d_array<rg32float, write>;
