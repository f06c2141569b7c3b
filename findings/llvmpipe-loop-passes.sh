#!/usr/bin/env bash
# Mesa's software Vulkan driver ends a shader's loop after 65 535 passes and goes on as if it were done.
#
# Guess:    a loop `for (i = 0; i < n; i++)` makes n passes, or the device is lost.
# Behavior: at 65 536 passes and above it makes 65 535, without an error; behind the loop its condition still holds.
#           Loops share the count: after 40 000 passes of one, a second of 40 000 makes 25 534, in all eight
#           invocations of a group if one of them needs so many.
# Seen:     llvmpipe of Mesa 22.3.6 (LLVM 15.0.6, 256 bits), Debian 12; wgpu 0.32.0 from the Python index.
# Output:   65535: 65535 passes
#           65536: 65535 passes
#           100000: 65535 passes
#           40000, then 40000 by one of eight: 40000, then 25534
#
# Needs Debian's mesa-vulkan-drivers and libvulkan1. Fails if any of this changes.
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet wgpu==0.32.0 numpy==2.4.6
export XDG_RUNTIME_DIR="$folder"

"$folder/venv/bin/python" - <<'PYTHON'
import numpy as np
import wgpu
from wgpu.utils.compute import compute_with_buffers
from wgpu.utils.device import get_default_device

info = get_default_device().adapter.info
print(info["device"], "-", info["description"])
assert "llvmpipe" in info["device"], "this is about llvmpipe; choose it with VK_DRIVER_FILES"

CODE = """
@group(0) @binding(0) var<storage, read> wanted: array<vec2u>;
@group(0) @binding(1) var<storage, read_write> made: array<vec2u>;

@compute @workgroup_size(8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    var first = 0u;
    for (var i = 0u; i < wanted[id.x].x; i++) { first += 1u; }
    var second = 0u;
    for (var i = 0u; i < wanted[id.x].y; i++) { second += 1u; }
    made[id.x] = vec2u(first, second);
}
"""


def passes(first, second):
    """Passes made by invocation 7 of 8; the others want ten of the first loop."""
    wanted = np.array([[10, 0]] * 7 + [[first, second]], dtype=np.uint32)
    made = compute_with_buffers({0: wanted}, {1: wanted.nbytes}, CODE, n=1)[1]
    return tuple(int(n) for n in np.frombuffer(made, dtype=np.uint32)[14:16])


for wanted in (65535, 65536, 100000):
    made, _ = passes(wanted, 0)
    print(f"{wanted}: {made} passes")
    assert made == 65535
both = passes(40000, 40000)
print(f"40000, then 40000 by one of eight: {both[0]}, then {both[1]}")
assert both == (40000, 25534)
PYTHON
