//! Files that may be read: regular ones, and links to them. To read a FIFO or a device could wait for ever.

use std::{
    fs::{File, FileType, Metadata},
    io::{self, Read},
    path::Path,
};

/// Opens the file at `path` for reading. What is no regular file is an error that says what it is.
pub fn open(path: &Path) -> io::Result<File> {
    // Opening a FIFO waits for a writer, so its kind is asked for first; and again of what was opened.
    check(&std::fs::metadata(path)?)?;
    let file = File::open(path)?;
    check(&file.metadata()?)?;
    Ok(file)
}

/// The bytes of the regular file at `path`.
pub fn read(path: &Path) -> io::Result<Vec<u8>> {
    let mut file = open(path)?;
    let mut bytes = Vec::with_capacity(usize::try_from(file.metadata()?.len()).unwrap_or(0));
    file.read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// An error unless `meta` is of a regular file.
pub fn check(meta: &Metadata) -> io::Result<()> {
    if meta.is_file() {
        return Ok(());
    }
    let what = format!("is a {}, expected a regular file", kind(meta.file_type()));
    Err(io::Error::new(io::ErrorKind::InvalidInput, what))
}

#[cfg(unix)]
fn kind(kind: FileType) -> &'static str {
    use std::os::unix::fs::FileTypeExt;
    match kind {
        k if k.is_dir() => "folder",
        k if k.is_fifo() => "FIFO",
        k if k.is_socket() => "socket",
        k if k.is_block_device() || k.is_char_device() => "device",
        _ => "special file",
    }
}

#[cfg(not(unix))]
fn kind(kind: FileType) -> &'static str {
    if kind.is_dir() { "folder" } else { "special file" }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn regular_files_and_links_to_them_are_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        std::fs::write(&path, "text").unwrap();
        assert_eq!(read(&path).unwrap(), b"text");
        assert_eq!(read(&folder.path().join("b")).unwrap_err().kind(), io::ErrorKind::NotFound);
        assert_eq!(read(folder.path()).unwrap_err().to_string(), "is a folder, expected a regular file");
        #[cfg(unix)]
        {
            let link = folder.path().join("link");
            std::os::unix::fs::symlink(&path, &link).unwrap();
            assert_eq!(read(&link).unwrap(), b"text");
            let device = read(Path::new("/dev/null")).unwrap_err().to_string();
            assert_eq!(device, "is a device, expected a regular file");
            let fifo = folder.path().join("fifo");
            let made = std::process::Command::new("mkfifo").arg(&fifo).status();
            if made.is_ok_and(|s| s.success()) {
                assert_eq!(read(&fifo).unwrap_err().to_string(), "is a FIFO, expected a regular file");
            }
        }
    }
}
