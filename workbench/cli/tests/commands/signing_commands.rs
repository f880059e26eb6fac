//! Keys, signatures and their verification.

use std::path::Path;

use crate::common::{refuse, succeed};

/// A folder with a model and two keys.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    let model = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/support/standard_rig/model.bwm");
    std::fs::copy(model, folder.path().join("m.bwm")).expect("a model");
    succeed(folder.path(), "sign --key one.key --new");
    succeed(folder.path(), "sign --key two.key --new");
    folder
}

#[test]
fn a_signed_model_verifies_and_is_read_as_before() {
    let folder = folder();
    let before = std::fs::read(folder.path().join("m.bwm")).expect("a model");
    let said = succeed(folder.path(), "sign m.bwm --key one.key --counter 4");
    assert!(said.contains("counter 4"), "{said}");
    let signed = std::fs::read(folder.path().join("m.bwm")).expect("a model");
    assert_eq!((&signed[..before.len()], signed.len()), (&before[..], before.len() + 88));
    assert_eq!(bearing_watch::signature::BLOCK, 88);
    assert!(succeed(folder.path(), "sign m.bwm --key one.key --verify --least 4").contains("counter 4"));
    let keys = succeed(folder.path(), "sign --key one.key");
    let public = keys.lines().find_map(|line| line.strip_prefix("public key ")).expect("a public key");
    succeed(folder.path(), &format!("sign m.bwm --key {public} --verify"));
    assert!(keys.contains("pub const KEY: [u8; 32] = [") && keys.contains("static const uint8_t key[32] = {"));
    // Signed again, also by another key, it has one signature.
    succeed(folder.path(), "sign m.bwm --key two.key --counter 5 --out n.bwm");
    assert_eq!(std::fs::read(folder.path().join("n.bwm")).expect("a model").len(), signed.len());
    succeed(folder.path(), "sign n.bwm --key two.key --verify");
}

#[test]
fn other_keys_old_counters_and_changes_are_refused() {
    let folder = folder();
    let file = folder.path().join("m.bwm");
    refuse(folder.path(), "sign m.bwm --key one.key --verify", &["m.bwm", "there is no signature"]);
    succeed(folder.path(), "sign m.bwm --key one.key --counter 4");
    refuse(folder.path(), "sign m.bwm --key two.key --verify", &["the key of the signature is not accepted"]);
    refuse(folder.path(), "sign m.bwm --key one.key --verify --least 5", &["older than accepted", "4", "5"]);
    let good = std::fs::read(&file).expect("a model");
    let mut changed = good.clone();
    changed[200] ^= 1;
    std::fs::write(&file, &changed).expect("written");
    refuse(folder.path(), "sign m.bwm --key one.key --verify", &["not that of these bytes"]);
    refuse(folder.path(), "sign m.bwm --key one.key", &["m.bwm", "checksum"]);
    std::fs::write(&file, [&good[..], b"x"].concat()).expect("written");
    refuse(folder.path(), "sign m.bwm --key one.key --verify", &["more bytes follow"]);
}

#[test]
fn a_key_is_for_its_owner_and_never_replaced() {
    let folder = folder();
    let key = folder.path().join("one.key");
    let before = std::fs::read(&key).expect("a key");
    refuse(folder.path(), "sign --key one.key --new", &["one.key"]);
    refuse(folder.path(), "sign --key m.bwm", &["m.bwm"]);
    refuse(folder.path(), "sign m.bwm --key m.bwm", &["m.bwm"]);
    refuse(folder.path(), "sign m.bwm --key one.key --out one.key", &["one.key"]);
    assert_eq!(std::fs::read(&key).expect("a key"), before);
    assert_ne!(std::fs::read(folder.path().join("two.key")).expect("a key"), before);
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt as _;
        let mode = std::fs::metadata(&key).expect("a key").permissions().mode();
        assert_eq!(mode & 0o777, 0o600);
    }
}
