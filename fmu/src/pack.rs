//! The `.fmu` file: model description, libraries, resources, documents in one zip.

use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};

use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

use crate::description::{Description, Version};

/// Why a file could not be packed or inspected.
#[derive(Debug, thiserror::Error)]
pub enum PackError {
    /// A file could not be read or written.
    #[error("{path}: {source}")]
    File {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The archive could not be written or read.
    #[error("{path}: {source}")]
    Zip {
        /// The archive.
        path: PathBuf,
        /// What the zip library said.
        source: zip::result::ZipError,
    },
    /// The model description cannot be understood.
    #[error("{path}: modelDescription.xml: {reason}")]
    Description {
        /// The FMU.
        path: PathBuf,
        /// What is wrong, and where.
        reason: String,
    },
    /// The files beside the model could not be made.
    #[error("reference experiment: {0}")]
    Related(String),
    /// No library, or a platform named twice, or one the version has no folder for.
    #[error("{0}")]
    Binaries(String),
}

/// A platform a library is built for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Platform {
    /// Linux on x86-64.
    LinuxX64,
    /// Windows on x86-64.
    WindowsX64,
    /// Linux on 64-bit ARM; FMI 2.0 has no folder for it.
    LinuxArm64,
}

impl Platform {
    /// Folder below `binaries/`, if the version has one.
    #[must_use]
    pub fn folder(self, version: Version) -> Option<&'static str> {
        match (version, self) {
            (Version::Fmi2, Self::LinuxX64) => Some("linux64"),
            (Version::Fmi2, Self::WindowsX64) => Some("win64"),
            (Version::Fmi2, Self::LinuxArm64) => None,
            (Version::Fmi3, Self::LinuxX64) => Some("x86_64-linux"),
            (Version::Fmi3, Self::WindowsX64) => Some("x86_64-windows"),
            (Version::Fmi3, Self::LinuxArm64) => Some("aarch64-linux"),
        }
    }

    /// Ending of a shared library's name.
    #[must_use]
    pub fn extension(self) -> &'static str {
        match self {
            Self::LinuxX64 | Self::LinuxArm64 => "so",
            Self::WindowsX64 => "dll",
        }
    }
}

/// A built library.
#[derive(Clone, Debug)]
pub struct Binary {
    /// What it is built for.
    pub platform: Platform,
    /// Where it is.
    pub path: PathBuf,
}

/// Writes an FMU. The same inputs give the same bytes.
///
/// # Errors
/// [`PackError`] if a library is missing, given twice or has no folder, or on a file error.
pub fn pack(
    description: &Description,
    version: Version,
    binaries: &[Binary],
    output: &Path,
) -> Result<(), PackError> {
    pack_with(description, version, binaries, &[], output)
}

/// [`pack`], with further files.
pub(crate) fn pack_with(
    description: &Description,
    version: Version,
    binaries: &[Binary],
    further: &[(String, Vec<u8>)],
    output: &Path,
) -> Result<(), PackError> {
    let mut files: Vec<(String, Vec<u8>)> = Vec::new();
    let xml = description.model_description(version);
    files.push(("modelDescription.xml".to_owned(), xml.into_bytes()));
    if binaries.is_empty() {
        return Err(PackError::Binaries("an FMU needs at least one library".to_owned()));
    }
    for binary in binaries {
        let Some(folder) = binary.platform.folder(version) else {
            let platform = binary.platform;
            return Err(PackError::Binaries(format!("{version:?} has no folder for {platform:?}")));
        };
        let (name, ending) = (description.model_identifier, binary.platform.extension());
        let place = format!("binaries/{folder}/{name}.{ending}");
        if files.iter().any(|(known, _)| *known == place) {
            return Err(PackError::Binaries(format!("two libraries for {:?}", binary.platform)));
        }
        files.push((place, read(&binary.path)?));
    }
    for resource in &description.resources {
        files.push((format!("resources/{}", resource.name), resource.bytes.to_vec()));
    }
    let page = description.documentation.as_bytes().to_vec();
    files.push(("documentation/index.html".to_owned(), page));
    if version == Version::Fmi3
        && let Some(xml) = description.terminals_and_icons()
    {
        files.push(("terminalsAndIcons/terminalsAndIcons.xml".to_owned(), xml.into_bytes()));
    }
    if !description.icon.is_empty() {
        let place = match version {
            Version::Fmi2 => "model.png",
            Version::Fmi3 => "terminalsAndIcons/icon.png",
        };
        files.push((place.to_owned(), description.icon.to_vec()));
    }
    files.extend_from_slice(further);
    write_zip(output, &files)
}

/// Writes named contents into a zip with fixed times, so that equal contents give equal bytes.
///
/// # Errors
/// [`PackError`] on a file error.
pub fn write_zip(output: &Path, files: &[(String, Vec<u8>)]) -> Result<(), PackError> {
    let file_error = |source| PackError::File { path: output.to_owned(), source };
    let zip_error = |source| PackError::Zip { path: output.to_owned(), source };
    if let Some(parent) = output.parent() {
        std::fs::create_dir_all(parent).map_err(file_error)?;
    }
    let mut zip = ZipWriter::new(File::create(output).map_err(file_error)?);
    let options = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Deflated)
        .last_modified_time(zip::DateTime::default())
        .unix_permissions(0o644);
    for (name, bytes) in files {
        zip.start_file(name.as_str(), options).map_err(zip_error)?;
        zip.write_all(bytes).map_err(file_error)?;
    }
    zip.finish().map_err(zip_error)?;
    Ok(())
}

fn read(path: &Path) -> Result<Vec<u8>, PackError> {
    std::fs::read(path).map_err(|source| PackError::File { path: path.to_owned(), source })
}
