#!/usr/bin/env bash
# Mesa's software Vulkan driver compiles some large compute shaders anew for each dispatch that binds a uniform buffer.
#
# Guess:    a compute pipeline is compiled once; numbers in a uniform buffer cost no more than those in a storage buffer.
# Behavior: lavapipe puts a uniform's numbers into the program as constants, and where one is kept in an indexed array and
#           used in five places or more it does so at each dispatch, also with the numbers of the dispatch before.
#           From a storage buffer the same program is compiled once.
# Seen:     llvmpipe of Mesa 22.3.6 (LLVM 15.0.6, 256 bits), Debian 12; wgpu 0.32.0 from the Python index.
# Output:   uniform: 8.8 ms a dispatch, storage: 1.0 ms, of one work group
#
# Needs Debian's mesa-vulkan-drivers and libvulkan1. Fails if a dispatch takes less than thrice as long with the uniform.
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet wgpu==0.32.0 numpy==2.4.6
export XDG_RUNTIME_DIR="$folder"

"$folder/venv/bin/python" - <<'PYTHON'
import statistics
import time

import numpy as np
import wgpu
from wgpu.utils.device import get_default_device

device = get_default_device()
info = device.adapter.info
print(info["device"], "-", info["description"])
assert "llvmpipe" in info["device"], "this is about llvmpipe; choose it with VK_DRIVER_FILES"

# Sixty steps that no optimizer makes fewer.
STEPS = "\n".join(f"        x = sin(x * {1.1 + 0.01 * i:.2f}) + y; y = y * x - {0.1 * i:.1f};" for i in range(60))
CODE = """
struct Numbers { passes: u32, scale: f32 }
@group(0) @binding(0) var<SPACE> numbers: Numbers;
@group(0) @binding(1) var<storage, read_write> result: array<f32>;

@compute @workgroup_size(8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    var kept = array<f32, 4>(1.0, 2.0, 3.0, 4.0);
    kept[id.x & 3u] = numbers.scale;
    var x = numbers.scale * f32(id.x);
    var y = numbers.scale;
    for (var i = 0u; i < numbers.passes; i++) {
STEPS
        x += numbers.scale * kept[i & 3u] + min(numbers.scale, y) - max(numbers.scale, x);
    }
    result[id.x] = x + y * numbers.scale;
}
"""


def milliseconds(space, usage):
    """The median time of a dispatch of one work group, from its submission to its end."""
    code = CODE.replace("SPACE", space).replace("STEPS", STEPS)
    module = device.create_shader_module(code=code)
    pipeline = device.create_compute_pipeline(
        layout="auto", compute={"module": module, "entry_point": "main"}
    )
    numbers = np.array([(3, 0.5)], dtype=[("passes", "u4"), ("scale", "f4")])
    result = device.create_buffer(
        size=32, usage=wgpu.BufferUsage.STORAGE | wgpu.BufferUsage.COPY_SRC
    )
    numbers = device.create_buffer_with_data(data=numbers.tobytes(), usage=usage)
    group = device.create_bind_group(
        layout=pipeline.get_bind_group_layout(0),
        entries=[
            {"binding": i, "resource": {"buffer": b, "offset": 0, "size": b.size}}
            for i, b in enumerate((numbers, result))
        ],
    )
    times = []
    for _ in range(40):
        start = time.perf_counter()
        encoder = device.create_command_encoder()
        compute = encoder.begin_compute_pass()
        compute.set_pipeline(pipeline)
        compute.set_bind_group(0, group)
        compute.dispatch_workgroups(1)
        compute.end()
        device.queue.submit([encoder.finish()])
        device.queue.read_buffer(result)
        times.append(1e3 * (time.perf_counter() - start))
    return statistics.median(times[5:])


uniform = milliseconds("uniform", wgpu.BufferUsage.UNIFORM)
storage = milliseconds("storage, read", wgpu.BufferUsage.STORAGE)
print(f"uniform: {uniform:.1f} ms a dispatch, storage: {storage:.1f} ms, of one work group")
assert uniform > 3 * storage, "the uniform costs nothing"
PYTHON
