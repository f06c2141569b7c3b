#!/usr/bin/env bash
# Mesa's software Vulkan driver filters textures of 8 bits in 8 bits: what a sampler returns has 8 bits, too.
#
# Guess:    a linear sampler returns a float between two texels, whatever their format.
# Behavior: between the texels 100 and 101 an R8Unorm texture gives a step of two values, where R16Float gives a
#           slope: a smooth volume of bytes is drawn in terraces.
# Seen:     llvmpipe of Mesa 22.3.6 (LLVM 15.0.6, 256 bits), Debian 12; wgpu 0.32.0 from the Python index.
# Output:   r8unorm: 2 different values in 33 samples
#           r16float: 33 different values in 33 samples
#
# Needs Debian's mesa-vulkan-drivers and libvulkan1. Fails if this changes.
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet wgpu==0.32.0 numpy==2.4.6
export XDG_RUNTIME_DIR="$folder"

"$folder/venv/bin/python" - <<'PYTHON'
import numpy as np
import wgpu
from wgpu.utils.device import get_default_device

device = get_default_device()
info = device.adapter.info
print(info["device"], "-", info["description"])
assert "llvmpipe" in info["device"], "this is about llvmpipe; choose it with VK_DRIVER_FILES"

CODE = """
@group(0) @binding(0) var image: texture_2d<f32>;
@group(0) @binding(1) var filtering: sampler;
@group(0) @binding(2) var<storage, read_write> samples: array<f32, 33>;

@compute @workgroup_size(1)
fn main(@builtin(global_invocation_id) id: vec3u) {
    // From the center of the first of two texels to that of the second.
    let x = 0.25 + 0.5 * f32(id.x) / 32.0;
    samples[id.x] = textureSampleLevel(image, filtering, vec2f(x, 0.5), 0.0).x;
}
"""
module = device.create_shader_module(code=CODE)
pipeline = device.create_compute_pipeline(layout="auto", compute={"module": module, "entry_point": "main"})
sampler = device.create_sampler(mag_filter="linear", min_filter="linear")


def samples(texels, texture_format):
    size = (2, 1, 1)
    usage = wgpu.TextureUsage.TEXTURE_BINDING | wgpu.TextureUsage.COPY_DST
    texture = device.create_texture(size=size, format=texture_format, usage=usage)
    layout = {"offset": 0, "bytes_per_row": texels.nbytes, "rows_per_image": 1}
    device.queue.write_texture({"texture": texture}, texels, layout, size)
    usage = wgpu.BufferUsage.STORAGE | wgpu.BufferUsage.COPY_SRC
    buffer = device.create_buffer(size=33 * 4, usage=usage)
    resources = [texture.create_view(), sampler, {"buffer": buffer, "offset": 0, "size": buffer.size}]
    entries = [{"binding": i, "resource": resource} for i, resource in enumerate(resources)]
    group = device.create_bind_group(layout=pipeline.get_bind_group_layout(0), entries=entries)
    encoder = device.create_command_encoder()
    compute = encoder.begin_compute_pass()
    compute.set_pipeline(pipeline)
    compute.set_bind_group(0, group)
    compute.dispatch_workgroups(33)
    compute.end()
    device.queue.submit([encoder.finish()])
    return np.frombuffer(device.queue.read_buffer(buffer), dtype=np.float32)


counts = {}
for texture_format, texels in {
    "r8unorm": np.array([100, 101], dtype=np.uint8),
    "r16float": np.array([100 / 255, 101 / 255], dtype=np.float16),
}.items():
    found = samples(texels, texture_format)
    counts[texture_format] = len(set(found.tolist()))
    print(f"{texture_format}: {counts[texture_format]} different values in {len(found)} samples")
assert counts["r8unorm"] == 2
assert counts["r16float"] > 30
PYTHON
