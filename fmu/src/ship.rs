//! Everything that ships: both FMUs in both versions, the wired system, the OSP structure.

use std::path::{Path, PathBuf};

use crate::controller::ControllerFmu;
use crate::description::{Description, Version};
use crate::model::Model;
use crate::pack::{Binary, PackError, Platform, pack, write_zip};
use crate::system;
use crate::vehicle::VehicleFmu;

/// File names of the FMUs.
pub(crate) const CONTROLLER: &str = "lmpc-controller.fmu";
/// File names of the FMUs.
pub(crate) const VEHICLE: &str = "lmpc-vehicle.fmu";

/// A folder with the libraries of one platform.
#[derive(Clone, Debug)]
pub struct Libraries {
    /// What they are built for.
    pub platform: Platform,
    /// Where they are.
    pub folder: PathBuf,
}

impl Libraries {
    /// The platforms that have a folder in `folder`, named by the compiler's target triple.
    #[must_use]
    pub fn below(folder: &Path) -> Vec<Self> {
        let known = [
            (Platform::LinuxX64, "x86_64-unknown-linux-gnu"),
            (Platform::WindowsX64, "x86_64-pc-windows-gnu"),
            (Platform::LinuxArm64, "aarch64-unknown-linux-gnu"),
        ];
        let all = known.map(|(platform, name)| Self { platform, folder: folder.join(name) });
        all.into_iter().filter(|l| l.folder.is_dir()).collect()
    }
}

/// The models that ship, with the names of their files.
#[must_use]
pub fn models() -> [(&'static str, &'static Description); 2] {
    [(CONTROLLER, ControllerFmu::description()), (VEHICLE, VehicleFmu::description())]
}

/// Writes `fmi2/` and `fmi3/` with both FMUs, `lmpc-race.ssp` (FMI 2.0) and
/// `fmi3/lmpc-race.ssp`, its parameter sets `barc.ssv`, `kart.ssv`, `iac.ssv` inside and beside
/// them, and `osp/OspSystemStructure.xml`; returns the files.
///
/// # Errors
/// [`PackError`] if a library is missing or a file cannot be written.
pub fn ship(libraries: &[Libraries], out: &Path) -> Result<Vec<PathBuf>, PackError> {
    let mut written = Vec::new();
    for (version, folder) in [(Version::Fmi2, "fmi2"), (Version::Fmi3, "fmi3")] {
        for (file, description) in models() {
            let path = out.join(folder).join(file);
            pack(description, version, &binaries(libraries, description, version), &path)?;
            written.push(path);
        }
        let below = if version == Version::Fmi2 { out.to_owned() } else { out.join(folder) };
        let path = below.join("lmpc-race.ssp");
        write_system(&out.join(folder), &path)?;
        written.push(path);
    }
    for set in system::SETS {
        let path = out.join(format!("{}.ssv", set.car));
        let error = |source| PackError::File { path: path.clone(), source };
        std::fs::write(&path, system::ssv(&set)).map_err(error)?;
        written.push(path);
    }
    let path = out.join("osp/OspSystemStructure.xml");
    let error = |source| PackError::File { path: path.clone(), source };
    std::fs::create_dir_all(out.join("osp")).map_err(error)?;
    std::fs::write(&path, system::osp_structure("../fmi2")).map_err(error)?;
    written.push(path);
    Ok(written)
}

/// The libraries of one model, without platforms the version has no folder for.
fn binaries(libraries: &[Libraries], d: &Description, version: Version) -> Vec<Binary> {
    let usable = libraries.iter().filter(|l| l.platform.folder(version).is_some());
    let binary = |l: &Libraries| {
        let prefix = if l.platform == Platform::WindowsX64 { "" } else { "lib" };
        let file = format!("{prefix}{}.{}", d.model_identifier, l.platform.extension());
        Binary { platform: l.platform, path: l.folder.join(file) }
    };
    usable.map(binary).collect()
}

/// The wired system with both FMUs inside.
fn write_system(fmus: &Path, output: &Path) -> Result<(), PackError> {
    let ssd = system::ssd().into_bytes();
    let mut files = vec![("SystemStructure.ssd".to_owned(), ssd)];
    for set in system::SETS {
        files.push((format!("resources/{}.ssv", set.car), system::ssv(&set).into_bytes()));
    }
    for (file, _) in models() {
        let path = fmus.join(file);
        let bytes = std::fs::read(&path).map_err(|source| PackError::File { path, source })?;
        files.push((format!("resources/{file}"), bytes));
    }
    write_zip(output, &files)
}
