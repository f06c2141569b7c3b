// Fill: the cells of each list, column by column.
//
// With: common/sides.wgsl, resample/mesh.wgsl, resample/column.wgsl, one of resample/put*.wgsl

// Cells in each list.
@group(0) @binding(4) var<storage, read> counts: array<u32, 4>;
// As in list.wgsl.
@group(0) @binding(5) var<storage, read> lists: array<u32>;
// List 0: an invocation for each cell.
@compute @workgroup_size(64)
fn cs_small(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) size: vec3u) {
    let place = id.x + 64u * size.x * id.y;
    if place >= counts[0] {
        return;
    }
    let cell = cell_of(lists[place]);
    let columns = cell.size.x * cell.size.y;
    for (var column = 0u; column < columns; column++) {
        fill_column(cell, column);
    }
}

// Lists 1 to 3: `size.x` workgroups for each cell, which share its columns.
@compute @workgroup_size(64)
fn cs_large(
    @builtin(workgroup_id) id: vec3u,
    @builtin(num_workgroups) size: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    // 1, 64 and 4096 workgroups.
    let list = select(select(1u, 2u, size.x > 1u), 3u, size.x > 64u);
    let place = id.y + size.y * id.z;
    if place >= counts[list] {
        return;
    }
    let count = work.cell_count;
    let from_start = (list >> 1u) * count + place;
    let from_end = ((list >> 1u) + 1u) * count - 1u - place;
    let cell = cell_of(lists[select(from_start, from_end, (list & 1u) == 1u)]);
    let columns = cell.size.x * cell.size.y;
    let step = 64u * size.x;
    for (var column = 64u * id.x + lane; column < columns; column += step) {
        fill_column(cell, column);
    }
}
