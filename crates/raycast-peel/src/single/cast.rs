//! The dispatches of a frame: what they share, and what is recorded for each.

use tetrascope_core::glam::DAffine3;
use tetrascope_core::{Error, View};
use tetrascope_f32::Rays;
use tetrascope_f32::look::look;
use tetrascope_f32::tiles::TILE;
use tetrascope_gpu::Sums;
use tetrascope_gpu::wgpu::{self, BindGroup, BindingResource, BufferUsages, CommandEncoder};

use super::frame::Found;
use super::{LABEL, Single, layers, view_of};
use crate::gpu_data::{Counters, Progress, State};

/// Rays whose states are on the device at a time, unless one row of tiles has more: 31 MB.
const MOST_STATES: u32 = 1 << 17;

/// The targets that a frame is cast into, and the depths at which its rays end.
pub(super) struct Targets<'a> {
    pub(super) sums: &'a Sums,
    pub(super) ends: &'a wgpu::TextureView,
    /// Whether they do.
    pub(super) has_ends: bool,
}

/// Data that all dispatches of a frame share.
pub(super) struct Cast<'a> {
    single: &'a Single,
    pipeline: wgpu::ComputePipeline,
    groups: [BindGroup; 3],
    pub(super) counters: wgpu::Buffer,
    /// Columns of tiles.
    columns: u32,
    rows: u32,
}

/// Rows of tiles that are drawn to the end before others.
#[derive(Clone, Copy, Debug)]
pub(super) struct Band {
    first: u32,
    rows: u32,
}

/// How many tiles a dispatch casts the rays of.
pub(super) enum Size<'a> {
    Band(Band),
    /// As many as the dispatch before left rays in says.
    Left(&'a wgpu::Buffer),
}

impl<'a> Cast<'a> {
    /// With `resumes`, for rays that go on from dispatch to dispatch among trees.
    pub(super) fn new(
        single: &'a Single,
        view: &View,
        rays: &Rays,
        found: &Found,
        targets: &Targets,
        resumes: bool,
    ) -> Result<Cast<'a>, Error> {
        let Single {
            gpu, mesh, style, ..
        } = single;
        let image = view_of(&targets.sums.color);
        let distances = view_of(
            targets
                .sums
                .distances
                .as_ref()
                .unwrap_or(&single.no_distances),
        );
        let mut march = single.march(view, rays);
        let (lists, layers) = match found {
            Found::Lists(lists) => (Some(lists), layers::none(gpu)?),
            Found::Layers(layers, lists) => {
                march.layers = layers.count;
                if lists.is_some() {
                    march.listed_from = layers.count;
                }
                (lists.as_ref(), layers.view())
            }
        };
        let uniform = gpu.upload("raycast-peel::march", &[march], BufferUsages::STORAGE)?;
        let storage = BufferUsages::STORAGE;
        let lists = lists.map_or(&[][..], |tiles| &tiles.lists);
        let faces = gpu.upload("raycast-peel::tile_faces", lists, storage)?;
        let (look, items) = look(
            &style.appearance,
            view,
            &mesh.domain.bounds,
            &mesh.normalization,
            &mesh.scalar_map,
            &DAffine3::IDENTITY,
        );
        let look = look.with_tables(style.interval_count, style.table.span());
        let look = gpu.upload("raycast-peel::look", &[look], BufferUsages::UNIFORM)?;
        let items = gpu.upload("raycast-peel::look_items", &items, storage)?;
        let usage = storage | BufferUsages::COPY_SRC;
        let counters = gpu.upload("raycast-peel::counters", &[Counters::default()], usage)?;
        let pipeline = style.pipeline(gpu, resumes, targets.has_ends)?;
        let views = mesh.textures().map(view_of);
        let intervals = view_of(&style.intervals);
        gpu.checked(LABEL, 0, || {
            let frame = [
                uniform.as_entire_binding(),
                BindingResource::TextureView(&image),
                counters.as_entire_binding(),
                faces.as_entire_binding(),
                BindingResource::TextureView(&distances),
                look.as_entire_binding(),
                items.as_entire_binding(),
                BindingResource::TextureView(&layers),
                BindingResource::TextureView(targets.ends),
            ];
            let volume = views.each_ref().map(BindingResource::TextureView);
            let function = [
                BindingResource::TextureView(&intervals),
                style.table.binding(),
            ];
            let groups = [&frame[..], &volume, &function];
            let mut index = 0..;
            let groups = groups.map(|resources| {
                let index = index.next().expect("there is no last number");
                group(single, &pipeline, index, resources)
            });
            Cast {
                single,
                pipeline,
                groups,
                counters: counters.clone(),
                columns: view.width.div_ceil(TILE),
                rows: view.height.div_ceil(TILE),
            }
        })
    }

    /// All of the picture.
    pub(super) fn whole(&self) -> Band {
        Band {
            first: 0,
            rows: self.rows,
        }
    }

    /// The picture in parts whose states there is room for.
    pub(super) fn bands(&self) -> Vec<Band> {
        let rays = self.columns * TILE * TILE;
        let rows = (MOST_STATES / rays).clamp(1, self.rows);
        let band = |first| Band {
            first,
            rows: rows.min(self.rows - first),
        };
        (0..self.rows).step_by(rows as usize).map(band).collect()
    }

    /// Room for the states of the first band, which is the largest.
    pub(super) fn states(&self, bands: &[Band]) -> Result<wgpu::Buffer, Error> {
        let rows = bands.first().map_or(0, |band| band.rows);
        let rays = u64::from(self.columns * TILE) * u64::from(rows * TILE);
        self.room(rays)
    }

    /// Room for the states of so many rays.
    pub(super) fn room(&self, rays: u64) -> Result<wgpu::Buffer, Error> {
        let bytes = rays * size_of::<State>() as u64;
        let usage = BufferUsages::STORAGE;
        self.single.gpu.buffer("raycast-peel::states", bytes, usage)
    }

    /// The buffer with which a dispatch of `band` knows and counts its progress.
    pub(super) fn progress(
        &self,
        band: Band,
        goes_on: bool,
        is_last: bool,
    ) -> Result<wgpu::Buffer, Error> {
        let progress = Progress {
            goes_on: u32::from(goes_on),
            is_last: u32::from(is_last),
            first_row: band.first * TILE,
            ..Progress::default()
        };
        let usage = BufferUsages::STORAGE | BufferUsages::INDIRECT | BufferUsages::COPY_SRC;
        self.single
            .gpu
            .upload("raycast-peel::progress", &[progress], usage)
    }

    /// Records one dispatch.
    pub(super) fn record(
        &self,
        encoder: &mut CommandEncoder,
        size: Size,
        progress: &wgpu::Buffer,
        states: &wgpu::Buffer,
    ) -> Result<(), Error> {
        self.single.gpu.checked(LABEL, 0, || {
            let resources = [progress.as_entire_binding(), states.as_entire_binding()];
            let last = group(self.single, &self.pipeline, 3, &resources);
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
                label: Some(LABEL),
                timestamp_writes: None,
            });
            pass.set_pipeline(&self.pipeline);
            for (index, group) in (0..).zip(self.groups.iter().chain([&last])) {
                pass.set_bind_group(index, group, &[]);
            }
            match size {
                Size::Band(band) => pass.dispatch_workgroups(self.columns, band.rows, 1),
                Size::Left(left) => pass.dispatch_workgroups_indirect(left, 0),
            }
        })
    }
}

fn group(
    single: &Single,
    pipeline: &wgpu::ComputePipeline,
    index: u32,
    resources: &[BindingResource],
) -> BindGroup {
    let layout = pipeline.get_bind_group_layout(index);
    tetrascope_gpu::passes::group(&single.gpu, LABEL, &layout, resources)
}
