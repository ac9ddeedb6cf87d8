//! A band of an image's rows: what one task rasterises, a batch of layers at a time.

use super::{
    mask,
    prepare::{Cut, Item, Prepared, Screen, Soup},
    spans::{self, Samples},
};
use crate::{
    math::{Stop, Stopped},
    raster::{Camera, Cutout, Geometry, Holes},
};
use std::ops::Range;

/// What all bands of a frustum share.
pub struct Job<'a> {
    pub geometry: &'a Geometry,
    pub soup: &'a Soup,
    pub prepared: Prepared,
    pub screen: Screen,
    /// Its pixels are the samples.
    pub camera: Camera,
    pub borders: &'a [f64],
    /// 1/border.
    pub inverse: &'a [f64],
    pub samples: Samples,
    /// 64-bit words in a mask's row.
    pub words: usize,
}

/// Some rows of a frustum's image.
pub struct Band {
    pub frustum: usize,
    pub rows: Range<u32>,
    /// Items that may touch it, by first layer.
    items: Vec<u32>,
    /// How many of them have become active, and those that are still so.
    begun: usize,
    active: Vec<u32>,
    /// Masks of the current batch: layer by layer, row by row; filled pixels, later those to keep.
    pub masks: Vec<u64>,
    /// Those of the pixels to keep that are hidden.
    pub hidden: Vec<u64>,
    /// For each row of `masks` four: those whose neighbour on each side is hidden deeper.
    pub inside: Vec<u64>,
}

/// Where a visit finds surface.
pub enum Found<'c> {
    /// Sample columns x0..=x1 of sample row y.
    Samples { layer: u16, y: i32, x0: i32, x1: i32 },
    /// Pixels x0..=x1 of pixel row y, of the layer on either side of a border.
    Cut { layer: u16, y: i32, x0: i32, x1: i32, cut: &'c Cut },
}

impl Band {
    /// The bands of a frustum with their items.
    pub fn split(frustum: usize, height: u32, items: &[Item]) -> Vec<Self> {
        let step = super::hidden::BAND as u32;
        let mut bands: Vec<Self> = (0..height.div_ceil(step))
            .map(|i| Self {
                frustum,
                rows: i * step..((i + 1) * step).min(height),
                items: Vec::new(),
                begun: 0,
                active: Vec::new(),
                masks: Vec::new(),
                hidden: Vec::new(),
                inside: Vec::new(),
            })
            .collect();
        let mut order: Vec<u32> = (0..items.len() as u32).collect();
        order.sort_by_key(|i| items[*i as usize].first);
        for i in order {
            let [from, to] = items[i as usize].rows;
            for band in &mut bands[(from / step) as usize..=(to / step) as usize] {
                band.items.push(i);
            }
        }
        bands
    }

    pub fn height(&self) -> usize {
        self.rows.len()
    }

    /// Fills the masks of layers `batch`. Batches come in ascending order.
    pub fn cover(&mut self, job: &Job, batch: Range<u16>, stop: &Stop) -> Result<(), Stopped> {
        let items = &job.prepared.items;
        self.active.retain(|i| items[*i as usize].last >= batch.start);
        while let Some(i) = self.items.get(self.begun).filter(|i| items[**i as usize].first < batch.end) {
            self.active.push(*i);
            self.begun += 1;
        }
        let (words, height, top) = (job.words, self.height(), self.rows.start as i32);
        let mut masks = std::mem::take(&mut self.masks);
        masks.clear();
        masks.resize(batch.len() * height * words, 0);
        let n = job.samples.0 as i32;
        self.visit(job, &batch, stop, |_, found| {
            let (layer, y, x0, x1) = match found {
                Found::Samples { layer, y, x0, x1 } => (layer, y / n, x0 / n, x1 / n),
                Found::Cut { layer, y, x0, x1, .. } => (layer, y, x0, x1),
            };
            let row = (usize::from(layer - batch.start) * height + (y - top) as usize) * words;
            mask::set_range(&mut masks[row..row + words], x0 as u32, x1 as u32);
        })?;
        self.hidden.resize(masks.len(), 0);
        self.inside.resize(4 * masks.len(), 0);
        self.masks = masks;
        Ok(())
    }

    /// Calls `found` with all surface in layers `batch` on the band's rows, item by item. Holes are left out.
    pub fn visit(
        &self,
        job: &Job,
        batch: &Range<u16>,
        stop: &Stop,
        mut found: impl FnMut(&Item, Found),
    ) -> Result<(), Stopped> {
        let n = job.samples.0 as i32;
        let rows = self.rows.start as i32..self.rows.end as i32;
        let sample_rows = rows.start * n..rows.end * n;
        let mut holes = Holes::seen_by(job.geometry, job.camera);
        for (count, i) in self.active.iter().enumerate() {
            if count % 256 == 0 {
                stop.check()?;
            }
            let item = &job.prepared.items[*i as usize];
            let number = job.soup.numbers[item.source as usize];
            let masked = matches!(job.geometry.draw_of(number).cutout, Cutout::Masked(_));
            let depths = item.depths(job.inverse);
            for piece in job.prepared.pieces(item) {
                spans::cover(piece, job.samples, sample_rows.clone(), job.screen.width as i32 * n, |y, x0, x1| {
                    depths.runs(job.samples, y, x0, x1, |layer, x0, x1| {
                        if !batch.contains(&layer) {
                            return;
                        }
                        if !masked {
                            return found(item, Found::Samples { layer, y, x0, x1 });
                        }
                        for x in x0..=x1 {
                            if holes.solid(number, f64::from(x) + 0.5, f64::from(y) + 0.5) {
                                found(item, Found::Samples { layer, y, x0: x, x1: x });
                            }
                        }
                    });
                });
            }
            let borders = item.cuts();
            for border in (*borders.start()).max(batch.start)..=(*borders.end()).min(batch.end) {
                let triangle = &job.soup.corners[item.source as usize];
                let Some(cut) = Cut::new(triangle, job.borders[usize::from(border)], &job.screen) else { continue };
                spans::touch(cut.ends[0], cut.ends[1], rows.clone(), job.screen.width as i32, |y, x0, x1| {
                    let mut both = |x0: i32, x1: i32| {
                        for layer in border.saturating_sub(1)..=border {
                            if batch.contains(&layer) {
                                found(item, Found::Cut { layer, y, x0, x1, cut: &cut });
                            }
                        }
                    };
                    if !masked {
                        return both(x0, x1);
                    }
                    for x in x0..=x1 {
                        if holes.solid_at(number, cut.nearest(x as u32, y as u32).1) {
                            both(x, x);
                        }
                    }
                });
            }
        }
        Ok(())
    }
}
