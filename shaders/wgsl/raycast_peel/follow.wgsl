// Follow: a ray from cell to cell, from where it enters the mesh to where it leaves it.
//
// A cell is the exclusive or of its four vertex ids, in `sums`, and the neighbors across the
// faces opposite its vertices by increasing id (Aman, Demirci, Güdükbay 2022).
// With: raycast_peel/boundary.wgsl and what it needs, raycast_peel/gather.wgsl

// Lists of texels (common/texels.wgsl).
// Of each cell, for cell data and where `CORNER_SCALARS`.
@group(1) @binding(1) var scalars: texture_2d<f32>;
@group(1) @binding(2) var sums: texture_2d<u32>;
@group(1) @binding(3) var neighbors: texture_2d<u32>;

// A neighbor with this bit is a boundary face.
const AT_BOUNDARY: u32 = 0x80000000u;

// Whether each cell has scalars of its own at its corners, by increasing id, as the field jumps
// from cell to cell.
override CORNER_SCALARS: bool = false;

// How following a path ended.
const ON_WAY: u32 = 0u;  // it did not: the passes were over
const LEFT: u32 = 1u;    // at a boundary face
const STOPPED: u32 = 2u; // inside the mesh: nothing behind shows

// A ray on its way through the mesh.
struct Path {
    // The face through which it came into the cell.
    a: Corner,
    b: Corner,
    c: Corner,
    turn: i32,    // on which side its edges pass
    cell: u32,
    next: u32,    // behind the cell
    near: vec2f,  // z and scalar at the face
    seen: f32,    // z never goes back, not even in an inverted cell
    visits: u32,  // cells passed
    piece: Piece, // in the cell before `next`, while some of it is left
    rest: Rest,
}

fn path_from(face: u32, turn: i32, shear: Shear) -> Path {
    let ids = textureLoad(boundary, texel(face), 0);
    let a = corner(ids.x, shear);
    let b = corner(ids.y, shear);
    let c = corner(ids.z, shear);
    let near = crossing_point(a, b, c);
    let piece = Piece(0.0, 0.0, 0.0, 0.0, vec2f(0.0));
    return Path(a, b, c, turn, ids.w, NO_FACE, near, near.x, 0u, piece, no_rest());
}

// Follows a path through at most `most` cells, where a cell counts once for each interval of
// the transfer function that its scalars are in, and adds them to `ray`. One pass more where a
// scalar waits on a step.
//
// Each cell is crossed through exactly two faces (walk.wgsl), so a path cannot come back to a
// cell.
fn follow(path: ptr<function, Path>, shear: Shear, line: Line, ray: ptr<function, Gathered>, most: u32) -> u32 {
    var p = *path;
    var rest = p.rest;
    var ended = ON_WAY;
    let stop_depth = march.stop_depth;
    for (var n = 0u; n < most || rest.on_step; n += 1u) {
        if !rest.is_left {
            put_aside(ray, p.visits);
            let at = texel(p.cell);
            var a = p.a;
            var b = p.b;
            var c = p.c;
            var d = corner(textureLoad(sums, at, 0).x ^ a.id ^ b.id ^ c.id, shear);
            if CORNER_SCALARS {
                let own = textureLoad(scalars, at, 0);
                a.scalar = own[u32(b.id < a.id) + u32(c.id < a.id) + u32(d.id < a.id)];
                b.scalar = own[u32(a.id < b.id) + u32(c.id < b.id) + u32(d.id < b.id)];
                c.scalar = own[u32(a.id < c.id) + u32(b.id < c.id) + u32(d.id < c.id)];
                d.scalar = own[u32(a.id < d.id) + u32(b.id < d.id) + u32(c.id < d.id)];
                p.near.y = crossing_point(a, b, c).y;
            }
            // Of the three faces around d, the ray leaves through the one whose two
            // edges at d pass it on the side of the entry face's edges.
            var left = a;
            var kept = vec2u(b.id, c.id);
            if side(a.xy, d.xy) == -p.turn {
                if side(b.xy, d.xy) == p.turn {
                    left = c;
                    kept = vec2u(a.id, b.id);
                    c = d;
                } else {
                    a = d;
                }
            } else if side(c.xy, d.xy) == -p.turn {
                left = b;
                kept = vec2u(a.id, c.id);
                b = d;
            } else {
                a = d;
            }
            let rank = u32(kept.x < left.id) + u32(kept.y < left.id) + u32(d.id < left.id);
            p.next = textureLoad(neighbors, at, 0)[rank];
            let far = crossing_point(a, b, c);
            p.piece = piece_of(p.cell, p.near, far, p.seen, shear.depth, line);
            if p.piece.length > 0.0 {
                if MODEL == ISOSURFACES {
                    meet_surface(p.piece, array<Corner, 4>(a, b, c, left), shear, line, ray);
                } else {
                    begin_piece(ray, p.piece, &rest);
                }
            }
            p.a = a;
            p.b = b;
            p.c = c;
            p.visits += 1u;
            p.seen = max(p.seen, far.x);
            p.near = far;
        }
        if rest.is_left {
            gather_interval(ray, p.piece, &rest);
        }
        if !rest.is_left {
            // Before the boundary is looked at: in a path's last cell, too, a ray may be done.
            if optical_depth_of(*ray) > stop_depth {
                ended = STOPPED;
                break;
            }
            if (p.next & AT_BOUNDARY) != 0u {
                ended = LEFT;
                break;
            }
            if p.seen >= line.end {
                ended = STOPPED;
                break;
            }
            p.cell = p.next;
        }
    }
    p.rest = rest;
    *path = p;
    return ended;
}
