#!/usr/bin/env bash
# SwiftShader never has memory for a buffer of the greatest size that it reports, whatever the machine has.
#
# Guess:    a buffer of `max_buffer_size` bytes can be made where memory is free; limits of an adapter are usable values.
# Behavior: 1 GiB is reported, for buffers and for the bindings of storage buffers. A buffer of 1 GiB, or of 4 bytes less, is out
#           of memory; one of 16 bytes less is made. Who fills buffers up to the limit fails on this driver alone.
# Seen:     SwiftShader (Subzero) of Chromium 156.0.8078.108, Debian 12, 21 GiB of memory free; wgpu 0.32.0 from the Python
#           index. llvmpipe of Mesa 22.3.6 reports 2³¹ − 1 and makes a buffer of that size.
# Output:   1073741824 reported; refused: 0, 4; made: 16, 4096 bytes less
#
# Needs Debian's chromium, whose driver it chooses. Fails if a buffer of the greatest size is made, or one of 16 bytes less
# is not.
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet wgpu==0.32.0
export XDG_RUNTIME_DIR="$folder"
export VK_DRIVER_FILES=${VK_DRIVER_FILES:-/usr/lib/chromium/vk_swiftshader_icd.json}

"$folder/venv/bin/python" - <<'PYTHON'
import wgpu

adapter = wgpu.gpu.request_adapter_sync()
print(adapter.info["device"], "-", adapter.info["description"])
assert "SwiftShader" in adapter.info["device"], "this is about SwiftShader; choose it with VK_DRIVER_FILES"
greatest = adapter.limits["max-buffer-size"]
device = adapter.request_device_sync(required_limits={"max-buffer-size": greatest})


def is_made(size):
    """Whether there is memory for a buffer of this size; it is given back at once."""
    try:
        buffer = device.create_buffer(size=size, usage=wgpu.BufferUsage.STORAGE)
    except wgpu.GPUError as error:
        assert "memory" in str(error), error
        return False
    buffer.destroy()
    return True


less = {by: is_made(greatest - by) for by in (0, 4, 16, 4096)}
refused = ", ".join(str(by) for by, made in less.items() if not made)
made = ", ".join(str(by) for by, made in less.items() if made)
print(f"{greatest} reported; refused: {refused}; made: {made} bytes less")
assert less == {0: False, 4: False, 16: True, 4096: True}, less
PYTHON
