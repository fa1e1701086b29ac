//! One random call of FMI 3.0.

use super::*;

impl World {
    pub(crate) fn call3(&mut self, i: *mut c_void) -> i32 {
        let (references, n) = self.references();
        let vr = if self.dice.one_in(20) { null() } else { references.as_ptr() };
        let m = if self.dice.one_in(10) { self.dice.below(4) as usize } else { n };
        let mut numbers = [self.dice.number(), self.dice.number(), self.dice.number()];
        let mut integers = [self.dice.below(6) as i32, 0, -1];
        let mut bits = [self.dice.next() as u8, 1, 0];
        let texts = [c"a".as_ptr(), c"fail".as_ptr(), c"\xff".as_ptr()];
        let mut read_texts = [null::<c_char>(); 3];
        let mut long = [0u64; 3];
        let mut size = 0usize;
        let which = self.dice.below(44);
        // SAFETY: every array has at least `n` and `m` (at most 3) elements, every string its zero
        // byte, every output place is ours; handles may be anything.
        unsafe {
            match which {
                0..=2 => c::fmi3EnterInitializationMode(i, 0, 0.0, 0.0, (n > 2).into(), numbers[0]),
                3 | 4 => c::fmi3ExitInitializationMode(i),
                5 if self.dice.one_in(20) => c::fmi3Terminate(i),
                6 if self.dice.one_in(4) => c::fmi3Reset(i),
                7 => c::fmi3GetFloat64(i, vr, n, numbers.as_mut_ptr(), m),
                8 => c::fmi3GetInt32(i, vr, n, integers.as_mut_ptr(), m),
                9 => c::fmi3GetBoolean(i, vr, n, bits.as_mut_ptr(), m),
                10 => c::fmi3GetString(i, vr, n, read_texts.as_mut_ptr(), m),
                11 => c::fmi3SetFloat64(i, vr, n, numbers.as_ptr(), m),
                12 => c::fmi3SetFloat64(i, [1].as_ptr(), 1, numbers.as_ptr(), 1),
                13 => c::fmi3SetInt32(i, vr, n, integers.as_ptr(), m),
                14 => c::fmi3SetInt32(i, [4].as_ptr(), 1, integers.as_ptr(), 1),
                15 => c::fmi3SetBoolean(i, vr, n, bits.as_ptr(), m),
                16 => c::fmi3SetString(i, vr, n, texts.as_ptr(), m),
                17 => {
                    let mut state = self.state_slot();
                    let status = c::fmi3GetFMUState(i, &raw mut state);
                    self.keep_state(status, state)
                }
                18 => c::fmi3SetFMUState(i, Self::pick(&mut self.dice, &self.states)),
                19 => {
                    let mut state = Self::pick(&mut self.dice, &self.states);
                    c::fmi3FreeFMUState(i, &raw mut state)
                }
                20 => {
                    let state = Self::pick(&mut self.dice, &self.states);
                    let status = c::fmi3SerializedFMUStateSize(i, state, &raw mut size);
                    let mut bytes = vec![0; if status == 0 { size } else { 10 }];
                    let len = bytes.len() - usize::from(self.dice.one_in(5));
                    let status = c::fmi3SerializeFMUState(i, state, bytes.as_mut_ptr(), len);
                    if status == 0 && self.saved.len() < 50 {
                        self.saved.push(bytes);
                    }
                    status
                }
                21 => {
                    let (bytes, mut state) = (self.damaged(), self.state_slot());
                    let made =
                        c::fmi3DeserializeFMUState(i, bytes.as_ptr(), bytes.len(), &raw mut state);
                    self.keep_state(made, state)
                }
                22 => c::fmi3SetDebugLogging(i, 1, n, texts.as_ptr()),
                23 => c::fmi3EnterEventMode(i),
                24 => c::fmi3EnterStepMode(i),
                25 => c::fmi3EnterConfigurationMode(i),
                26 => c::fmi3UpdateDiscreteStates(
                    i,
                    null_mut(),
                    null_mut(),
                    null_mut(),
                    null_mut(),
                    null_mut(),
                    null_mut(),
                ),
                27 => c::fmi3GetUInt64(i, vr, n, long.as_mut_ptr(), m),
                28 => c::fmi3SetClock(i, vr, n, bits.as_ptr()),
                29 => {
                    c::fmi3GetFloat64(i, vr, usize::MAX >> n, numbers.as_mut_ptr(), usize::MAX >> n)
                }
                30 => c::fmi3GetBinary(i, vr, n, &raw mut size, null_mut(), m),
                31 => c::fmi3SetTime(i, numbers[0]),
                32 => c::fmi3GetNumberOfEventIndicators(i, &raw mut size),
                33 => c::fmi3GetContinuousStates(i, numbers.as_mut_ptr(), n),
                34 => c::fmi3ActivateModelPartition(i, 1, numbers[0]),
                35 => c::fmi3GetOutputDerivatives(
                    i,
                    vr,
                    n,
                    integers.as_ptr(),
                    numbers.as_mut_ptr(),
                    m,
                ),
                36 => c::fmi3GetIntervalDecimal(i, vr, n, null_mut(), null_mut()),
                37 => {
                    let nothing = c::fmi3InstantiateModelExchange(
                        c"a".as_ptr(),
                        c"b".as_ptr(),
                        null(),
                        0,
                        1,
                        null_mut(),
                        Some(log3),
                    );
                    if nothing.is_null() { 0 } else { -1 }
                }
                // Back to a model that does not fail, so that steps are worth something.
                38 => c::fmi3SetInt32(i, [4].as_ptr(), 1, [0].as_ptr(), 1),
                _ => {
                    let mut now = 0.0;
                    c::fmi3GetFloat64(i, [0].as_ptr(), 1, &raw mut now, 1);
                    self.time = now;
                    let (begin, size) = self.step_times();
                    let (mut event, mut stop, mut early, mut last) = (0, 0, 0, 0.0);
                    let event = if self.dice.one_in(20) { null_mut() } else { &raw mut event };
                    let (stop, early, last) = (&raw mut stop, &raw mut early, &raw mut last);
                    c::fmi3DoStep(i, begin, size, 1, event, stop, early, last)
                }
            }
        }
    }
}
