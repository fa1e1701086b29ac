//! One random call of FMI 2.0.

use super::*;

impl World {
    pub(crate) fn call2(&mut self, i: *mut c_void) -> i32 {
        let (references, n) = self.references();
        let vr = if self.dice.one_in(20) { null() } else { references.as_ptr() };
        let mut numbers = [self.dice.number(), self.dice.number(), self.dice.number()];
        let mut integers = [self.dice.below(6) as i32, 0, -1];
        let texts = [c"a".as_ptr(), c"fail".as_ptr(), c"\xff".as_ptr()];
        let mut read_texts = [null::<c_char>(); 3];
        let (mut size, mut kind) = (0usize, 0i32);
        let which = self.dice.below(36);
        // SAFETY: every array has at least `n` (at most 3) elements, every string its zero byte,
        // every output place is ours; handles may be anything.
        unsafe {
            match which {
                0 => c::fmi2SetupExperiment(i, 0, 0.0, 0.0, (n > 2).into(), numbers[0]),
                1 | 2 => c::fmi2EnterInitializationMode(i),
                3 | 4 => c::fmi2ExitInitializationMode(i),
                5 if self.dice.one_in(20) => c::fmi2Terminate(i),
                6 if self.dice.one_in(4) => c::fmi2Reset(i),
                7 => c::fmi2GetReal(i, vr, n, numbers.as_mut_ptr()),
                8 => c::fmi2GetInteger(i, vr, n, integers.as_mut_ptr()),
                9 => c::fmi2GetBoolean(i, vr, n, integers.as_mut_ptr()),
                10 => c::fmi2GetString(i, vr, n, read_texts.as_mut_ptr()),
                11 => c::fmi2SetReal(i, vr, n, numbers.as_ptr()),
                12 => c::fmi2SetReal(i, [1].as_ptr(), 1, numbers.as_ptr()),
                13 => c::fmi2SetInteger(i, vr, n, integers.as_ptr()),
                14 => c::fmi2SetInteger(i, [4].as_ptr(), 1, integers.as_ptr()),
                15 => c::fmi2SetBoolean(i, vr, n, integers.as_ptr()),
                16 => c::fmi2SetString(i, vr, n, texts.as_ptr()),
                17 => {
                    let mut state = self.state_slot();
                    let status = c::fmi2GetFMUstate(i, &raw mut state);
                    self.keep_state(status, state)
                }
                18 => c::fmi2SetFMUstate(i, Self::pick(&mut self.dice, &self.states)),
                19 => {
                    let mut state = Self::pick(&mut self.dice, &self.states);
                    c::fmi2FreeFMUstate(i, &raw mut state)
                }
                20 => {
                    let state = Self::pick(&mut self.dice, &self.states);
                    let status = c::fmi2SerializedFMUstateSize(i, state, &raw mut size);
                    let mut bytes = vec![0; if status == 0 { size } else { 10 }];
                    let len = bytes.len() - usize::from(self.dice.one_in(5));
                    let status = c::fmi2SerializeFMUstate(i, state, bytes.as_mut_ptr(), len);
                    if status == 0 && self.saved.len() < 50 {
                        self.saved.push(bytes);
                    }
                    status
                }
                21 => {
                    let (bytes, mut state) = (self.damaged(), self.state_slot());
                    let made =
                        c::fmi2DeSerializeFMUstate(i, bytes.as_ptr(), bytes.len(), &raw mut state);
                    self.keep_state(made, state)
                }
                22 => c::fmi2SetDebugLogging(i, 1, n, texts.as_ptr()),
                23 => c::fmi2CancelStep(i),
                24 => c::fmi2GetRealStatus(i, n as i32, numbers.as_mut_ptr()),
                25 => c::fmi2GetBooleanStatus(i, n as i32, &raw mut kind),
                26 => c::fmi2GetStatus(i, n as i32, &raw mut kind),
                27 => c::fmi2GetStringStatus(i, 0, read_texts.as_mut_ptr()),
                28 => c::fmi2SetRealInputDerivatives(i, vr, n, integers.as_ptr(), numbers.as_ptr()),
                29 => c::fmi2GetReal(i, vr, usize::MAX >> n, numbers.as_mut_ptr()),
                30 => c::fmi2GetDirectionalDerivative(i, vr, n, vr, n, null(), null_mut()),
                // Back to a model that does not fail, so that steps are worth something.
                31 => c::fmi2SetInteger(i, [4].as_ptr(), 1, [0].as_ptr()),
                _ => {
                    let mut now = 0.0;
                    c::fmi2GetReal(i, [0].as_ptr(), 1, &raw mut now);
                    self.time = now;
                    let (begin, size) = self.step_times();
                    c::fmi2DoStep(i, begin, size, 1)
                }
            }
        }
    }
}
