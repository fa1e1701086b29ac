//! The Rust end of the interoperability test with the official tools.
//!
//! `wire hashes FILE…` prints the fingerprint of each type, `wire emit COUNT SEED FILE…` writes
//! random messages to standard output, and `wire check COUNT SEED FILE…` compares what comes back on
//! standard input with what was sent, byte for byte. A message travels as the length and text of
//! its type's name and the length and bytes of its encoding, lengths as 32 bit big-endian.

use std::error::Error;
use std::io::{BufReader, BufWriter, Read, Write, stdin, stdout};

use lcm_types::schema::{Schema, Struct};
use rand::SeedableRng;
use rand_pcg::Pcg64;

#[path = "../tests/common/random.rs"]
mod random;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match words.as_slice() {
        ["hashes", files @ ..] => hashes(&schema(files)?),
        ["emit", count, seed, files @ ..] => emit(&schema(files)?, count.parse()?, seed.parse()?),
        ["check", count, seed, files @ ..] => check(&schema(files)?, count.parse()?, seed.parse()?),
        _ => Err("expected hashes FILE… | emit COUNT SEED FILE… | check COUNT SEED FILE…".into()),
    }
}

fn schema(files: &[&str]) -> Result<Schema, Box<dyn Error>> {
    let texts: Vec<String> = files.iter().map(std::fs::read_to_string).collect::<Result<_, _>>()?;
    let named: Vec<(&str, &str)> =
        files.iter().zip(&texts).map(|(name, text)| (*name, text.as_str())).collect();
    Ok(Schema::parse(&named)?)
}

fn hashes(schema: &Schema) -> Result<(), Box<dyn Error>> {
    let mut names: Vec<String> = schema.structs.iter().map(Struct::full_name).collect();
    names.sort();
    for name in names {
        let fingerprint = schema.fingerprint(&name).ok_or("no fingerprint")?;
        writeln!(stdout(), "{name} {fingerprint:016x}")?;
    }
    Ok(())
}

/// The same messages for the same seed: calls `each` with the type's name and the bytes.
fn messages(
    schema: &Schema,
    count: usize,
    seed: u64,
    mut each: impl FnMut(&str, &[u8]) -> Result<(), Box<dyn Error>>,
) -> Result<(), Box<dyn Error>> {
    let names: Vec<String> = schema.structs.iter().map(Struct::full_name).collect();
    let mut rng = Pcg64::seed_from_u64(seed);
    let mut bytes = Vec::new();
    for name in names.iter().cycle().take(count) {
        schema.encode_into(name, &random::message(schema, name, &mut rng), &mut bytes)?;
        each(name, &bytes)?;
    }
    Ok(())
}

fn emit(schema: &Schema, count: usize, seed: u64) -> Result<(), Box<dyn Error>> {
    let mut out = BufWriter::new(stdout().lock());
    messages(schema, count, seed, |name, bytes| {
        for part in [name.as_bytes(), bytes] {
            out.write_all(&u32::try_from(part.len())?.to_be_bytes())?;
            out.write_all(part)?;
        }
        Ok(())
    })?;
    Ok(out.flush()?)
}

fn check(schema: &Schema, count: usize, seed: u64) -> Result<(), Box<dyn Error>> {
    let mut input = BufReader::new(stdin().lock());
    let mut part = || -> Result<Vec<u8>, Box<dyn Error>> {
        let mut length = [0; 4];
        input.read_exact(&mut length)?;
        let mut bytes = vec![0; u32::from_be_bytes(length) as usize];
        input.read_exact(&mut bytes)?;
        Ok(bytes)
    };
    let (mut messages_seen, mut bytes_seen) = (0_usize, 0_usize);
    messages(schema, count, seed, |name, bytes| {
        if part()? != name.as_bytes() || part()? != bytes {
            return Err(format!("message {messages_seen} of type {name} came back changed").into());
        }
        schema.decode(name, bytes)?;
        messages_seen += 1;
        bytes_seen += bytes.len();
        Ok(())
    })?;
    writeln!(stdout(), "{messages_seen} messages, {bytes_seen} bytes, all identical")?;
    Ok(())
}
