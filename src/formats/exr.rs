//! Layers of depths as OpenEXR: one part for each, with one channel `Z` of 32-bit floats.

use super::FormatError;
use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, ImageAttributes, IntegerBounds, Layer, LayerAttributes,
    Vec2, WritableImage,
};

/// Layers that lie in a window of an image.
pub struct Depths<'a> {
    /// Of the whole image, pixels.
    pub size: [u32; 2],
    /// x, y, width, height of the window.
    pub window: [u32; 4],
    /// The layers' names and depths, row by row.
    pub layers: &'a [(String, Vec<f32>)],
}

/// # Errors
/// Where there is no layer, or the encoder refuses what it is given.
pub fn write_depths(depths: &Depths) -> Result<Vec<u8>, FormatError> {
    let refuse = |what: String| FormatError::Unwritable { object: "layers of depths".into(), what };
    let [x, y, width, height] = depths.window.map(|n| n as usize);
    let layer = |(name, samples): &(String, Vec<f32>)| {
        let attributes =
            LayerAttributes { layer_position: Vec2(x as i32, y as i32), ..LayerAttributes::named(name.as_str()) };
        let channel = AnyChannel::new("Z", FlatSamples::F32(samples.clone()));
        Layer::new(
            (width, height),
            attributes,
            Encoding::SMALL_LOSSLESS,
            AnyChannels::sort([channel].into_iter().collect()),
        )
    };
    if let Some((name, samples)) = depths.layers.iter().find(|l| l.1.len() != width * height) {
        return Err(refuse(format!("{} depths in {name} for {width} × {height} pixels", samples.len())));
    }
    let window = IntegerBounds::new((0, 0), (depths.size[0] as usize, depths.size[1] as usize));
    let layers: Vec<_> = depths.layers.iter().map(layer).collect();
    let mut bytes = std::io::Cursor::new(Vec::new());
    // On one thread: the parts of a file lie in the order in which they were compressed.
    let image = Image::from_layers(ImageAttributes::new(window), layers);
    image.write().non_parallel().to_buffered(&mut bytes).map_err(|e| refuse(e.to_string()))?;
    Ok(bytes.into_inner())
}

#[cfg(test)]
mod tests {
    use super::*;
    use exr::prelude::{ReadChannels, ReadLayers};

    #[test]
    fn layers_read_back() {
        let layer = |k: f32| (0..12).map(|i| i as f32 * 0.01 + k).collect::<Vec<f32>>();
        let layers = [("depth 0".to_owned(), layer(0.0)), ("depth 1".to_owned(), layer(0.5))];
        let bytes = write_depths(&Depths { size: [9, 8], window: [2, 3, 4, 3], layers: &layers }).unwrap();
        let reader =
            exr::prelude::read().no_deep_data().largest_resolution_level().all_channels().all_layers().all_attributes();
        let image = reader.from_buffered(std::io::Cursor::new(&bytes)).unwrap();
        assert_eq!(image.attributes.display_window, IntegerBounds::new((0, 0), (9, 8)));
        assert_eq!(image.layer_data.len(), 2);
        for (read, (name, samples)) in image.layer_data.iter().zip(&layers) {
            assert_eq!(read.attributes.layer_name.as_ref().unwrap().to_string(), *name);
            assert_eq!((read.attributes.layer_position, read.size), (Vec2(2, 3), Vec2(4, 3)));
            let [channel] = &read.channel_data.list[..] else { panic!() };
            assert_eq!(
                (channel.name.to_string(), &channel.sample_data),
                ("Z".to_owned(), &FlatSamples::F32(samples.clone()))
            );
        }
        let short = [("a".to_owned(), vec![0.5])];
        let refused = write_depths(&Depths { size: [9, 8], window: [2, 3, 4, 3], layers: &short }).unwrap_err();
        assert!(refused.to_string().contains("1 depths in a"), "{refused}");
        assert!(write_depths(&Depths { size: [9, 8], window: [2, 3, 4, 3], layers: &[] }).is_err());
    }
}
