//! What a stand-in saves and how good it is, in lines for people.

use super::certificate::Certificate;

/// The lines, without a full stop each.
pub fn lines(c: &Certificate) -> Vec<String> {
    let arrow = |what: &str, before: u64, after: u64| format!("{what} {} → {}", grouped(before), grouped(after));
    let mut lines = vec![
        [
            arrow("triangles", c.original_triangles, c.triangles),
            arrow("draw calls", c.original_draw_calls, c.draw_calls),
            arrow("texels", c.original_texels, c.texels),
        ]
        .join(", "),
        format!("uncompressed geometry and textures {} → {}", bytes(c.original_memory_bytes), bytes(c.memory_bytes)),
    ];
    if c.bytes > 0 {
        lines[1] += &format!(", file {}", bytes(c.bytes));
    }
    if let Some(o) = c.overdraw {
        lines.push(format!(
            "a covered pixel draws {:.1} surfaces of the stand-in, and {:.2} more that the alpha test discards",
            o.opaque, o.transparent
        ));
    }
    let psnr = c.figures.psnr_y_object_db;
    let mut quality = format!("likeness {:.1} dB (PSNR over the object, mean of {} views)", psnr.mean, c.views);
    if let Some(ceiling) = &c.ceiling {
        quality += &format!(
            "; the ceiling, {} triangles before simplification, reaches {:.1} dB",
            grouped(ceiling.triangles),
            ceiling.figures.psnr_y_object_db.mean
        );
    }
    lines.push(quality);
    lines.extend(heavier(c));
    lines
}

/// Says so where the stand-in costs more than it replaces.
fn heavier(c: &Certificate) -> Option<String> {
    if c.triangles < c.original_triangles {
        return None;
    }
    let calls = if c.draw_calls < c.original_draw_calls {
        format!("it saves {} draw calls only", grouped(c.original_draw_calls - c.draw_calls))
    } else {
        "it saves no draw calls either".to_owned()
    };
    Some(format!(
        "heavier than the original: {} triangles stand in for {}, and {calls}. Put the cell farther away, lower the \
         resolution, simplify more, bake many such objects into one stand-in, or keep the original",
        grouped(c.triangles),
        grouped(c.original_triangles)
    ))
}

/// 1234567 as 1,234,567.
pub fn grouped(n: u64) -> String {
    let digits = n.to_string();
    let mut out = String::new();
    for (i, d) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            out.push(',');
        }
        out.push(d);
    }
    out
}

fn bytes(n: u64) -> String {
    match n {
        0..1024 => format!("{n} B"),
        1024..1_048_576 => format!("{:.1} KiB", n as f64 / 1024.0),
        _ => format!("{:.1} MiB", n as f64 / 1_048_576.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn amounts_for_people() {
        assert_eq!([0, 999, 1000, 1_234_567].map(grouped), ["0", "999", "1,000", "1,234,567"]);
        assert_eq!([12, 2048, 5 << 20].map(bytes), ["12 B", "2.0 KiB", "5.0 MiB"]);
    }
}
