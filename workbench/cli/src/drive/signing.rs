//! `bearing-watch sign`: keys, signatures of model files, and their verification.

use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use bearing_watch::model::stored_len;
use bearing_watch::signature::{PublicKey, Trust, head, key_id};
use ed25519_compact::{KeyPair, Seed};

use crate::command_line::output;
use model::Error;

/// First line of a file with a private key; the second is the key in hexadecimal digits.
const TITLE: &str = "bearing-watch private key 1";

/// Sign a model file, for firmware that accepts the models of some keys only; make keys, and verify signatures
///
/// The signature follows the model in the same file, which is replaced when it is complete; an earlier signature goes.
/// Firmware without signatures, and the other commands, read the file as before.
///
/// A new key comes from the random numbers of the system. Only the owner can read its file (mode 0600), and no existing
/// file is replaced. Keep it where models are made, with a copy: whoever has it can sign models that drives accept.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  bearing-watch sign --key vendor.key --new
  bearing-watch sign drive.bwm --key vendor.key --counter 2
  bearing-watch sign drive.bwm --key vendor.key --verify --least 2")]
pub(crate) struct Args {
    /// The model file; without one the public key is printed, as arrays for firmware
    model: Option<PathBuf>,
    /// File of the private key; to verify, also the public key in 64 hexadecimal digits
    #[arg(long, value_name = "KEY")]
    key: String,
    /// Make this private key, and print its public one
    #[arg(long, conflicts_with = "model")]
    new: bool,
    /// Number of the model: firmware refuses a lower one than it was told, so that an old model cannot come back
    #[arg(long, value_name = "N", default_value_t = 1, requires = "model")]
    counter: u32,
    /// Another file for the signed model
    #[arg(long, value_name = "FILE", requires = "model")]
    out: Option<PathBuf>,
    /// Verify the signature instead, as firmware does
    #[arg(long, requires = "model", conflicts_with_all = ["counter", "out"])]
    verify: bool,
    /// The least counter that is accepted
    #[arg(long, value_name = "N", default_value_t = 0, requires = "verify")]
    least: u32,
}

pub(crate) fn run(args: &Args) -> Result<(), Error> {
    match &args.model {
        None => keys(args),
        Some(model) if args.verify => verify(args, model),
        Some(model) => sign(args, model),
    }
}

fn keys(args: &Args) -> Result<(), Error> {
    let path = Path::new(&args.key);
    let pair = if args.new { create(path)? } else { read(path)? };
    let public: PublicKey = *pair.pk;
    output::say(format!("key {}", hexadecimal(&key_id(&public))))?;
    output::say(format!("public key {}", hexadecimal(&public)))?;
    let rows = public.chunks(8).fold(String::new(), |mut text, row| {
        let row: Vec<String> = row.iter().map(|byte| format!("0x{byte:02x}")).collect();
        let _string_grows = write!(text, "\n    {},", row.join(", "));
        text
    });
    output::say(format!("pub const KEY: [u8; 32] = [{rows}\n];"))?;
    output::say(format!("static const uint8_t key[32] = {{{rows}\n}};"))
}

fn sign(args: &Args, model: &Path) -> Result<(), Error> {
    let key_file = PathBuf::from(&args.key);
    let pair = read(&key_file)?;
    let mut bytes = unsigned(model)?;
    let length = u32::try_from(bytes.len()).map_err(|_| Error::content(model, "model", "it is too long"))?;
    bytes.extend(head(length, &pair.pk, args.counter));
    bytes.extend(*pair.sk.sign(&bytes, None));
    let out = args.out.as_deref().unwrap_or(model);
    output::plan(&[out], std::slice::from_ref(&key_file))?;
    output::write(out, bytes)?;
    let key = hexadecimal(&key_id(&pair.pk));
    output::say(format!("{}: signed by key {key}, counter {}", out.display(), args.counter))
}

fn verify(args: &Args, model: &Path) -> Result<(), Error> {
    let key = match bytes_of(&args.key) {
        Some(key) => key,
        None => *read(Path::new(&args.key))?.pk,
    };
    let bytes = std::fs::read(model).map_err(Error::io(model))?;
    let trust = Trust { keys: &[key], least_counter: args.least };
    let wrong = |problem: String| Error::content(model, "signature", problem);
    let signed = trust.verify(&bytes).map_err(|error| wrong(error.to_string()))?;
    if signed.length != bytes.len() {
        return Err(wrong("more bytes follow it".into()));
    }
    let name = model.display();
    output::say(format!("{name}: signed by key {}, counter {}", hexadecimal(&key_id(&key)), signed.counter))
}

/// The model of a file, without a signature.
fn unsigned(path: &Path) -> Result<Vec<u8>, Error> {
    // Nothing is signed that firmware would refuse.
    let mut bytes = std::fs::read(path).map_err(Error::io(path))?;
    model::session::ModelFile::new(path, &bytes)?;
    let length = stored_len(&bytes).map_err(|error| Error::content(path, "model", error.to_string()))?;
    bytes.truncate(length);
    Ok(bytes)
}

/// Makes a key and its file.
fn create(path: &Path) -> Result<KeyPair, Error> {
    let mut seed = [0; 32];
    getrandom::fill(&mut seed).map_err(|error| Error::Usage(format!("the system gives no random numbers: {error}")))?;
    let mut file = std::fs::OpenOptions::new();
    file.write(true).create_new(true);
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::mode(&mut file, 0o600);
    let text = format!("{TITLE}\n{}\n", hexadecimal(&seed));
    file.open(path).and_then(|mut file| file.write_all(text.as_bytes())).map_err(Error::io(path))?;
    Ok(KeyPair::from_seed(Seed::new(seed)))
}

/// Reads the file of a key.
fn read(path: &Path) -> Result<KeyPair, Error> {
    let text = std::fs::read_to_string(path).map_err(Error::io(path))?;
    let seed = text.strip_prefix(TITLE).and_then(|rest| bytes_of(rest.trim()));
    let seed = seed.ok_or_else(|| Error::content(path, "key", "no private key of `bearing-watch sign --new`"))?;
    KeyPair::try_from_seed(Seed::new(seed)).map_err(|_| Error::content(path, "key", "no key can be zero"))
}

/// 32 bytes of so many hexadecimal digits.
fn bytes_of(text: &str) -> Option<[u8; 32]> {
    let digits: Vec<u8> = text.chars().map(|c| c.to_digit(16).map(|digit| digit as u8)).collect::<Option<_>>()?;
    let bytes: Vec<u8> = digits.chunks_exact(2).map(|pair| 16 * pair[0] + pair[1]).collect();
    if digits.len() == 64 { bytes.try_into().ok() } else { None }
}

fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}
