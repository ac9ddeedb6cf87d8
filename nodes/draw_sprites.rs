//! `draw-sprites`: a picture of a scene with effects of depth sprites.

use super::{
    values::Sprite,
    volumes::{self, SpritePlace, unknown},
};
use crate::{
    engine::{
        node::{Ctx, List, Node, NodeError},
        plan::File,
    },
    image::{encode_png, srgb},
    ports,
    raster::{Geometry, Light, MAX_SIDE, Shader},
    scene::{Scene, select::matches},
    sprite::{self, Drawing, Volume, Zone, draw},
    view::View,
};
use glam::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Draws a scene whose points look different inside, on the border of, or outside depth sprites: clipping against several
/// volumes, borders and cut edges, hybrid styles, lenses that intersect, and the solids themselves, from their sprites alone. All
/// in one pass over the geometry. Source: Trapp and Döllner 2008, section 3.3.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Params {
    /// Where sprites are put; [] leaves each where its solid was, under its own name.
    pub places: Vec<SpritePlace>,
    /// Applied one after the other to every point: where volumes intersect, their effects do too.
    pub effects: Vec<Effect>,
    /// Volumes that are drawn themselves.
    pub solids: Vec<Solid>,
    /// Where the viewer is, metres; before the scene, to the right and above where there is none.
    pub eye: Option<[f64; 3]>,
    /// What the viewer looks at, metres; the scene's centre where there is none.
    pub target: Option<[f64; 3]>,
    /// Field of view in height, degrees, more than 0 and less than 180.
    #[schemars(extend("exclusiveMinimum" = 0.0, "exclusiveMaximum" = 180.0, "x-unit" = "degrees"))]
    pub fov: f64,
    /// Pixels of the picture, 1 to 4096 each.
    #[schemars(inner(range(min = 1, max = 4096)), extend("x-unit" = "pixels"))]
    pub size: [u32; 2],
    /// Samples along a pixel's side, 1 to 4.
    #[schemars(range(min = 1, max = 4))]
    pub samples: u32,
    /// sRGB colour behind everything.
    pub background: [u8; 3],
}

/// What happens to points of the surface in a zone of a volume.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Effect {
    /// Pattern of the names of places or sprites; each that matches has the effect.
    pub volume: String,
    /// Which of its zones.
    #[serde(default)]
    pub zone: Zone,
    /// Half side of the cube whose eight corners are tested, metres, at least 0. Without it there is no border.
    #[serde(default)]
    #[schemars(range(min = 0.0), extend("x-unit" = "m"))]
    pub border: f64,
    /// Pattern of the names of the objects, and of the other volumes among `solids`, that it touches; `*` is any text, `?` any one character.
    #[serde(default = "all")]
    pub objects: String,
    /// How they look there.
    pub style: Style,
    /// sRGB colour of the styles `tint`, `gray`, `flat` and `lines`.
    #[serde(default = "white")]
    pub color: [u8; 3],
}

/// How points look.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Style {
    /// Not at all: what lies behind shows.
    Hide,
    /// Half in `color`.
    Tint,
    /// In shades of `color`.
    Gray,
    /// In `color`, lit.
    Flat,
    /// In the direction of the normal.
    Normals,
    /// In three steps of light, dark where the surface turns away.
    Toon,
    /// Only the triangles' edges, in `color`; `solids` have none and stay as they are.
    Lines,
}

/// A volume that is drawn itself, from its sprite.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Solid {
    /// Pattern of the names of places or sprites.
    pub volume: String,
    /// Its sRGB colour.
    #[serde(default = "white")]
    pub color: [u8; 3],
    /// 0 to 1; less than 1 lets shine through what is inside and behind.
    #[serde(default = "opaque")]
    #[schemars(range(min = 0.0, max = 1.0))]
    pub opacity: f32,
}

fn all() -> String {
    "*".into()
}

fn white() -> [u8; 3] {
    [255; 3]
}

fn opaque() -> f32 {
    1.0
}

impl Default for Params {
    fn default() -> Self {
        Self {
            places: Vec::new(),
            effects: Vec::new(),
            solids: Vec::new(),
            eye: None,
            target: None,
            fov: 35.0,
            size: [960, 720],
            samples: 2,
            background: [222, 226, 230],
        }
    }
}

ports! {
    pub struct In {
        /// What is drawn; without it only `solids` and `beside` are.
        scene: Option<Arc<Scene>>,
        /// What is drawn too.
        beside: Option<Arc<Scene>>,
        /// The sprites, by name.
        sprites: List<Sprite>,
    }
}

ports! {
    pub struct Out {
        /// The picture, PNG.
        picture: Arc<File>,
    }
}

pub struct DrawSprites;

impl Node for DrawSprites {
    const KIND: &'static str = "draw-sprites";
    const VERSION: u32 = 2;
    type Params = Params;
    type In = In;
    type Out = Out;

    fn memory(params: &Params, sizes: &[u64]) -> u64 {
        let pixels = u64::from(params.size[0]) * u64::from(params.size[1]);
        (64 << 20) + sizes.iter().sum::<u64>().saturating_mul(8) + pixels * 24
    }

    fn doubts(params: &Params) -> Vec<(&'static str, String)> {
        super::doubt_fov(params.fov)
    }

    fn check(params: &Params) -> Result<(), (&'static str, String)> {
        volumes::check(&params.places)?;
        for e in &params.effects {
            if e.zone == Zone::Border && e.border == 0.0 {
                return Err(("effects", format!("`{}`: the zone `border` needs a `border` above 0 m", e.volume)));
            }
        }
        let names: Vec<&str> = params.places.iter().map(SpritePlace::name).collect();
        let unplaced = |volume: &str| !names.is_empty() && !names.iter().any(|name| matches(volume, name));
        let effects = params.effects.iter().map(|e| ("effects", &e.volume));
        let asked = effects.chain(params.solids.iter().map(|s| ("solids", &s.volume)));
        if let Some((param, volume)) = asked.into_iter().find(|(_, volume)| unplaced(volume)) {
            return Err((param, format!("no place is called `{volume}`; there are `{}`", names.join("`, `"))));
        }
        Ok(())
    }

    fn run(params: &Params, inputs: In, ctx: &Ctx) -> Result<Out, NodeError> {
        let (names, volumes): (Vec<String>, Vec<Volume>) =
            volumes::volumes(&params.places, &inputs.sprites)?.into_iter().unzip();
        let numbers = |param: &str, pattern: &str| {
            let found: Vec<usize> = (0..names.len()).filter(|i| matches(pattern, &names[*i])).collect();
            if found.is_empty() { Err(unknown(param, pattern, names.iter().map(|n| &**n))) } else { Ok(found) }
        };
        let (mut effects, mut solids) = (Vec::new(), Vec::new());
        for e in &params.effects {
            let style = style(e.style, e.color.map(srgb::to_linear));
            for volume in numbers("effects", &e.volume)? {
                effects.push(sprite::Effect {
                    volume,
                    zone: e.zone,
                    border: e.border,
                    objects: e.objects.clone(),
                    style,
                });
            }
        }
        for s in &params.solids {
            let color = s.color.map(srgb::to_linear);
            let all = numbers("solids", &s.volume)?.into_iter();
            solids.extend(all.map(|volume| sprite::Solid { volume, color, opacity: s.opacity }));
        }
        let objects = [&inputs.scene, &inputs.beside].into_iter().flatten().flat_map(|s| s.objects.clone());
        let scene = Scene { objects: objects.collect() };
        let view = view(params, &scene, &volumes)?;
        let geometry = Geometry::new(&scene);
        let shader = Shader::new(&geometry);
        let drawing = Drawing {
            volumes: &volumes,
            names: &names,
            effects: &effects,
            solids: &solids,
            light: Light::default(),
            background: params.background.map(srgb::to_linear),
            samples: params.samples,
        };
        let picture = draw(super::backend(ctx), &shader, &scene.objects, &view, &drawing, ctx.stop)?;
        let [r, g, b] = params.background;
        if picture.texels.iter().all(|t| *t == [r, g, b, 255]) {
            (ctx.warn)(
                "the picture is empty: nothing but the background is seen; either `eye` and `target` look past everything, or effects hide all \
                 of it (`places` that are larger than the scene)"
                    .into(),
            );
        }
        let bytes = encode_png(&picture).map_err(|e| NodeError::from_error(&e))?;
        Ok(Out { picture: Arc::new(File { media_type: "image/png".into(), bytes }) })
    }
}

/// A picture of one volume by itself, 640 × 480.
pub fn portrait(volume: Volume, ctx: &Ctx) -> Result<Vec<u8>, NodeError> {
    let params = Params { size: [640, 480], fov: 30.0, ..Params::default() };
    let scene = Scene { objects: Vec::new() };
    let volumes = [volume];
    let view = view(&params, &scene, &volumes)?;
    let geometry = Geometry::new(&scene);
    let solid = sprite::Solid { volume: 0, color: [222, 184, 120].map(srgb::to_linear), opacity: 1.0 };
    let drawing = Drawing {
        volumes: &volumes,
        names: &["solid".to_owned()],
        effects: &[],
        solids: &[solid],
        light: Light::default(),
        background: params.background.map(srgb::to_linear),
        samples: params.samples,
    };
    let picture = draw(super::backend(ctx), &Shader::new(&geometry), &scene.objects, &view, &drawing, ctx.stop)?;
    encode_png(&picture).map_err(|e| NodeError::from_error(&e))
}

fn style(style: Style, color: [f32; 3]) -> sprite::Style {
    match style {
        Style::Hide => sprite::Style::Hide,
        Style::Tint => sprite::Style::Tint(color),
        Style::Gray => sprite::Style::Gray(color),
        Style::Flat => sprite::Style::Flat(color),
        Style::Normals => sprite::Style::Normals,
        Style::Toon => sprite::Style::Toon,
        Style::Lines => sprite::Style::Lines(color),
    }
}

/// The viewer, in front of the scene where the parameters do not say.
fn view(params: &Params, scene: &Scene, volumes: &[Volume]) -> Result<View, NodeError> {
    debug_assert!(params.size.iter().all(|n| n * params.samples <= MAX_SIDE));
    let mut bounds = scene.bounds();
    if scene.objects.is_empty() {
        bounds = volumes.iter().fold(bounds, |b, v| b.union(v.bounds()));
    }
    let (centre, size) = (bounds.centre(), bounds.diagonal());
    if !(size > 0.0 && size.is_finite()) {
        return Err(NodeError::Failed("there is nothing to draw: connect a `scene`, or name `solids`".into()));
    }
    let target = params.target.map_or(centre, DVec3::from);
    let eye = params.eye.map_or(centre + DVec3::new(0.45, 0.4, 0.9) * (1.35 * size), DVec3::from);
    if eye == target {
        return Err(NodeError::Failed(format!("the viewer at {eye} looks at the place where it is")));
    }
    let far = bounds.corners().iter().map(|c| (*c - eye).length()).fold(0.0, f64::max) + size;
    let [width, height] = params.size;
    Ok(View::look_at(eye, target, DVec3::Y, params.fov.to_radians(), width, height, far * 1e-5, far))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::nodes::testing::refused;

    #[test]
    fn mistakes_are_named_before_anything_runs() {
        let place = |name: &str, scale| SpritePlace {
            name: Some(name.into()),
            sprite: Some("box".into()),
            at: None,
            scale,
            size: None,
            turn: [0.0; 3],
        };
        let effect = |volume: &str, zone, border| Effect {
            volume: volume.into(),
            zone,
            border,
            objects: "*".into(),
            style: Style::Hide,
            color: [0; 3],
        };
        let solid = |opacity| Solid { volume: "a".into(), color: [0; 3], opacity };
        let good = || Params {
            places: vec![place("a", 1.0), place("b", 2.0)],
            effects: vec![effect("a", Zone::Inside, 0.0), effect("b", Zone::Border, 0.1)],
            solids: vec![solid(0.5)],
            ..Params::default()
        };
        assert_eq!(refused::<DrawSprites>(&good()), None);
        let changed = |change: &dyn Fn(&mut Params)| {
            let mut params = good();
            change(&mut params);
            refused::<DrawSprites>(&params).unwrap()
        };
        assert_eq!(changed(&|p| p.places.push(place("a", 1.0))), "places");
        assert_eq!(changed(&|p| p.places[0].scale = 0.0), "places");
        assert_eq!(changed(&|p| p.places[0].turn[1] = f64::NAN), "");
        assert_eq!(changed(&|p| p.effects.push(effect("c", Zone::Inside, 0.0))), "effects");
        assert_eq!(changed(&|p| p.effects.push(effect("a", Zone::Border, 0.0))), "effects");
        assert_eq!(changed(&|p| p.effects[0].border = -1.0), "effects");
        assert_eq!(changed(&|p| p.solids[0].opacity = 1.5), "solids");
        assert_eq!(changed(&|p| p.size = [0, 1]), "size");
        assert_eq!(changed(&|p| p.samples = 5), "samples");
        assert_eq!(changed(&|p| p.fov = 180.0), "fov");
        assert_eq!(changed(&|p| p.eye = Some([f64::INFINITY, 0.0, 0.0])), "");
        // Without places the names are those of the sprites, which nobody knows yet.
        assert_eq!(refused::<DrawSprites>(&Params { places: vec![], ..good() }), None);
    }
}
