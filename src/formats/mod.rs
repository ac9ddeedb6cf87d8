//! Readers and writers of the outside world's files: glTF, OBJ, PLY, scene TOML.
