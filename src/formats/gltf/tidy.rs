//! What one broken vertex or number costs: its own triangles, as in viewers, and never the whole file.

use crate::{array::Array, scene::Mesh};

/// `mesh` without triangles that name vertices which do not exist or have no finite place, and with numbers that are not finite set to 0;
/// what was done, for the user.
pub(super) fn tidy(mut mesh: Mesh) -> (Mesh, Vec<String>) {
    let mut notes = Vec::new();
    let count = mesh.positions.len();
    let finite: Vec<bool> = mesh.positions.iter().map(|p| p.iter().all(|x| x.is_finite())).collect();
    let (mut lost, mut wild) = (0usize, 0usize);
    let whole = |t: &[u32; 3], lost: &mut usize, wild: &mut usize| {
        if t.iter().any(|v| *v as usize >= count) {
            *lost += 1;
            return false;
        }
        let fine = t.iter().all(|v| finite[*v as usize]);
        *wild += usize::from(!fine);
        fine
    };
    let sound = mesh.triangles.iter().all(|t| whole(t, &mut lost, &mut wild));
    if !sound {
        (lost, wild) = (0, 0);
        let kept: Vec<_> = mesh.triangles.iter().filter(|t| whole(t, &mut lost, &mut wild)).copied().collect();
        mesh.triangles = kept.into();
    }
    if lost > 0 {
        notes.push(format!("{lost} triangles name vertices beyond its {count}; they are left out"));
    }
    if wild > 0 {
        notes.push(format!("{wild} triangles have corners that are not finite; they are left out"));
    }
    zero(&mut mesh.positions);
    let mut zeroed = |what: &str, n: usize| {
        if n > 0 {
            notes.push(format!("{n} {what} are not finite; they count as 0"));
        }
    };
    zeroed("texture coordinates", zero(&mut mesh.uv[0]) + zero(&mut mesh.uv[1]));
    zeroed("colours", zero(&mut mesh.colors));
    // Directions without a length are taken from the faces later.
    zero(&mut mesh.normals);
    (mesh, notes)
}

/// Sets elements that are not finite to 0; their number.
fn zero<const N: usize>(values: &mut Array<[f32; N]>) -> usize
where
    [f32; N]: bytemuck::Pod,
{
    let wild = |v: &[f32; N]| !v.iter().all(|x| x.is_finite());
    let n = values.iter().filter(|v| wild(v)).count();
    if n > 0 {
        *values = values.iter().map(|v| if wild(v) { [0.0; N] } else { *v }).collect();
    }
    n
}
