//! FMU states: taken, restored, written to bytes and read back.

use std::sync::atomic::{AtomicUsize, Ordering};

use super::{Core, Instance, Phase};
use crate::bytes::{ByteReader, ByteWriter};
use crate::checksum::fnv1a;
use crate::model::FmuModel;
use crate::status::CallError;
use crate::values::VariableValues;
use crate::variable::Role;

/// Everything an FMU state holds.
pub(super) struct FmuState<M: FmuModel> {
    core: Core,
    state: Option<M::State>,
}

const MAGIC: &[u8; 8] = b"LMPC-FMU";
const FORMAT: u64 = 2;
/// Magic, format, token hash, payload length, checksum.
const HEADER: usize = 40;

/// Handles are numbers never used twice in a process, so a freed, foreign or made-up one is told
/// apart from a living one without touching memory.
static NEXT_HANDLE: AtomicUsize = AtomicUsize::new(1);

impl<M: FmuModel> Instance<M> {
    /// Takes the state into a new handle, or into `old` if that names a state of this instance.
    pub(crate) fn get_state(&mut self, function: &str, old: usize) -> Result<usize, CallError> {
        self.allow(function, &Phase::ALL[..5])?;
        let state = self.model.as_ref().map(M::state);
        let snapshot = FmuState { core: self.core.clone(), state };
        if old != 0 && !self.snapshots.contains_key(&old) {
            return Err(unknown(function));
        }
        Ok(self.keep(old, snapshot))
    }

    /// Goes back to a state; whatever goes wrong, the instance stays where it is.
    pub(crate) fn set_state(&mut self, function: &str, handle: usize) -> Result<(), CallError> {
        self.allow(function, &Phase::ALL[..5])?;
        let snapshot = self.snapshots.remove(&handle).ok_or_else(|| unknown(function))?;
        let done = self.adopt(function, &snapshot);
        self.snapshots.insert(handle, snapshot);
        done.map_err(|fault| CallError::Refused(format!("{function}: {fault}")))
    }

    fn adopt(&mut self, function: &str, snapshot: &FmuState<M>) -> Result<(), CallError> {
        let Some(state) = &snapshot.state else {
            (self.core, self.model) = (snapshot.core.clone(), None);
            return Ok(());
        };
        let reusable = self.core.phase != Phase::Failed && self.same_fixed(&snapshot.core.values);
        match self.model.as_mut().filter(|_| reusable) {
            Some(model) => Self::guarded(function, || model.resume(state))?,
            None => {
                let mut values = snapshot.core.values.clone();
                let mut model = self.build(&mut values)?;
                Self::guarded(function, || model.resume(state))?;
                self.model = Some(model);
            }
        }
        self.core.clone_from(&snapshot.core);
        Ok(())
    }

    /// Whether the present model was built from the same fixed parameters.
    fn same_fixed(&self, values: &VariableValues) -> bool {
        let here = &self.core.values;
        let variables = M::description().table.variables().iter().enumerate();
        variables.filter(|(_, v)| v.role == Role::Fixed).all(|(i, _)| {
            values.numbers[i].to_bits() == here.numbers[i].to_bits()
                && values.texts[i] == here.texts[i]
        })
    }

    pub(crate) fn free_state(&mut self, function: &str, handle: usize) -> Result<(), CallError> {
        if handle == 0 {
            return Ok(());
        }
        self.snapshots.remove(&handle).map(drop).ok_or_else(|| unknown(function))
    }

    /// The bytes of a state.
    pub(crate) fn serialize(
        &mut self,
        function: &str,
        handle: usize,
    ) -> Result<Vec<u8>, CallError> {
        self.allow(function, &Phase::ALL[..5])?;
        let snapshot = self.snapshots.get(&handle).ok_or_else(|| unknown(function))?;
        let payload = Self::guarded(function, || write::<M>(snapshot))?;
        let mut writer = ByteWriter::default();
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
    ) -> Result<usize, CallError> {
        self.allow(function, &Phase::ALL[..5])?;
        if old != 0 && !self.snapshots.contains_key(&old) {
            return Err(unknown(function));
        }
        let payload = payload::<M>(bytes)
            .map_err(|reason| CallError::Refused(format!("{function}: {reason}")))?;
        let snapshot = Self::guarded(function, || read_snapshot::<M>(payload))
            .map_err(|fault| CallError::Refused(format!("{function}: {fault}")))?;
        Ok(self.keep(old, snapshot))
    }

    fn keep(&mut self, old: usize, snapshot: FmuState<M>) -> usize {
        let handle = match old {
            0 => NEXT_HANDLE.fetch_add(1, Ordering::Relaxed),
            old => old,
        };
        self.snapshots.insert(handle, snapshot);
        handle
    }
}

fn unknown(function: &str) -> CallError {
    CallError::Refused(format!(
        "{function}: the FMU state is not one of this instance, or was freed"
    ))
}

fn token_hash<M: FmuModel>() -> u64 {
    fnv1a(M::description().token().as_bytes())
}

/// Checks the header and returns what it covers.
fn payload<M: FmuModel>(bytes: &[u8]) -> Result<&[u8], String> {
    let Some((head, payload)) = bytes.split_at_checked(HEADER) else {
        return Err(format!("{} bytes are too few for a saved state", bytes.len()));
    };
    let mut reader = ByteReader::new(head);
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

fn write<M: FmuModel>(snapshot: &FmuState<M>) -> Result<Vec<u8>, CallError> {
    let core = &snapshot.core;
    let mut writer = ByteWriter::default();
    let phase = Phase::ALL.iter().position(|p| *p == core.phase).unwrap_or_default();
    writer.u64(phase as u64);
    writer.f64(core.origin);
    writer.f64(core.time);
    writer.u64(u64::from(core.stop.is_some()));
    writer.f64(core.stop.unwrap_or_default());
    writer.f64s(&core.values.numbers);
    core.values.texts.iter().for_each(|text| writer.blob(text.as_bytes()));
    writer.u64(u64::from(snapshot.state.is_some()));
    if let Some(state) = &snapshot.state {
        writer.blob(&M::save(state)?);
    }
    Ok(writer.finish())
}

fn read_snapshot<M: FmuModel>(bytes: &[u8]) -> Result<FmuState<M>, CallError> {
    let mut reader = ByteReader::new(bytes);
    let (core, state) = read_fields::<M>(&mut reader)
        .ok_or_else(|| CallError::Refused("the saved state ends too early".to_owned()))?;
    Ok(FmuState { core, state: state.map(M::load).transpose()? })
}

fn read_fields<'a, M: FmuModel>(reader: &mut ByteReader<'a>) -> Option<(Core, Option<&'a [u8]>)> {
    let table = &M::description().table;
    let phase = *Phase::ALL.get(usize::try_from(reader.u64()?).ok()?)?;
    let (origin, time) = (reader.f64()?, reader.f64()?);
    let (stops, stop) = (reader.u64()? != 0, reader.f64()?);
    let mut values = VariableValues::start(table);
    values.numbers = reader.f64s().filter(|n| n.len() == table.variables().len())?;
    for text in &mut values.texts {
        *text = String::from_utf8(reader.blob()?.to_vec()).ok()?;
    }
    let state = if reader.u64()? == 0 { None } else { Some(reader.blob()?) };
    // A state that claims to step without a model would be a lie.
    if !reader.is_empty() || (phase == Phase::Stepping && state.is_none()) {
        return None;
    }
    Some((Core { phase, origin, time, stop: stops.then_some(stop), values }, state))
}
