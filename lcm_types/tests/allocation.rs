//! No message makes the decoder reserve more than the message warrants.
#![allow(unsafe_code, reason = "an allocator that counts")]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use lcm_types::schema::Schema;
use lcm_types::{Message, MpcTelemetry, Track};
use rand::SeedableRng;
use rand_pcg::Pcg64;

#[path = "common/random.rs"]
mod random;

thread_local! {
    static HELD: Cell<usize> = const { Cell::new(0) };
    static PEAK: Cell<usize> = const { Cell::new(0) };
}

struct Counting;

// SAFETY: every call is handed on unchanged to the system's allocator; the counters are plain
// cells of the thread and allocate nothing.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        HELD.set(HELD.get() + layout.size());
        PEAK.set(PEAK.get().max(HELD.get()));
        // SAFETY: the caller's promise is passed on.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        HELD.set(HELD.get().saturating_sub(layout.size()));
        // SAFETY: the caller's promise is passed on.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Bytes held at most while `work` ran, beyond what was held before.
fn peak(work: impl FnOnce()) -> usize {
    let before = HELD.get();
    PEAK.set(before);
    work();
    PEAK.get() - before
}

#[test]
fn decoding_reserves_a_small_multiple_of_the_message() {
    let schema = Schema::parse(lcm_types::SOURCES).unwrap();
    let mut rng = Pcg64::seed_from_u64(10);
    let mut bytes = Vec::new();
    for index in 0..20_000 {
        let name = ["lmpc.mpc_telemetry_t", "lmpc.track_t"][index % 2];
        let value = random::message(&schema, name, &mut rng);
        schema.encode_into(name, &value, &mut bytes).unwrap();
        random::damage(&mut bytes, &mut rng);
        let reserved = peak(|| {
            if index % 2 == 0 {
                drop(MpcTelemetry::decode(&bytes));
            } else {
                drop(Track::decode(&bytes));
            }
        });
        // Rows without a byte are the one thing that costs more: 4096 empty vectors.
        let limit = 8 * bytes.len() + 4096 * size_of::<Vec<f32>>() + 1024;
        assert!(reserved <= limit, "{reserved} bytes for a message of {}", bytes.len());
        // As a value of a type known at run time, each number takes the room of a `Value`.
        let reserved = peak(|| drop(schema.decode(name, &bytes)));
        let limit = 64 * bytes.len() + 4096 * 64 + 4096;
        assert!(reserved <= limit, "{reserved} bytes for a message of {}", bytes.len());
    }
}
