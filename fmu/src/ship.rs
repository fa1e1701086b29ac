//! Everything that ships: both FMUs in both versions, the wired system, the OSP structure.

use std::path::{Path, PathBuf};

use crate::controller::ControllerFmu;
use crate::description::{Description, Version};
use crate::model::FmuModel;
use crate::pack::{Binary, PackError, Platform, pack_with, write_zip};
use crate::related::{Related, related};
use crate::system::{self, Element, Ssp};
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

/// Writes `fmi2/` and `fmi3/` with both FMUs; the wired system as `lmpc-race.ssp` (SSP 1.0, FMI 2.0),
/// `fmi3/lmpc-race.ssp` (SSP 1.0, FMI 3.0) and `ssp2/lmpc-race.ssp` (SSP 2.0, FMI 3.0); its parameter
/// sets `barc.ssv`, `kart.ssv`, `iac.ssv` inside and beside them; and `osp/OspSystemStructure.xml`.
/// Returns the files.
///
/// # Errors
/// [`PackError`] if a library is missing or a file cannot be written.
pub fn ship(libraries: &[Libraries], out: &Path) -> Result<Vec<PathBuf>, PackError> {
    let mut written = Vec::new();
    let Related { controller, vehicle } = related()?;
    for (version, folder) in [(Version::Fmi2, "fmi2"), (Version::Fmi3, "fmi3")] {
        for ((file, description), further) in models().into_iter().zip([&controller, &vehicle]) {
            let path = out.join(folder).join(file);
            let libraries = binaries(libraries, description, version);
            pack_with(description, version, &libraries, further, &path)?;
            written.push(path);
        }
    }
    let systems = [
        (Ssp::V1, "fmi2", "lmpc-race.ssp"),
        (Ssp::V1, "fmi3", "fmi3/lmpc-race.ssp"),
        (Ssp::V2, "fmi3", "ssp2/lmpc-race.ssp"),
    ];
    for (ssp, fmus, file) in systems {
        let path = out.join(file);
        write_system(ssp, &out.join(fmus), &path)?;
        written.push(path);
    }
    for set in system::SETS {
        let path = out.join(format!("{}.ssv", set.car));
        write_text(&path, &system::ssv(Ssp::V1, &set, Element::System))?;
        written.push(path);
    }
    let path = out.join("osp/OspSystemStructure.xml");
    write_text(&path, &system::osp_structure("../fmi2"))?;
    written.push(path);
    Ok(written)
}

fn write_text(path: &Path, text: &str) -> Result<(), PackError> {
    let error = |source| PackError::File { path: path.to_owned(), source };
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder).map_err(error)?;
    }
    std::fs::write(path, text).map_err(error)
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

/// The wired system with both FMUs and the parameter sets inside.
fn write_system(ssp: Ssp, fmus: &Path, output: &Path) -> Result<(), PackError> {
    let mut files = vec![("SystemStructure.ssd".to_owned(), system::ssd(ssp).into_bytes())];
    for set in system::SETS {
        let text = system::ssv(ssp, &set, Element::System);
        files.push((format!("resources/{}.ssv", set.car), text.into_bytes()));
    }
    for (file, _) in models() {
        let path = fmus.join(file);
        let bytes = std::fs::read(&path).map_err(|source| PackError::File { path, source })?;
        files.push((format!("resources/{file}"), bytes));
    }
    write_zip(output, &files)
}
