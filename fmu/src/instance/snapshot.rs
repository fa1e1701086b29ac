//! FMU states: taken, restored, written to bytes and read back.

use std::sync::atomic::{AtomicUsize, Ordering};

use super::{Core, Instance, Phase};
use crate::bytes::{Reader, Writer};
use crate::checksum::fnv1a;
use crate::model::{Io, Model};
use crate::status::Fault;
use crate::values::Values;

/// Everything an FMU state holds.
pub(super) type Snapshot<M> = Core<M>;

const MAGIC: &[u8; 8] = b"LMPC-FMU";
const FORMAT: u64 = 1;
/// Magic, format, token hash, payload length, checksum.
const HEADER: usize = 40;

/// Handles are numbers never used twice in a process, so a freed, foreign or made-up one is told
/// apart from a living one without touching memory.
static NEXT_HANDLE: AtomicUsize = AtomicUsize::new(1);

impl<M: Model> Instance<M> {
    /// Takes the state into a new handle, or into `old` if that names a state of this instance.
    pub(crate) fn get_state(&mut self, function: &str, old: usize) -> Result<usize, Fault> {
        self.allow(function, &Phase::ALL[..5])?;
        let snapshot = self.core.clone();
        if old != 0 && !self.snapshots.contains_key(&old) {
            return Err(unknown(function));
        }
        Ok(self.keep(old, snapshot))
    }

    pub(crate) fn set_state(&mut self, function: &str, handle: usize) -> Result<(), Fault> {
        self.allow(function, &Phase::ALL[..5])?;
        let snapshot = self.snapshots.get(&handle).ok_or_else(|| unknown(function))?;
        self.core = snapshot.clone();
        Ok(())
    }

    pub(crate) fn free_state(&mut self, function: &str, handle: usize) -> Result<(), Fault> {
        if handle == 0 {
            return Ok(());
        }
        self.snapshots.remove(&handle).map(drop).ok_or_else(|| unknown(function))
    }

    /// The bytes of a state.
    pub(crate) fn serialize(&mut self, function: &str, handle: usize) -> Result<Vec<u8>, Fault> {
        self.allow(function, &Phase::ALL[..5])?;
        let snapshot = self.snapshots.get(&handle).ok_or_else(|| unknown(function))?;
        let payload = Self::guarded(function, || write(snapshot))?;
        let mut writer = Writer::default();
        writer.u64(u64::from_le_bytes(*MAGIC));
        writer.u64(FORMAT);
        writer.u64(token_hash::<M>());
        writer.u64(payload.len() as u64);
        writer.u64(fnv1a(&payload));
        let mut bytes = writer.finish();
        bytes.extend_from_slice(&payload);
        Ok(bytes)
    }

    /// Rebuilds a state from bytes and returns its handle.
    pub(crate) fn deserialize(
        &mut self,
        function: &str,
        bytes: &[u8],
        old: usize,
    ) -> Result<usize, Fault> {
        self.allow(function, &Phase::ALL[..5])?;
        if old != 0 && !self.snapshots.contains_key(&old) {
            return Err(unknown(function));
        }
        let payload = payload::<M>(bytes)
            .map_err(|reason| Fault::Refused(format!("{function}: {reason}")))?;
        let (resources, log) = (self.resources.as_deref(), &mut self.log);
        let read =
            |values: &mut Values, model: &[u8]| M::load(&mut Io { values, resources, log }, model);
        let snapshot = Self::guarded(function, || read_core::<M>(payload, read))
            .map_err(|fault| Fault::Refused(fault.to_string()))?;
        Ok(self.keep(old, snapshot))
    }

    fn keep(&mut self, old: usize, snapshot: Snapshot<M>) -> usize {
        let handle = match old {
            0 => NEXT_HANDLE.fetch_add(1, Ordering::Relaxed),
            old => old,
        };
        self.snapshots.insert(handle, snapshot);
        handle
    }
}

fn unknown(function: &str) -> Fault {
    Fault::Refused(format!("{function}: the FMU state is not one of this instance, or was freed"))
}

fn token_hash<M: Model>() -> u64 {
    fnv1a(M::description().token().as_bytes())
}

/// Checks the header and returns what it covers.
fn payload<M: Model>(bytes: &[u8]) -> Result<&[u8], String> {
    let Some((head, payload)) = bytes.split_at_checked(HEADER) else {
        return Err(format!("{} bytes are too few for a saved state", bytes.len()));
    };
    let mut reader = Reader::new(head);
    let mut next = || reader.u64().unwrap_or_default();
    if next() != u64::from_le_bytes(*MAGIC) {
        return Err("these bytes are not a saved state of this kind of FMU".to_owned());
    }
    let format = next();
    if format != FORMAT {
        return Err(format!("saved state of format {format}; this FMU reads format {FORMAT}"));
    }
    if next() != token_hash::<M>() {
        return Err("the saved state comes from another model or another version of it".to_owned());
    }
    let length = next();
    if length != payload.len() as u64 {
        return Err(format!(
            "the saved state has {} bytes after its header, not the {length} it announces",
            payload.len()
        ));
    }
    if next() != fnv1a(payload) {
        return Err("the saved state is damaged: its checksum does not match".to_owned());
    }
    Ok(payload)
}

fn write<M: Model>(core: &Core<M>) -> Result<Vec<u8>, Fault> {
    let mut writer = Writer::default();
    let phase = Phase::ALL.iter().position(|p| *p == core.phase).unwrap_or_default();
    writer.u64(phase as u64);
    writer.f64(core.origin);
    writer.f64(core.time);
    writer.u64(u64::from(core.stop.is_some()));
    writer.f64(core.stop.unwrap_or_default());
    writer.f64s(&core.values.numbers);
    core.values.texts.iter().for_each(|text| writer.blob(text.as_bytes()));
    writer.u64(u64::from(core.model.is_some()));
    if let Some(model) = &core.model {
        writer.blob(&model.save()?);
    }
    Ok(writer.finish())
}

fn read_core<M: Model>(
    bytes: &[u8],
    load: impl FnOnce(&mut Values, &[u8]) -> Result<M, Fault>,
) -> Result<Core<M>, Fault> {
    let mut reader = Reader::new(bytes);
    let (mut core, model) = read_fields(&mut reader)
        .ok_or_else(|| Fault::Refused("the saved state ends too early".to_owned()))?;
    if let Some(model) = model {
        core.model = Some(load(&mut core.values, model)?);
    }
    Ok(core)
}

fn read_fields<'a, M: Model>(reader: &mut Reader<'a>) -> Option<(Core<M>, Option<&'a [u8]>)> {
    let table = &M::description().table;
    let phase = *Phase::ALL.get(usize::try_from(reader.u64()?).ok()?)?;
    let (origin, time) = (reader.f64()?, reader.f64()?);
    let (stops, stop) = (reader.u64()? != 0, reader.f64()?);
    let mut values = Values::start(table);
    values.numbers = reader.f64s().filter(|n| n.len() == table.variables().len())?;
    for text in &mut values.texts {
        *text = String::from_utf8(reader.blob()?.to_vec()).ok()?;
    }
    let model = if reader.u64()? == 0 { None } else { Some(reader.blob()?) };
    // A state that claims to step without a model would be a lie.
    if !reader.is_empty() || (phase == Phase::Stepping && model.is_none()) {
        return None;
    }
    let stop = stops.then_some(stop);
    Some((Core { phase, origin, time, stop, values, model: None }, model))
}
