//! The key that both sides share, and the keys derived from it.
//!
//! A key file holds 64 hexadecimal digits, and only its owner may read it.
//! `lariat bridge --make-key FILE` writes one. Each process derives a sending key of its own:
//! HKDF-SHA-256 over its random 64-bit number, its side and the rig. Under this key, its
//! message counts are nonces that no other process uses, and a datagram of one side is never
//! accepted as the other's.

use std::fs::{self, OpenOptions};
use std::io::{self, Write};
use std::os::unix::fs::{MetadataExt, OpenOptionsExt};
use std::path::Path;

use anyhow::{Context, Result, bail};
use lariat_chain::bounded;
use lariat_wire::Rig;
use ring::aead::{Aad, CHACHA20_POLY1305, LessSafeKey, Nonce, UnboundKey};
use ring::hkdf::{HKDF_SHA256, Salt};
use ring::rand::{SecureRandom, SystemRandom};

/// Length of a key in bytes.
const KEY: usize = 32;
/// Length in bytes of the tag after the sealed part.
#[cfg(test)]
pub(crate) const TAG: usize = 16;

/// The side that sends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Side {
    /// The camera's side.
    Near,
    /// The other side.
    Far,
}

/// The key that both sides share.
#[derive(Clone)]
pub(crate) struct Key([u8; KEY]);

impl Key {
    /// The key of a bridge without one (`--insecure`). Everybody knows it, so it detects only
    /// accidental changes.
    pub(crate) const NONE: Self = Self([0; KEY]);

    /// Reads a key.
    ///
    /// # Errors
    /// Fails if the file does not exist, others may read it, or it does not hold a key.
    pub(crate) fn read(path: &Path) -> Result<Self> {
        let shown = path.display();
        let text =
            bounded::read_text(path).with_context(|| format!("the key {shown} cannot be read"))?;
        let mode = fs::metadata(path)
            .with_context(|| format!("the key {shown} cannot be read"))?
            .mode();
        if mode & 0o077 != 0 {
            bail!(
                "others may read the key {shown}: `chmod 600 {shown}`, or make another one if they have"
            );
        }
        let Some(key) = from_hex(text.trim()) else {
            bail!(
                "{shown} is not a key of 64 hexadecimal digits: `lariat bridge --make-key FILE` makes one"
            );
        };
        Ok(Self(key))
    }

    /// Makes a key, in a file that does not exist yet.
    ///
    /// # Errors
    /// Fails if the file exists, or cannot be written.
    pub(crate) fn make(path: &Path) -> Result<()> {
        let mut key = [0; KEY];
        random(&mut key)?;
        let file = OpenOptions::new()
            .write(true)
            .create_new(true)
            .mode(0o600)
            .open(path);
        let mut file = file.with_context(|| match path.exists() {
            true => format!(
                "{} is there already: choose another name, or remove it",
                path.display()
            ),
            false => format!("the key {} cannot be written", path.display()),
        })?;
        let digits: String = key.iter().map(|byte| format!("{byte:02x}")).collect();
        let written = writeln!(file, "{digits}").and_then(|()| file.sync_all());
        written.with_context(|| format!("the key {} cannot be written", path.display()))
    }

    /// Returns the seal of one process of a side.
    pub(crate) fn of(&self, process: u64, side: Side, rig: &Rig) -> Seal {
        let side = match side {
            Side::Near => "near",
            Side::Far => "far",
        };
        let secret = Salt::new(HKDF_SHA256, &process.to_le_bytes()).extract(&self.0);
        let about = [
            b"lariat bridge 1".as_slice(),
            side.as_bytes(),
            rig.as_str().as_bytes(),
        ];
        // Expanding fails only for a length that is too large; the cipher's key is short enough.
        let key = secret
            .expand(&about, &CHACHA20_POLY1305)
            .map(UnboundKey::from);
        Seal(LessSafeKey::new(
            key.expect("a key of this cipher is short enough"),
        ))
    }
}

fn from_hex(text: &str) -> Option<[u8; KEY]> {
    let digits: Vec<u8> = text
        .chars()
        .map(|c| c.to_digit(16).map(|digit| digit as u8))
        .collect::<Option<_>>()?;
    let (pairs, []) = digits.as_chunks() else {
        return None;
    };
    let bytes: Vec<u8> = pairs.iter().map(|[high, low]| high << 4 | low).collect();
    bytes.try_into().ok()
}

/// Seals and opens the datagrams of one process.
pub(crate) struct Seal(LessSafeKey);

impl Seal {
    /// Encrypts everything after `head` and appends the tag. The tag also authenticates `head`,
    /// which stays readable. No two datagrams of the process may have the same `number`.
    pub(crate) fn close(&self, number: [u8; 12], datagram: &mut Vec<u8>, head: usize) {
        let (head, body) = datagram.split_at_mut(head);
        let tag = self.0.seal_in_place_separate_tag(
            Nonce::assume_unique_for_key(number),
            Aad::from(head),
            body,
        );
        // Sealing fails only for 256 GB and more.
        datagram.extend(tag.expect("a datagram is short enough").as_ref());
    }

    /// Decrypts everything after `head`; `None` if the datagram was not sealed with this key, or
    /// was changed in transit.
    pub(crate) fn open<'d>(
        &self,
        number: [u8; 12],
        datagram: &'d mut [u8],
        head: usize,
    ) -> Option<&'d [u8]> {
        let (head, body) = datagram.split_at_mut(head);
        let opened = self.0.open_in_place(
            Nonce::assume_unique_for_key(number),
            Aad::from(&*head),
            body,
        );
        opened.ok().map(|opened| &*opened)
    }
}

/// Returns a random number that nobody can guess.
///
/// # Errors
/// Fails if the system provides no random numbers.
pub(crate) fn random_number() -> Result<u64> {
    let mut bytes = [0; 8];
    random(&mut bytes)?;
    Ok(u64::from_le_bytes(bytes))
}

fn random(bytes: &mut [u8]) -> Result<()> {
    let filled = SystemRandom::new().fill(bytes);
    filled
        .map_err(|_| io::Error::other("the system gives no random numbers"))
        .map_err(Into::into)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::os::unix::fs::PermissionsExt;

    #[test]
    fn a_key_is_made_once_and_read_by_its_owner_alone() {
        let folder = std::env::temp_dir().join(format!("lariat-bridge-key-{}", std::process::id()));
        fs::create_dir_all(&folder).expect("it is ours");
        let path = folder.join("cell.key");
        Key::make(&path).expect("made");
        assert!(Key::make(&path).is_err_and(|error| error.to_string().contains("there already")));
        assert!(Key::read(&path).is_ok());
        fs::set_permissions(&path, fs::Permissions::from_mode(0o640)).expect("it is ours");
        assert!(Key::read(&path).is_err_and(|error| error.to_string().contains("chmod 600")));
        fs::set_permissions(&path, fs::Permissions::from_mode(0o600)).expect("it is ours");
        for text in [
            "",
            "secret",
            &"0".repeat(63),
            &"0".repeat(66),
            &"0g".repeat(32),
        ] {
            fs::write(&path, text).expect("it is ours");
            assert!(
                Key::read(&path).is_err_and(|error| error.to_string().contains("64 hex")),
                "{text}"
            );
        }
        fs::remove_dir_all(folder).expect("it is ours");
    }

    #[test]
    fn another_key_process_side_or_rig_and_every_changed_bit_is_refused() {
        let (rig, other): (Rig, Rig) = (
            "cell".parse().expect("a name"),
            "other".parse().expect("a name"),
        );
        let key = Key([7; KEY]);
        let seal = key.of(1, Side::Near, &rig);
        let mut sealed = b"head and body".to_vec();
        seal.close([1; 12], &mut sealed, 5);
        assert!(!sealed.windows(4).any(|bytes| bytes == b"body"));
        assert_eq!(
            seal.open([1; 12], &mut sealed.clone(), 5),
            Some(&b"and body"[..])
        );
        for wrong in [
            Key([8; KEY]).of(1, Side::Near, &rig),
            key.of(2, Side::Near, &rig),
            key.of(1, Side::Far, &rig),
            key.of(1, Side::Near, &other),
        ] {
            assert_eq!(wrong.open([1; 12], &mut sealed.clone(), 5), None);
        }
        assert_eq!(seal.open([2; 12], &mut sealed.clone(), 5), None);
        for bit in 0..8 * sealed.len() {
            let mut changed = sealed.clone();
            changed[bit / 8] ^= 1 << (bit % 8);
            assert_eq!(seal.open([1; 12], &mut changed, 5), None, "{bit}");
        }
        assert_eq!(seal.open([1; 12], &mut [0; 7], 5), None);
    }
}
