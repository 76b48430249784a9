//! Splits a picture, or a datagram that is larger than UDP can carry, into small datagrams. Each of
//! them delays later datagrams by at most 0.1 ms on a link of 100 Mbit/s. The code is pure.
//!
//! Each part is `picture (u32), index (u16), number of parts (u16)`, then bytes. If a part is lost
//! or arrives out of order, its picture is lost, and the next picture wins.

/// Bytes of a picture in one datagram.
const CHUNK: usize = 1100;
/// Maximum number of datagrams of a picture, 4.5 MB.
const MOST: usize = 4096;

/// Returns the datagrams of a picture; none if it is too large.
pub(crate) fn chunks(picture: u32, bytes: &[u8]) -> impl Iterator<Item = ([u8; 8], &[u8])> {
    let count = bytes.len().div_ceil(CHUNK);
    let fits = count <= MOST;
    let chunks = bytes
        .chunks(CHUNK)
        .enumerate()
        .take(if fits { count } else { 0 });
    chunks.map(move |(at, chunk)| {
        let mut head = [0; 8];
        head[..4].copy_from_slice(&picture.to_le_bytes());
        head[4..6].copy_from_slice(&(at as u16).to_le_bytes());
        head[6..].copy_from_slice(&(count as u16).to_le_bytes());
        (head, chunk)
    })
}

/// A picture that is being assembled from its datagrams.
#[derive(Debug, Default)]
pub(crate) struct Assembly {
    picture: u32,
    come: u16,
    bytes: Vec<u8>,
}

impl Assembly {
    /// Takes a datagram. Returns the picture if it is complete.
    pub(crate) fn take(&mut self, says: &[u8]) -> Option<&[u8]> {
        let (head, chunk) = says.split_first_chunk::<8>()?;
        let picture = u32::from_le_bytes([head[0], head[1], head[2], head[3]]);
        let at = u16::from_le_bytes([head[4], head[5]]);
        let count = u16::from_le_bytes([head[6], head[7]]);
        if at == 0 {
            (self.picture, self.come) = (picture, 0);
            self.bytes.clear();
        }
        let is_within = at < count && usize::from(count) <= MOST;
        if picture != self.picture || at != self.come || !is_within {
            // The rest of the picture is useless, and must not match.
            self.come = u16::MAX;
            return None;
        }
        self.bytes.extend_from_slice(chunk);
        self.come += 1;
        (self.come == count).then_some(&self.bytes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn datagrams(picture: u32, bytes: &[u8]) -> Vec<Vec<u8>> {
        chunks(picture, bytes)
            .map(|(head, chunk)| [&head, chunk].concat())
            .collect()
    }

    #[test]
    fn a_picture_comes_whole_or_not_at_all_and_the_next_one_comes() {
        let bytes: Vec<u8> = (0..5000_u32).map(|i| i as u8).collect();
        let mut assembly = Assembly::default();
        let all = datagrams(7, &bytes);
        assert_eq!(all.len(), 5);
        for lost in 0..all.len() {
            for (_, says) in all.iter().enumerate().filter(|(at, _)| *at != lost) {
                assert_eq!(assembly.take(says), None, "{lost}");
            }
            let (last, first) = all.split_last().expect("five");
            assert!(first.iter().all(|says| assembly.take(says).is_none()));
            assert_eq!(assembly.take(last), Some(&bytes[..]));
            // The picture does not come twice.
            assert_eq!(assembly.take(last), None);
        }
    }

    #[test]
    fn what_is_too_large_or_no_part_of_a_picture_is_nothing() {
        assert!(datagrams(1, &vec![0; CHUNK * MOST]).len() == MOST);
        assert!(datagrams(1, &vec![0; CHUNK * MOST + 1]).is_empty());
        let mut assembly = Assembly::default();
        for length in 0..20 {
            assert_eq!(assembly.take(&vec![255; length]), None);
        }
        // A picture with zero parts is never complete.
        assert_eq!(assembly.take(&[0; 8]), None);
        // A part beyond the last one is refused, even if its index is the largest possible one.
        assert_eq!(assembly.take(&[0, 0, 0, 0, 0, 0, 1, 0]), Some(&[][..]));
        assert_eq!(assembly.take(&[0, 0, 0, 0, 1, 0, 1, 0]), None);
        assert_eq!(assembly.take(&[0, 0, 0, 0, 255, 255, 1, 0]), None);
    }
}
