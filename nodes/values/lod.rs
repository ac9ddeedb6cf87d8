//! Hexagonal cells, and what stand-ins of hybrid textured LOD meshes pass through.

use super::camera::view_of;
use crate::{
    engine::artifact::{Artifact, DecodeError, Decoder, Encoder},
    lod::{
        entry::Entry,
        levels::{Level, Levels},
        outline::Outline,
        simplified::Simplified,
        subject::{Placement, Subject, Views},
        texture::{Patch, Textured},
        weights::Window,
        window::WindowCamera,
    },
    view::{HexCell, HexGrid, Prism, Projection, View},
};
use glam::{DAffine3, DVec2, DVec3};
use serde::{Deserialize, Serialize};

type Row<const N: usize> = [f64; N];

fn finite(section: &str, numbers: &[f64]) -> Result<(), DecodeError> {
    match numbers.iter().all(|n| n.is_finite()) {
        true => Ok(()),
        false => Err(DecodeError::section(section, "expected finite numbers")),
    }
}

fn prism_row(p: &Prism) -> Row<5> {
    [p.centre.x, p.centre.y, p.centre.z, p.size, p.half_height]
}

fn prism_of([x, y, z, size, half_height]: Row<5>) -> Result<Prism, DecodeError> {
    finite("head", &[x, y, z, size, half_height])?;
    if size <= 0.0 || half_height < 0.0 {
        return Err(DecodeError::section("head", "expected a prism with an extent"));
    }
    Ok(Prism { centre: DVec3::new(x, y, z), size, half_height })
}

#[derive(Serialize, Deserialize)]
struct CellHead {
    name: String,
    prism: Row<5>,
    neighbours: Vec<(String, Row<3>)>,
}

impl Artifact for HexCell {
    const TYPE: &'static str = "HexCell";
    const FORMAT: u32 = 1;

    fn encode(&self, out: &mut Encoder) {
        let neighbours = self.neighbours.iter().map(|(n, c)| (n.clone(), c.to_array())).collect();
        out.json("head", &CellHead { name: self.name.clone(), prism: prism_row(&self.prism), neighbours });
    }

    fn decode(data: &Decoder) -> Result<Self, DecodeError> {
        let head: CellHead = data.json("head")?;
        for (_, c) in &head.neighbours {
            finite("head", c)?;
        }
        let neighbours = head.neighbours.into_iter().map(|(n, c)| (n, DVec3::from(c))).collect();
        Ok(Self { name: head.name, prism: prism_of(head.prism)?, neighbours })
    }
}

impl Artifact for HexGrid {
    const TYPE: &'static str = "HexGrid";
    const FORMAT: u32 = 1;

    fn encode(&self, out: &mut Encoder) {
        let o = self.origin;
        out.json("head", &([o.x, o.y, o.z, self.size, self.half_height], [self.columns, self.rows]));
    }

    fn decode(data: &Decoder) -> Result<Self, DecodeError> {
        let (row, [columns, rows]): (Row<5>, [u32; 2]) = data.json("head")?;
        let p = prism_of(row)?;
        Ok(Self { origin: p.centre, size: p.size, half_height: p.half_height, columns, rows })
    }
}

#[derive(Serialize, Deserialize)]
struct OutlineRow {
    plan: Vec<[f64; 2]>,
    low: f64,
    high: f64,
}

impl OutlineRow {
    fn of(o: &Outline) -> Self {
        Self { plan: o.plan.iter().map(|p| p.to_array()).collect(), low: o.low, high: o.high }
    }

    fn outline(self) -> Result<Outline, DecodeError> {
        finite("head", self.plan.as_flattened())?;
        finite("head", &[self.low, self.high])?;
        if self.plan.is_empty() || self.low > self.high {
            return Err(DecodeError::section("head", "expected an outline with a corner"));
        }
        Ok(Outline { plan: self.plan.into_iter().map(DVec2::from).collect(), low: self.low, high: self.high })
    }
}

fn affine_row(t: &DAffine3) -> Row<12> {
    t.to_cols_array()
}

fn affine_of(row: Row<12>) -> Result<DAffine3, DecodeError> {
    finite("head", &row)?;
    Ok(DAffine3::from_cols_array(&row))
}

impl Artifact for Placement {
    const TYPE: &'static str = "Placement";
    const FORMAT: u32 = 1;

    fn encode(&self, out: &mut Encoder) {
        out.json("head", &(affine_row(&self.transform), self.outline.as_ref().map(OutlineRow::of), self.triangles));
    }

    fn decode(data: &Decoder) -> Result<Self, DecodeError> {
        let (transform, outline, triangles): (Row<12>, Option<OutlineRow>, u64) = data.json("head")?;
        Ok(Self { transform: affine_of(transform)?, outline: outline.map(OutlineRow::outline).transpose()?, triangles })
    }
}

/// A perspective camera as numbers.
#[derive(Serialize, Deserialize)]
struct CameraRow {
    frame: Row<12>,
    window: Row<4>,
    depths: Row<2>,
    pixels: [u32; 2],
}

impl CameraRow {
    fn of(v: &View) -> Self {
        let window = match v.projection {
            Projection::Perspective { left, right, bottom, top }
            | Projection::Orthographic { left, right, bottom, top } => [left, right, bottom, top],
        };
        let mut frame = [0.0; 12];
        for (to, from) in frame.chunks_exact_mut(3).zip([v.eye, v.right, v.up, v.forward]) {
            to.copy_from_slice(&from.to_array());
        }
        Self { frame, window, depths: [v.near, v.far], pixels: [v.width, v.height] }
    }

    fn view(&self) -> Result<View, DecodeError> {
        let numbers: Vec<f64> = self.frame.iter().chain(&self.window).chain(&self.depths).copied().collect();
        view_of(&numbers, &[1, self.pixels[0], self.pixels[1]])
    }
}

/// Objects and their places.
type MemberRows = Vec<(String, Row<12>)>;

fn member_rows(members: &[(String, DAffine3)]) -> MemberRows {
    members.iter().map(|(n, t)| (n.clone(), affine_row(t))).collect()
}

fn members_of(rows: MemberRows) -> Result<Vec<(String, DAffine3)>, DecodeError> {
    rows.into_iter().map(|(n, t)| Ok((n, affine_of(t)?))).collect()
}

#[derive(Serialize, Deserialize)]
struct WindowCameraRow {
    members: MemberRows,
    camera: CameraRow,
}

impl WindowCameraRow {
    fn of(c: &WindowCamera) -> Self {
        Self { members: member_rows(&c.members), camera: CameraRow::of(&c.view) }
    }

    fn camera(self) -> Result<WindowCamera, DecodeError> {
        Ok(WindowCamera { members: members_of(self.members)?, view: self.camera.view()? })
    }
}

impl Artifact for WindowCamera {
    const TYPE: &'static str = "LodCamera";
    const FORMAT: u32 = 1;

    fn encode(&self, out: &mut Encoder) {
        out.json("head", &WindowCameraRow::of(self));
    }

    fn decode(data: &Decoder) -> Result<Self, DecodeError> {
        data.json::<WindowCameraRow>("head")?.camera()
    }
}

#[derive(Serialize, Deserialize)]
struct SubjectHead {
    members: MemberRows,
    multi: bool,
    cell: Row<5>,
    outline: OutlineRow,
    focal: f64,
    cameras: Vec<(Row<3>, WindowCameraRow)>,
}

impl Artifact for Subject {
    const TYPE: &'static str = "LodSubject";
    const FORMAT: u32 = 2;

    fn encode(&self, out: &mut Encoder) {
        let head = SubjectHead {
            members: member_rows(&self.members),
            multi: self.views == Views::Multi,
            cell: prism_row(&self.cell),
            outline: OutlineRow::of(&self.outline),
            focal: self.focal,
            cameras: self.cameras.iter().map(|(eye, c)| (eye.to_array(), WindowCameraRow::of(c))).collect(),
        };
        out.json("head", &head);
    }

    fn decode(data: &Decoder) -> Result<Self, DecodeError> {
        let head: SubjectHead = data.json("head")?;
        if !(head.focal > 0.0 && head.focal.is_finite()) || head.cameras.is_empty() || head.cameras.len() > 32 {
            return Err(DecodeError::section("head", "expected a focal length and 1 to 32 cameras"));
        }
        let camera = |(eye, row): (Row<3>, WindowCameraRow)| {
            finite("head", &eye)?;
            Ok((DVec3::from(eye), row.camera()?))
        };
        Ok(Self {
            members: members_of(head.members)?,
            views: if head.multi { Views::Multi } else { Views::Single },
            cell: prism_of(head.cell)?,
            outline: head.outline.outline()?,
            focal: head.focal,
            cameras: head.cameras.into_iter().map(camera).collect::<Result<_, DecodeError>>()?,
        })
    }
}

impl Artifact for Levels {
    const TYPE: &'static str = "LodLevels";
    const FORMAT: u32 = 1;

    fn encode(&self, out: &mut Encoder) {
        out.json("head", &(self.double_sided, self.levels.iter().map(|l| l.error).collect::<Vec<_>>()));
        for (i, level) in self.levels.iter().enumerate() {
            out.array(format!("positions {i}"), &level.positions);
            out.array(format!("colors {i}"), &level.colors);
            out.array(format!("triangles {i}"), &level.triangles);
        }
    }

    fn decode(data: &Decoder) -> Result<Self, DecodeError> {
        let (double_sided, errors): (bool, Vec<f64>) = data.json("head")?;
        finite("head", &errors)?;
        let level = |(i, error): (usize, f64)| {
            let level = Level {
                error,
                positions: data.array(&format!("positions {i}"))?,
                colors: data.array(&format!("colors {i}"))?,
                triangles: data.array(&format!("triangles {i}"))?,
            };
            let n = level.positions.len();
            let good = level.colors.len() == n
                && level.positions.as_flattened().iter().all(|c| c.is_finite())
                && level.triangles.as_flattened().iter().all(|v| (*v as usize) < n);
            good.then_some(level).ok_or_else(|| DecodeError::section(format!("triangles {i}"), "expected a mesh"))
        };
        let levels: Vec<Level> = errors.into_iter().enumerate().map(level).collect::<Result<_, _>>()?;
        if levels.is_empty() {
            return Err(DecodeError::section("head", "expected a level"));
        }
        Ok(Self { levels, double_sided })
    }
}

impl Artifact for Window {
    const TYPE: &'static str = "LodWindow";
    const FORMAT: u32 = 1;

    fn encode(&self, out: &mut Encoder) {
        out.json("camera", &CameraRow::of(&self.view));
        out.array("depth", &self.depth);
        out.array("color", &self.color);
    }

    fn decode(data: &Decoder) -> Result<Self, DecodeError> {
        let view = data.json::<CameraRow>("camera")?.view()?;
        let (depth, color) = (data.array::<f32>("depth")?, data.array("color")?);
        let pixels = view.width as usize * view.height as usize;
        if depth.len() != pixels || color.len() != pixels || depth.iter().any(|z| z.is_nan() || *z < 0.0) {
            return Err(DecodeError::section("depth", format!("expected {pixels} pixels")));
        }
        Ok(Self { view, depth, color })
    }
}

impl Artifact for Simplified {
    const TYPE: &'static str = "LodMesh";
    const FORMAT: u32 = 1;

    fn encode(&self, out: &mut Encoder) {
        out.json("head", &(self.error, self.before));
        out.array("positions", &self.positions.iter().map(|p| p.to_array()).collect::<Vec<_>>());
        out.array("colors", &self.colors);
        out.array("views", &self.views);
        out.array("triangles", &self.triangles);
    }

    fn decode(data: &Decoder) -> Result<Self, DecodeError> {
        let (error, before): (f64, u64) = data.json("head")?;
        let positions = data.array::<[f64; 3]>("positions")?;
        finite("positions", positions.as_flattened())?;
        let (colors, views) = (data.array("colors")?.to_vec(), data.array("views")?.to_vec());
        let triangles: Vec<[u32; 3]> = data.array("triangles")?.to_vec();
        let n = positions.len();
        if colors.len() != n || views.len() != n || triangles.as_flattened().iter().any(|v| *v as usize >= n) {
            return Err(DecodeError::section("triangles", "expected a mesh"));
        }
        let positions = positions.iter().copied().map(DVec3::from).collect();
        Ok(Self { positions, colors, views, triangles, error, before })
    }
}

#[derive(Serialize, Deserialize)]
struct PatchHead {
    window: Option<u32>,
    origin: [u32; 2],
    size: [u32; 2],
}

impl Artifact for Textured {
    const TYPE: &'static str = "LodTextured";
    const FORMAT: u32 = 1;

    fn encode(&self, out: &mut Encoder) {
        let head = |p: &Patch| PatchHead { window: p.window, origin: p.origin, size: [p.width, p.height] };
        out.json("patches", &self.patches.iter().map(head).collect::<Vec<_>>());
        out.array("texels", &self.patches.iter().flat_map(|p| p.texels.iter().copied()).collect::<Vec<_>>());
        out.array("positions", &self.positions);
        out.array("uv", &self.uv);
        out.array("depth", &self.depth);
        out.array("patch", &self.patch);
        out.array("triangles", &self.triangles);
    }

    fn decode(data: &Decoder) -> Result<Self, DecodeError> {
        let heads: Vec<PatchHead> = data.json("patches")?;
        let texels = data.array::<[u8; 4]>("texels")?;
        let wrong = |what: &str| DecodeError::section("texels", what);
        let mut at = 0_usize;
        let mut patches = Vec::new();
        for h in heads {
            let count = u64::from(h.size[0]) * u64::from(h.size[1]);
            let count = usize::try_from(count).map_err(|_| wrong("a patch is too large"))?;
            let end = at.checked_add(count).filter(|e| *e <= texels.len() && count > 0);
            let own = texels[at..end.ok_or_else(|| wrong("expected the texels of all patches"))?].to_vec();
            at += count;
            patches.push(Patch {
                window: h.window,
                origin: h.origin,
                width: h.size[0],
                height: h.size[1],
                texels: own,
            });
        }
        let out = Self {
            positions: data.array("positions")?.to_vec(),
            uv: data.array("uv")?.to_vec(),
            depth: data.array("depth")?.to_vec(),
            patch: data.array("patch")?.to_vec(),
            triangles: data.array("triangles")?.to_vec(),
            patches,
        };
        let n = out.positions.len();
        let good = [out.uv.len(), out.depth.len(), out.patch.len()] == [n; 3]
            && out.patch.iter().all(|p| (*p as usize) < out.patches.len())
            && out.triangles.as_flattened().iter().all(|v| (*v as usize) < n);
        good.then_some(out)
            .ok_or_else(|| DecodeError::section("triangles", "expected a mesh with a patch for each vertex"))
    }
}

impl Artifact for Entry {
    const TYPE: &'static str = "LodCell";
    const FORMAT: u32 = 1;

    fn encode(&self, out: &mut Encoder) {
        out.json("cell", self);
    }

    fn decode(data: &Decoder) -> Result<Self, DecodeError> {
        data.json("cell")
    }
}
