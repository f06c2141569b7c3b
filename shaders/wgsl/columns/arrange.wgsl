// Arrange: how many workgroups take the cells of each list.

// As in fill.wgsl.
@group(0) @binding(0) var<storage, read> counts: array<u32, 4>;
// Four numbers for each of the dispatches over lists 1 to 3.
@group(0) @binding(1) var<storage, read_write> workgroups: array<vec4u, 3>;

@compute @workgroup_size(1)
fn cs_arrange() {
    workgroups[0] = arranged(counts[1], 1u);
    workgroups[1] = arranged(counts[2], 64u);
    workgroups[2] = arranged(counts[3], 4096u);
}

// 65 535 workgroups are the most along each axis.
fn arranged(count: u32, for_each: u32) -> vec4u {
    let rows = (count + 65534u) / 65535u;
    return vec4u(for_each, (count + rows - 1u) / max(rows, 1u), rows, 0u) * min(rows, 1u);
}
