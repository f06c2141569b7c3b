// Fill: the columns of a grid that each cell of a mesh meets, one after the other.
//
// Needs: `work` with `cell_count` and `small`, the most passes of one invocation for a cell;
// `cell_of(index) -> Cell` with `size`, the columns that the cell may meet, and `depth`, the samples
// of one at most, one of which is 0 for a cell that is to be left out; `meet(cell, column) -> Meeting`
// with `inside`, whether the column meets the cell; `fill_column(cell, meeting)`; and
// `COLUMN_PASSES`, the passes of loops for a column beside those for its samples.

// How many cells are in lists 1 to 3, which are those with much to do.
@group(0) @binding(4) var<storage, read_write> counts: array<atomic<u32>, 4>;
// Lists 1 and 2 share the first part, one number for each cell, from its ends; 3 is behind it.
@group(0) @binding(5) var<storage, read_write> lists: array<u32>;

// Columns that a workgroup, and 64 of them, take at most; 4096 take all there can be.
const OF_ONE: u32 = 1024u;
const OF_64: u32 = 65536u;

// An invocation for each cell: finishes it, or lists it where it is too much work for one.
@compute @workgroup_size(64)
fn cs_small(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) size: vec3u) {
    let index = id.x + 64u * size.x * id.y;
    if index >= work.cell_count {
        return;
    }
    let cell = cell_of(index);
    let columns = cell.size.x * cell.size.y;
    if columns * cell.depth == 0u {
        return;
    }
    if columns * (cell.depth + COLUMN_PASSES) > work.small {
        let list = select(select(3u, 2u, columns <= OF_64), 1u, columns <= OF_ONE);
        lists[place_of(list, atomicAdd(&counts[list], 1u))] = index;
        return;
    }
    fill_columns(cell, 0u, 1u);
}

// `size.x` workgroups for each cell of a list, which share its columns.
@compute @workgroup_size(64)
fn cs_large(
    @builtin(workgroup_id) id: vec3u,
    @builtin(num_workgroups) size: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    // 1, 64 and 4096 workgroups.
    let list = select(select(1u, 2u, size.x > 1u), 3u, size.x > 64u);
    let place = id.y + size.y * id.z;
    if place >= atomicLoad(&counts[list]) {
        return;
    }
    let cell = cell_of(lists[place_of(list, place)]);
    fill_columns(cell, 64u * id.x + lane, 64u * size.x);
}

// Every column that is a number of steps behind the first. Columns are counted along both axes, as a
// division for each costs software rasterizers as much as all the rest.
fn fill_columns(cell: Cell, first: u32, step: u32) {
    let width = cell.size.x;
    let stride = vec2u(step % width, step / width);
    var column = vec2u(first % width, first / width);
    while column.y < cell.size.y {
        let meeting = meet(cell, column);
        if meeting.inside {
            fill_column(cell, meeting);
        }
        column += stride;
        let is_past = column.x >= width;
        column = select(column, vec2u(column.x - width, column.y + 1u), is_past);
    }
}

fn place_of(list: u32, place: u32) -> u32 {
    let count = work.cell_count;
    return select(select(place, count - 1u - place, list == 2u), count + place, list == 3u);
}
