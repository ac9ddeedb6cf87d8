//! How much a file may ask for.

/// Bounds on what readers accept. They are checked before anything of that size is allocated.
#[derive(Clone, Debug, PartialEq)]
pub struct Limits {
    /// Whether a scene may name files outside its own folder.
    pub allow_outside: bool,
    /// Texels of all images together.
    pub texels: u64,
    /// Bytes that decoded images may take together, while they are decoded too; as many again that decompressed buffers may take.
    pub bytes: u64,
    /// Vertices stored in all files together.
    pub vertices: u64,
    /// Triangles of all objects, every instance counted.
    pub triangles: u64,
    /// Objects, every instance counted.
    pub objects: u64,
    /// Elements that an accessor may imply without storing them (glTF: an accessor without a buffer view is zero).
    pub implied: u64,
    /// How deep a node may lie in its tree.
    pub depth: u32,
    /// How deep scene files may include each other.
    pub includes: u32,
    /// Bytes of an object's name.
    pub name: u64,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            allow_outside: false,
            texels: 1 << 29,
            bytes: 1 << 34,
            vertices: 1 << 28,
            triangles: 1 << 30,
            objects: 1 << 22,
            implied: 1 << 20,
            depth: 200,
            includes: 16,
            name: 1024,
        }
    }
}
