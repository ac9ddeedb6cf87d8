use super::*;
use crate::image::srgb;
use proptest::prelude::*;

fn level(width: u32, texels: Vec<[u8; 4]>) -> Level {
    Level { width, height: texels.len() as u32 / width, texels }
}

#[test]
fn colours_are_averaged_as_light() {
    let base = level(2, vec![[255, 0, 255, 255], [0, 0, 255, 255]]);
    let mips = chain(&base, &[255; 2], Rule::Color, 9);
    assert_eq!(mips.len(), 2);
    // Half of the light is 188 of 255, not 128.
    assert_eq!(mips[1].texels, [[188, 0, 255, 255]]);
    assert_eq!(chain(&base, &[255; 2], Rule::Data, 9)[1].texels, [[128, 0, 255, 255]]);
}

#[test]
fn empty_texels_darken_nothing() {
    // One bright texel in a corner of black, empty ones.
    let mut texels = vec![[0; 4]; 64];
    texels[9] = [200, 150, 100, 255];
    let weight: Vec<u8> = texels.iter().map(|t| t[3]).collect();
    let mips = chain(&level(8, texels), &weight, Rule::Color, 9);
    assert_eq!(mips.iter().map(|m| m.width).collect::<Vec<_>>(), [8, 4, 2, 1]);
    for mip in &mips {
        assert!(mip.texels.iter().all(|t| t[..3] == [200, 150, 100]), "{mip:?}");
    }
    // A 64th of 255.
    assert_eq!(mips[3].texels[0][3], 4);
    assert_eq!(mips[1].texels.iter().map(|t| t[3]).collect::<Vec<_>>()[..2], [64, 0]);
}

#[test]
fn an_image_without_a_known_texel_stays() {
    let mips = chain(&level(4, vec![[9, 8, 7, 0]; 8]), &[0; 8], Rule::Color, 9);
    assert_eq!(mips[0].texels, [[9, 8, 7, 0]; 8]);
    assert_eq!(mips.len(), 3);
}

#[test]
fn cutouts_keep_their_area() {
    // Every fourth column is a grass blade of one texel: all of it is gone on the third level where alpha is only averaged.
    let texels: Vec<[u8; 4]> = (0..1024).map(|i| [50, 200, 50, if i % 4 == 1 { 255 } else { 0 }]).collect();
    let weight: Vec<u8> = texels.iter().map(|t| t[3]).collect();
    let passing = |rule| {
        let mips = chain(&level(32, texels.clone()), &weight, rule, 9);
        let share = |m: &Level| m.texels.iter().filter(|t| t[3] >= 128).count() as f64 / m.texels.len() as f64;
        mips.iter().map(share).collect::<Vec<_>>()
    };
    let (plain, kept) = (passing(Rule::Color), passing(Rule::Cutout { cutoff: 128 }));
    assert_eq!((plain[0], plain[2]), (0.25, 0.0));
    assert!(kept[..2].iter().all(|s| (0.25..=0.5).contains(s)), "{kept:?}");
}

#[test]
fn alpha_that_just_passes_does_so_on_every_level() {
    let texels: Vec<[u8; 4]> = (0..256_u32).map(|i| [9, 9, 9, (i.wrapping_mul(2_654_435_761) >> 24) as u8]).collect();
    let base = level(16, texels);
    for cutoff in [1, 77, 128, 255] {
        let mips = chain(&base, &[255; 256], Rule::Cutout { cutoff }, 9);
        let pass = |m: &Level| m.texels.iter().filter(|t| t[3] >= cutoff).count() as f64 / m.texels.len() as f64;
        let share = pass(&mips[0]);
        for mip in &mips[1..] {
            let n = mip.texels.len() as f64;
            assert!((pass(mip) - share).abs() <= 0.5 / n + 1e-9, "{cutoff}: {} of {share} at {n}", pass(mip));
        }
    }
}

#[test]
fn normals_stay_unit_vectors() {
    let tilted = |x: f32| [(x * 127.0 + 127.0).round() as u8, 127, 0, 255];
    let mips = chain(&level(2, vec![tilted(0.6), tilted(-0.6)]), &[255; 2], Rule::Normal, 9);
    assert_eq!(mips[1].texels, [[127, 127, 254, 255]]);
    // (0.6, 0, 0.8) and (0, 0, 1): halfway in angle.
    let mips = chain(&level(2, vec![tilted(0.6), tilted(0.0)]), &[255; 2], Rule::Normal, 9);
    let expected = (libm::asinf(0.6) / 2.0, mips[1].texels[0]);
    assert!((f32::from(expected.1[0]) - 127.0 - 127.0 * libm::sinf(expected.0)).abs() < 1.0);
    // Empty texels do not flatten it.
    let mips = chain(&level(2, vec![tilted(0.6), [0; 4]]), &[255, 0], Rule::Normal, 9);
    assert_eq!(mips[1].texels[0][..2], [203, 127]);
}

#[test]
fn depths_keep_the_nearest_surface() {
    let base = Level { width: 3, height: 2, texels: vec![9, 8, 7, 6, 90, 2] };
    let mips = chain16(&base, u16::min, 9);
    assert_eq!(mips[1], Level { width: 1, height: 1, texels: vec![2] });
    assert_eq!(chain16(&base, u16::max, 9)[1].texels, [90]);
    assert_eq!(chain16(&base, u16::max, 1).len(), 1);
}

proptest! {
    /// Whatever the size, a level is the mean over areas: computed here from the definition, texel by texel.
    #[test]
    fn means_are_over_areas(width in 1..12_u32, height in 1..12_u32, values in prop::collection::vec(any::<[u8; 4]>(), 144), weights in prop::collection::vec(any::<u8>(), 144)) {
        let n = (width * height) as usize;
        let base = Level { width, height, texels: values[..n].to_vec() };
        let mips = chain(&base, &weights[..n], Rule::Color, 2);
        let Some(next) = mips.get(1) else {
            prop_assert_eq!(n, 1);
            return Ok(());
        };
        let overlap = |side: u32, half: u32, x: u32, u: u32| {
            let scale = f64::from(side) / f64::from(half);
            let (a, b) = (f64::from(x) * scale, f64::from(x + 1) * scale);
            (b.min(f64::from(u + 1)) - a.max(f64::from(u))).max(0.0)
        };
        for y in 0..next.height {
            for x in 0..next.width {
                let (mut light, mut weight, mut alpha, mut area) = (0.0, 0.0, 0.0, 0.0);
                for v in 0..height {
                    for u in 0..width {
                        let share = overlap(width, next.width, x, u) * overlap(height, next.height, y, v);
                        let i = (v * width + u) as usize;
                        light += share * f64::from(weights[i]) * f64::from(srgb::to_linear(values[i][0]));
                        weight += share * f64::from(weights[i]);
                        alpha += share * f64::from(values[i][3]);
                        area += share;
                    }
                }
                let found = next.texels[(y * next.width + x) as usize];
                prop_assert!((f64::from(found[3]) - alpha / area).abs() < 0.51);
                if weight > 0.0 {
                    prop_assert!(found[0].abs_diff(srgb::from_linear((light / weight) as f32)) <= 1);
                }
            }
        }
    }

    #[test]
    fn any_number_of_threads_gives_the_same(width in 1..40_u32, height in 1..40_u32) {
        let base = image(width, height, 3);
        let weight: Vec<u8> = base.texels.iter().map(|t| t[1]).collect();
        let with = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| chain(&base, &weight, Rule::Cutout { cutoff: 100 }, 9))
        };
        prop_assert_eq!(with(1), with(3));
    }
}
