//! T1 and T2 of section 2.1: the weights of what is on a cell's back and front face.

use tetrascope_core::Error;
use tetrascope_gpu::Gpu;
use tetrascope_gpu::wgpu::{self, TextureFormat, TextureUsages};

/// A weight and an alpha.
pub(crate) type Texel = [f32; 2];

/// T1 and T2, `side`² texels each, row by row: i is the texel's number in its row.
///
/// p/(p+q) and 1 − p/(p+q) where p and q are positive, with an alpha of 1, and 0 elsewhere. The
/// paper takes p = 2i/N − 1, at the texel's lower corner; here it is the middle, 2(i + ½)/N − 1. So
/// no weight is 0/0, which the paper's is at p = q = 0, none with an alpha of 1 is 0, and p and q are off
/// by half a texel at most.
pub(crate) fn weights(side: u32) -> [Vec<Texel>; 2] {
    let half = side / 2;
    let place = |i: u32| (f64::from(i) + 0.5) / f64::from(half) - 1.0;
    let texels = (0..side).flat_map(|j| (0..side).map(move |i| (i, j)));
    let luminance = texels.map(|(i, j)| {
        let (p, q) = (place(i), place(j));
        (i >= half && j >= half).then(|| p / (p + q))
    });
    let of_back: Vec<Option<f64>> = luminance.collect();
    let texel = |weight: Option<f64>| weight.map_or([0.0; 2], |weight| [weight as f32, 1.0]);
    let of_front = of_back.iter().map(|weight| texel(weight.map(|w| 1.0 - w)));
    let of_front = of_front.collect();
    [of_back.into_iter().map(texel).collect(), of_front]
}

/// T1 and T2 on the device, and what samples them: the nearest texel, clamped to the edge, beyond
/// which one of the coordinates is negative.
pub(crate) fn upload(gpu: &Gpu, side: u32) -> Result<([wgpu::Texture; 2], wgpu::Sampler), Error> {
    let usage = TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_DST;
    let upload = |texels: Vec<Texel>| -> Result<wgpu::Texture, Error> {
        let format = TextureFormat::Rg32Float;
        let texture = gpu.texture("resample::weights", (side, side), format, usage)?;
        gpu.write_texture(&texture, &texels)?;
        Ok(texture)
    };
    let [of_back, of_front] = weights(side);
    let textures = [upload(of_back)?, upload(of_front)?];
    let nearest = gpu.checked("resample::weights", 0, || {
        gpu.device().create_sampler(&wgpu::SamplerDescriptor {
            label: Some("resample::weights"),
            ..Default::default()
        })
    })?;
    Ok((textures, nearest))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A fragment gets the interpolant from both textures, off by half a texel of p and q.
    #[test]
    fn weights_are_off_by_half_a_texel() {
        for side in [32, 64, 256, 1024] {
            let [of_back, of_front] = weights(side);
            assert_eq!(of_back.len() as u32, side * side);
            // p and q are shares of 1, off by a and b of at most h = 1/N from p' and q' of a texel's
            // middle. The weight is off by |p' b − q' a| / ((p + q)(p' + q')); and the scalar by p + q
            // times as much at most, as is the difference of the faces' scalars: by h.
            let h = 1.0 / f64::from(side);
            let mut worst = 0.0_f64;
            for (p, q) in (0..200).flat_map(|i| (0..200).map(move |j| (i, j))) {
                let [p, q] = [p, q].map(|i| (f64::from(i) + 0.37) / 200.0);
                let texel = |p: f64| ((0.5 + 0.5 * p) * f64::from(side)).floor() as u32;
                let at = (texel(p) + side * texel(q)) as usize;
                let [back, front] = [of_back[at], of_front[at]];
                assert_eq!([back[1], front[1]], [1.0; 2]);
                assert!((f64::from(back[0]) + f64::from(front[0]) - 1.0).abs() <= 1e-7);
                let off = (f64::from(back[0]) - p / (p + q)).abs() * (p + q).min(1.0);
                worst = worst.max(off);
            }
            eprintln!("{side}: {:.3} texels", worst / h);
            assert!(worst <= h + 1e-7 && worst > 0.5 * h, "{side}: {worst}");
        }
        // Nothing is drawn where u or v is negative.
        let [of_back, of_front] = weights(32);
        for (at, texels) in of_back.iter().zip(&of_front).enumerate() {
            let (i, j) = (at % 32, at / 32);
            let alpha = if i >= 16 && j >= 16 { 1.0 } else { 0.0 };
            assert_eq!([texels.0[1], texels.1[1]], [alpha; 2]);
            assert!((texels.0[0] > 0.0) == (alpha > 0.0) && (texels.1[0] > 0.0) == (alpha > 0.0));
        }
    }
}
