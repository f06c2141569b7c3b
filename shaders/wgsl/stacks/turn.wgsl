// Turn: the samples of a grid become the layers of a stack along one of its axes.
//
// Prakash, Manohar 1995, section 4: "treat each plane of the volume as a 2D texture".
// With: stacks/values.wgsl or stacks/covered.wgsl

@group(0) @binding(0) var samples: texture_3d<f32>;

// Along which axis of the grid layers follow each other. The two behind it, in turn, lie in a layer.
override AXIS: u32 = 2u;

@compute @workgroup_size(4, 4, 4)
fn cs_turn(@builtin(global_invocation_id) id: vec3u) {
    if any(id >= vec3u(textureDimensions(layers), textureNumLayers(layers))) {
        return;
    }
    var place: vec3u;
    place[(AXIS + 1u) % 3u] = id.x;
    place[(AXIS + 2u) % 3u] = id.y;
    place[AXIS] = id.z;
    textureStore(layers, id.xy, id.z, textureLoad(samples, place, 0));
}
