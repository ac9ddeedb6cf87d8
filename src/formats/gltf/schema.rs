//! The part of glTF 2.0's JSON that a scene needs, for the reader and the writer.
//!
//! Own types instead of the `gltf` crate's: that one drops KHR_texture_transform on normal maps, cuts indices down to
//! 32 bits, and its views of the data panic where an index leads nowhere. Enumerations stay the numbers and strings of the
//! file; the reader says what is wrong with them where it meets them.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

fn no<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

macro_rules! object {
    ($(#[doc = $doc:literal])* $name:ident { $($(#[$meta:meta])* $field:ident : $ty:ty),* $(,)? }) => {
        $(#[doc = $doc])*
        #[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
        #[serde(default, rename_all = "camelCase")]
        pub struct $name { $($(#[$meta])* #[serde(skip_serializing_if = "no")] pub $field: $ty),* }
    };
}

object! { Root {
    asset: Asset,
    extensions_used: Vec<String>,
    extensions_required: Vec<String>,
    scene: Option<u64>,
    scenes: Vec<Scene>,
    nodes: Vec<Node>,
    meshes: Vec<Mesh>,
    skins: Vec<Skin>,
    materials: Vec<Material>,
    textures: Vec<Texture>,
    images: Vec<Image>,
    samplers: Vec<Sampler>,
    accessors: Vec<Accessor>,
    buffer_views: Vec<View>,
    buffers: Vec<Buffer>,
}}

object! { Asset { version: String, min_version: Option<String>, generator: Option<String> } }

object! { Scene { name: Option<String>, nodes: Vec<u64> } }

object! { Node {
    name: Option<String>,
    children: Vec<u64>,
    mesh: Option<u64>,
    skin: Option<u64>,
    matrix: Option<[f32; 16]>,
    translation: Option<[f32; 3]>,
    rotation: Option<[f32; 4]>,
    scale: Option<[f32; 3]>,
    weights: Vec<f32>,
    extensions: NodeExtensions,
}}

object! { NodeExtensions {
    #[serde(rename = "EXT_mesh_gpu_instancing")]
    instancing: Option<Instancing>,
    #[serde(rename = "KHR_node_visibility")]
    visibility: Option<Visibility>,
}}

object! {
    /// Accessors of the instances' TRANSLATION, ROTATION and SCALE.
    Instancing { attributes: BTreeMap<String, u64> }
}

object! { Visibility { visible: Option<bool> } }

object! { Skin { name: Option<String>, inverse_bind_matrices: Option<u64>, joints: Vec<u64> } }

object! { Mesh { name: Option<String>, primitives: Vec<Primitive>, weights: Vec<f32> } }

object! { Primitive {
    attributes: BTreeMap<String, u64>,
    indices: Option<u64>,
    material: Option<u64>,
    mode: Option<u64>,
    targets: Vec<BTreeMap<String, u64>>,
    extensions: BTreeMap<String, serde_json::Value>,
}}

object! { Material {
    name: Option<String>,
    pbr_metallic_roughness: Option<Pbr>,
    normal_texture: Option<TextureInfo>,
    emissive_texture: Option<TextureInfo>,
    occlusion_texture: Option<TextureInfo>,
    emissive_factor: Option<[f32; 3]>,
    alpha_mode: Option<String>,
    alpha_cutoff: Option<f32>,
    double_sided: bool,
    extensions: MaterialExtensions,
}}

object! { MaterialExtensions {
    #[serde(rename = "KHR_materials_unlit")]
    unlit: Option<Unlit>,
    #[serde(rename = "KHR_materials_emissive_strength")]
    emissive_strength: Option<EmissiveStrength>,
    #[serde(rename = "KHR_materials_pbrSpecularGlossiness")]
    specular_glossiness: Option<SpecularGlossiness>,
    #[serde(rename = "KHR_materials_transmission")]
    transmission: Option<Transmission>,
}}

object! {
    /// What counts as base colour; the rest of the extension is not read.
    SpecularGlossiness {
        diffuse_factor: Option<[f32; 4]>,
        diffuse_texture: Option<TextureInfo>,
        glossiness_factor: Option<f32>,
    }
}

object! { Transmission { transmission_factor: Option<f32>, transmission_texture: Option<TextureInfo> } }

object! { Unlit {} }

object! { EmissiveStrength { emissive_strength: Option<f32> } }

object! { Pbr {
    base_color_factor: Option<[f32; 4]>,
    base_color_texture: Option<TextureInfo>,
    metallic_factor: Option<f32>,
    roughness_factor: Option<f32>,
    metallic_roughness_texture: Option<TextureInfo>,
}}

/// A texture and how a material uses it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct TextureInfo {
    pub index: u64,
    #[serde(default, skip_serializing_if = "no")]
    pub tex_coord: u64,
    /// Of normal maps only.
    #[serde(default, skip_serializing_if = "no")]
    pub scale: Option<f32>,
    /// Of an occlusion texture.
    #[serde(default, skip_serializing_if = "no")]
    pub strength: Option<f32>,
    #[serde(default, skip_serializing_if = "no")]
    pub extensions: TextureInfoExtensions,
}

object! { TextureInfoExtensions {
    #[serde(rename = "KHR_texture_transform")]
    transform: Option<TextureTransform>,
}}

object! { TextureTransform {
    offset: Option<[f32; 2]>,
    rotation: Option<f32>,
    scale: Option<[f32; 2]>,
    tex_coord: Option<u64>,
}}

object! { Texture { sampler: Option<u64>, source: Option<u64>, extensions: TextureExtensions } }

object! { TextureExtensions {
    #[serde(rename = "EXT_texture_webp")]
    webp: Option<TextureSource>,
    #[serde(rename = "KHR_texture_basisu")]
    basisu: Option<TextureSource>,
    #[serde(rename = "EXT_texture_avif")]
    avif: Option<TextureSource>,
    #[serde(rename = "MSFT_texture_dds")]
    dds: Option<TextureSource>,
}}

object! { TextureSource { source: Option<u64> } }

object! { Image { name: Option<String>, uri: Option<String>, mime_type: Option<String>, buffer_view: Option<u64> } }

object! { Sampler { mag_filter: Option<u64>, min_filter: Option<u64>, wrap_s: Option<u64>, wrap_t: Option<u64> } }

/// Typed numbers in a buffer view.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Accessor {
    #[serde(default, skip_serializing_if = "no")]
    pub buffer_view: Option<u64>,
    #[serde(default, skip_serializing_if = "no")]
    pub byte_offset: u64,
    pub component_type: u64,
    #[serde(default, skip_serializing_if = "no")]
    pub normalized: bool,
    pub count: u64,
    #[serde(rename = "type")]
    pub shape: String,
    #[serde(default, skip_serializing_if = "no")]
    pub min: Option<Vec<f64>>,
    #[serde(default, skip_serializing_if = "no")]
    pub max: Option<Vec<f64>>,
    #[serde(default, skip_serializing_if = "no")]
    pub sparse: Option<Sparse>,
}

/// Elements that replace those of the buffer view.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sparse {
    pub count: u64,
    pub indices: SparseIndices,
    pub values: SparseValues,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct SparseIndices {
    pub buffer_view: u64,
    #[serde(default)]
    pub byte_offset: u64,
    pub component_type: u64,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct SparseValues {
    pub buffer_view: u64,
    #[serde(default)]
    pub byte_offset: u64,
}

/// A range of a buffer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct View {
    pub buffer: u64,
    #[serde(default, skip_serializing_if = "no")]
    pub byte_offset: u64,
    pub byte_length: u64,
    #[serde(default, skip_serializing_if = "no")]
    pub byte_stride: Option<u64>,
    #[serde(default, skip_serializing_if = "no")]
    pub target: Option<u64>,
    #[serde(default, skip_serializing_if = "no")]
    pub extensions: ViewExtensions,
}

object! { ViewExtensions {
    #[serde(rename = "EXT_meshopt_compression")]
    meshopt: Option<Meshopt>,
    #[serde(rename = "KHR_meshopt_compression")]
    khr_meshopt: Option<Meshopt>,
}}

object! {
    /// Where a view's compressed bytes lie, and how they are compressed.
    Meshopt {
        buffer: u64,
        byte_offset: u64,
        byte_length: u64,
        byte_stride: u64,
        count: u64,
        mode: String,
        filter: Option<String>,
    }
}

/// Bytes: of the GLB itself, of another file, or of a data URI.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Buffer {
    #[serde(default, skip_serializing_if = "no")]
    pub uri: Option<String>,
    pub byte_length: u64,
}
