//! Samples on the device: one texture, or bricks in the slots of one (§3.1).

use std::collections::HashMap;
use std::sync::{Mutex, PoisonError};

use tetrascope_core::grid::{BrickSource, Region, Samples};
use tetrascope_core::{Error, OpticalModel};
use tetrascope_f32::ScalarMap;
use tetrascope_gpu::wgpu::{self, Extent3d, Origin3d, TextureFormat, TextureUsages};
use tetrascope_gpu::{DeviceGrid, Gpu};

use crate::boxes::{Boxes, Place, places};
use crate::octree::{Visibility, brick_level};
use crate::options::{Level, SlicingOptions, Storage};
use crate::texels::{GAP, MOST, Texels, half_of};

/// The samples of a volume on the device.
#[derive(Debug)]
pub(crate) struct Voxels {
    pub(crate) view: wgpu::TextureView,
    texture: wgpu::Texture,
    pub(crate) texels: Texels,
    slots: Option<Slots>,
    /// Bytes of the texture.
    pub(crate) bytes: u64,
    /// Bytes written when it was made.
    pub(crate) bytes_uploaded: u64,
    budget: u64,
    map: ScalarMap,
    reach: usize,
}

/// A texture's places for bricks, all of one size.
#[derive(Debug)]
struct Slots {
    /// The octree's level that is stored.
    level: u32,
    size: [u32; 3],
    along: [u32; 3],
    count: u32,
    /// Whether all bricks that can show have a slot.
    complete: bool,
    held: Mutex<Held>,
}

/// Which bricks are in which slots.
#[derive(Debug, Default)]
struct Held {
    slot_of: HashMap<usize, u32>,
    brick_in: Vec<Option<usize>>,
}

impl Voxels {
    /// Uploads what can show: all of it if one texture holds it, else bricks, as many as
    /// fit the budget.
    pub(crate) fn new(
        gpu: &Gpu,
        source: &dyn BrickSource,
        boxes: &Boxes,
        visibility: &Visibility,
        map: ScalarMap,
        reach: usize,
        options: &SlicingOptions,
    ) -> Result<Voxels, Error> {
        let texels = Texels::of(gpu, source.sample_type(), options.filtering);
        let dims = source.lattice().dims;
        let budget = options.memory_budget;
        let whole = dims
            .iter()
            .try_fold(texels.bytes, |n, d| n.checked_mul(*d as u64));
        // A quarter is for the copies on their way.
        let fits = whole.is_some_and(|bytes| bytes <= budget / 4 * 3)
            && dims
                .iter()
                .all(|d| *d as u64 <= gpu.limits().max_texture_dimension_3d.into());
        let make = |size: [u32; 3]| {
            let usage = TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_DST;
            let texture =
                gpu.texture_3d("the volume's samples", extent(size), texels.format, usage)?;
            Ok::<_, Error>((texture.create_view(&Default::default()), texture))
        };
        if fits && options.storage == Storage::Auto {
            let bytes = whole.unwrap_or(u64::MAX);
            let (view, texture) = make(dims.map(|d| d as u32))?;
            let mut voxels = Voxels {
                view,
                texture,
                texels,
                slots: None,
                bytes,
                bytes_uploaded: 0,
                budget,
                map,
                reach,
            };
            voxels.upload_all(gpu, source)?;
            return Ok(voxels);
        }
        let slots = Slots::plan(gpu, boxes, visibility, texels, reach, options)?;
        let size = [0, 1, 2].map(|a| slots.size[a] * slots.along[a]);
        let bytes = size.iter().fold(texels.bytes, |n, s| n * u64::from(*s));
        let (view, texture) = make(size)?;
        let complete = slots.complete;
        let mut voxels = Voxels {
            view,
            texture,
            texels,
            slots: Some(slots),
            bytes,
            bytes_uploaded: 0,
            budget,
            map,
            reach,
        };
        if complete {
            voxels.bytes_uploaded = voxels.upload_visible(gpu, source, boxes, visibility)?;
        }
        Ok(voxels)
    }

    /// Those of a grid that is on the device already, for `model`: nothing is uploaded.
    pub(crate) fn on_device(grid: &DeviceGrid, model: OpticalModel) -> Voxels {
        Voxels {
            view: grid.texture().create_view(&Default::default()),
            texture: grid.texture().clone(),
            texels: Texels::on_device(grid.texels(), model),
            slots: None,
            bytes: grid.bytes(),
            bytes_uploaded: 0,
            budget: 0,
            map: ScalarMap::from_low(0.0),
            reach: 0,
        }
    }

    /// The least level that boxes may have: a box must lie in one brick.
    pub(crate) fn least_level(&self) -> u32 {
        self.slots.as_ref().map_or(0, |s| s.level)
    }

    /// Whether everything that can show is on the device.
    pub(crate) fn is_complete(&self) -> bool {
        self.slots.as_ref().is_none_or(|s| s.complete)
    }

    /// The offset from the index of a sample in a box to its texel, if it is on the device.
    pub(crate) fn texel(&self, boxes: &Boxes, level: u32, place: Place) -> Option<[i32; 3]> {
        let Some(slots) = &self.slots else {
            return Some([0; 3]);
        };
        let brick = boxes.ancestor(level, place, slots.level);
        let held = slots.held.lock().unwrap_or_else(PoisonError::into_inner);
        let slot = *held.slot_of.get(&boxes.index(slots.level, brick))?;
        let region = boxes.region(slots.level, brick, self.reach)?;
        let origin = slots.origin(slot);
        Some([0, 1, 2].map(|a| origin[a] as i32 - region.low[a] as i32))
    }

    /// Splits the boxes that are `drawn`, back to front, into runs whose bricks fit on the device together.
    pub(crate) fn batches(&self, boxes: &Boxes, level: u32, drawn: &[Place]) -> Vec<usize> {
        let Some(slots) = self.slots.as_ref().filter(|s| !s.complete) else {
            return vec![drawn.len()];
        };
        let mut ends = Vec::new();
        let mut bricks = std::collections::HashSet::new();
        for (i, place) in drawn.iter().enumerate() {
            let brick = boxes.ancestor(level, *place, slots.level);
            let brick = boxes.index(slots.level, brick);
            if !bricks.contains(&brick) && bricks.len() == slots.count as usize {
                ends.push(i);
                bricks.clear();
            }
            bricks.insert(brick);
        }
        ends.push(drawn.len());
        ends
    }

    /// Brings the bricks of `drawn`, one of the [`Voxels::batches`], onto the device.
    /// Returns the bytes written. What was drawn from the slots before must be submitted.
    pub(crate) fn stream(
        &self,
        gpu: &Gpu,
        source: &dyn BrickSource,
        boxes: &Boxes,
        level: u32,
        drawn: &[Place],
    ) -> Result<u64, Error> {
        let Some(slots) = self.slots.as_ref().filter(|s| !s.complete) else {
            return Ok(0);
        };
        let mut held = slots.held.lock().unwrap_or_else(PoisonError::into_inner);
        let mut wanted: Vec<(usize, Place)> = Vec::new();
        for place in drawn {
            let brick = boxes.ancestor(level, *place, slots.level);
            let index = boxes.index(slots.level, brick);
            // A brick's boxes are neighbors in the order.
            if wanted.last().is_none_or(|(last, _)| *last != index) {
                wanted.push((index, brick));
            }
        }
        let keep: std::collections::HashSet<usize> = wanted.iter().map(|w| w.0).collect();
        let mut free: Vec<u32> = (0..slots.count)
            .filter(|s| held.brick_in[*s as usize].is_none_or(|b| !keep.contains(&b)))
            .collect();
        let mut writer = Writer::new(self.budget / 4);
        for (index, brick) in wanted {
            if held.slot_of.contains_key(&index) {
                continue;
            }
            let slot = free.pop().expect("a batch has no more bricks than slots");
            if let Some(old) = held.brick_in[slot as usize].take() {
                held.slot_of.remove(&old);
            }
            let bytes = self.upload_brick(gpu, source, boxes, slots, brick, slot)?;
            writer.wrote(gpu, bytes)?;
            held.slot_of.insert(index, slot);
            held.brick_in[slot as usize] = Some(index);
        }
        Ok(writer.total)
    }

    fn upload_brick(
        &self,
        gpu: &Gpu,
        source: &dyn BrickSource,
        boxes: &Boxes,
        slots: &Slots,
        brick: Place,
        slot: u32,
    ) -> Result<u64, Error> {
        let region = boxes.region(slots.level, brick, self.reach);
        let Some(region) = region else {
            return Ok(0);
        };
        self.upload(gpu, source.read(region)?, slots.origin(slot), region.size)
    }

    fn upload_visible(
        &self,
        gpu: &Gpu,
        source: &dyn BrickSource,
        boxes: &Boxes,
        visibility: &Visibility,
    ) -> Result<u64, Error> {
        let Some(slots) = &self.slots else {
            return Ok(0);
        };
        let mut held = slots.held.lock().unwrap_or_else(PoisonError::into_inner);
        let mut writer = Writer::new(self.budget / 4);
        for place in places(boxes.divisions(slots.level)) {
            let index = boxes.index(slots.level, place);
            if !visibility.contains(slots.level, index) {
                continue;
            }
            let slot = held.slot_of.len() as u32;
            let bytes = self.upload_brick(gpu, source, boxes, slots, place, slot)?;
            writer.wrote(gpu, bytes)?;
            held.slot_of.insert(index, slot);
            held.brick_in[slot as usize] = Some(index);
        }
        Ok(writer.total)
    }

    fn upload_all(&mut self, gpu: &Gpu, source: &dyn BrickSource) -> Result<(), Error> {
        let dims = source.lattice().dims;
        let mut writer = Writer::new(self.budget / 4);
        let plane = self.texels.bytes * (dims[0] * dims[1]) as u64;
        // As many planes at a time as fit what is left of the budget, and at least one.
        let planes = (self.budget / 8 / plane).clamp(1, dims[2] as u64) as usize;
        let mut z = 0;
        while z < dims[2] {
            let depth = planes.min(dims[2] - z);
            let region = Region {
                low: [0, 0, z],
                size: [dims[0], dims[1], depth],
            };
            let samples = source.read(region)?;
            let bytes = self.upload(gpu, samples, [0, 0, z as u32], region.size)?;
            writer.wrote(gpu, bytes)?;
            z += depth;
        }
        self.bytes_uploaded = writer.total;
        Ok(())
    }

    fn upload(
        &self,
        gpu: &Gpu,
        samples: Samples,
        origin: [u32; 3],
        size: [usize; 3],
    ) -> Result<u64, Error> {
        let write = |bytes: &[u8]| {
            let [x, y, z] = origin;
            let at = Origin3d { x, y, z };
            let size = extent(size.map(|s| s as u32));
            gpu.write_texels(&self.texture, at, size, bytes)?;
            Ok(bytes.len() as u64)
        };
        match samples {
            Samples::U8(v) => match self.texels.format {
                TextureFormat::R16Unorm => {
                    let wide: Vec<u16> = v.iter().map(|s| 257 * u16::from(*s)).collect();
                    write(bytemuck::cast_slice(&wide))
                }
                TextureFormat::R16Float => {
                    let halves: Vec<u16> = v.iter().map(|s| half_of(*s)).collect();
                    write(bytemuck::cast_slice(&halves))
                }
                _ => write(&v),
            },
            Samples::U16(v) => write(bytemuck::cast_slice(&v)),
            Samples::I16(v) => write(bytemuck::cast_slice(&v)),
            Samples::F32(mut v) => {
                for sample in &mut v {
                    *sample = if sample.is_finite() {
                        self.map.scalar(f64::from(*sample)).clamp(-MOST, MOST)
                    } else {
                        GAP
                    };
                }
                write(bytemuck::cast_slice(&v))
            }
            _ => Err(Error::invalid("samples of an unknown type")),
        }
    }
}

impl Slots {
    /// Slots for all bricks that can show or, if the budget has no room, as many as it has.
    fn plan(
        gpu: &Gpu,
        boxes: &Boxes,
        visibility: &Visibility,
        texels: Texels,
        reach: usize,
        options: &SlicingOptions,
    ) -> Result<Slots, Error> {
        let budget = options.memory_budget;
        let samples = |cells: [usize; 3]| cells.map(|s| (s + 1 + 2 * reach) as u32);
        let bytes = |cells| {
            let sides = samples(cells).map(u64::from).into_iter();
            sides.fold(texels.bytes, u64::saturating_mul)
        };
        // Half is for the copies on their way.
        let room = budget / 2;
        let level = match options.brick_level {
            Level::Fixed(level) => level.min(boxes.deepest()),
            Level::Auto => brick_level(boxes, |cells| bytes(cells) <= room),
        };
        let size = samples(boxes.box_size(level));
        let bytes = bytes(boxes.box_size(level));
        let needed = visibility.count(level).max(1) as u64;
        let most = room / bytes;
        if most == 0 {
            return Err(Error::TooLarge {
                what: format!("one brick of {size:?} samples and its copy"),
                needed: bytes.saturating_mul(2),
                limit: budget,
                unit: "bytes",
            });
        }
        let limit = u64::from(gpu.limits().max_texture_dimension_3d);
        let room = size.map(|s| limit / u64::from(s));
        let wanted = needed.min(most);
        let [across, down, deep] = room.map(|n| n.max(1));
        // As few layers, and rows in each, as there can be; then none longer than needed.
        let z = wanted.div_ceil(across * down).min(deep);
        let layer = wanted.div_ceil(z).min(across * down);
        let y = layer.div_ceil(across).min(most / z);
        let x = layer.div_ceil(y).min(most / (y * z));
        let count = x * y * z;
        if room.contains(&0) {
            return Err(Error::TooLarge {
                what: format!("a brick of {size:?} samples"),
                needed: size.into_iter().max().unwrap_or(0).into(),
                limit,
                unit: "texels a side",
            });
        }
        Ok(Slots {
            level,
            size,
            along: [x, y, z].map(|n| n as u32),
            count: count as u32,
            complete: count >= needed,
            held: Mutex::new(Held {
                slot_of: HashMap::new(),
                brick_in: vec![None; count as usize],
            }),
        })
    }

    /// The first texel of a slot.
    fn origin(&self, slot: u32) -> [u32; 3] {
        let [x, y, _] = self.along;
        let place = [slot % x, slot / x % y, slot / (x * y)];
        [0, 1, 2].map(|a| place[a] * self.size[a])
    }
}

/// Lets the device do its copies before more than `most` bytes wait for it.
struct Writer {
    most: u64,
    waiting: u64,
    total: u64,
}

impl Writer {
    fn new(most: u64) -> Writer {
        Writer {
            most,
            waiting: 0,
            total: 0,
        }
    }

    fn wrote(&mut self, gpu: &Gpu, bytes: u64) -> Result<(), Error> {
        self.total += bytes;
        self.waiting += bytes;
        if self.waiting > self.most / 2 {
            self.waiting = 0;
            gpu.finish(gpu.device().create_command_encoder(&Default::default()))?;
        }
        Ok(())
    }
}

fn extent([width, height, depth]: [u32; 3]) -> Extent3d {
    Extent3d {
        width,
        height,
        depth_or_array_layers: depth,
    }
}
