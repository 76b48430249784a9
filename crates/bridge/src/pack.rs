//! The wire format of messages: the used part of each list, as in a recording, in as few bytes as
//! possible.
//!
//! Fields come in the order of memory, as the messages declare them:
//!
//! | field | encoding |
//! |---|---|
//! | `u32` | a varint (7 bits per byte, the lowest first) |
//! | `u64` | the difference from the message's previous `u64`, zigzag, as a varint: timestamps and counts are close to each other |
//! | `f32`, `f64`, a point | unchanged, little endian |
//! | a list of `f64` | the number of rows, then each column: 1 and one number if all are equal (weights, velocities of curves that are not filtered), otherwise 0 and all of them |
//! | a list of `f32` | the same, but a finite column of unequal numbers is 2, its minimum and maximum, and 16 bits for each number between them |
//! | hidden points | the number of points, then 0 if none is hidden, otherwise 1 and one bit each |
//! | messages | the number of messages, then each |
//!
//! **Everything except the points and widths of the centerline is restored bit for bit.** These are
//! restored to within 1/131070 of the rope's extent. For a rope that is 1000 px across, this is
//! 0.008 px, while the error of extraction is 0.03 px. A cubic with nine control points and 120
//! points takes 1.1 kB, which fits into one Ethernet frame. The struct in shared memory, with room
//! for 24 ropes, is 120 times as large.

use lariat_wire::MAX_POINTS;
use lariat_wire::fields::{self, Message, Place, Value};

/// Maximum number of lists in one message.
const MOST_LISTS: usize = 8;

/// Why bytes are not a message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum PackError {
    /// The bytes end too early.
    Short,
    /// A list exceeds its capacity.
    TooMany,
    /// A value is impossible.
    Nonsense,
    /// Bytes are left over.
    Long,
}

/// Appends a message to a buffer.
pub(crate) fn pack(message: &dyn Message, into: &mut Vec<u8>) {
    put(message, &mut 0, into);
}

/// Reads a message. The unused parts of its lists keep their values. After an error, the content of
/// the message is unspecified.
pub(crate) fn unpack(message: &mut dyn Message, bytes: &[u8]) -> Result<(), PackError> {
    let mut from = Bytes { bytes, last: 0 };
    from.message(message)?;
    from.bytes.is_empty().then_some(()).ok_or(PackError::Long)
}

fn put(message: &dyn Message, last: &mut u64, into: &mut Vec<u8>) {
    message.visit(&mut |_, value| match value {
        Value::U32(word) => varint(u64::from(word), into),
        Value::U64(count) => {
            let step = count.wrapping_sub(*last) as i64;
            varint((step << 1 ^ step >> 63) as u64, into);
            *last = count;
        }
        Value::F32(number) => into.extend_from_slice(&number.to_le_bytes()),
        Value::F64(number) => into.extend_from_slice(&number.to_le_bytes()),
        Value::Point([x, y]) => {
            into.extend_from_slice(&x.to_le_bytes());
            into.extend_from_slice(&y.to_le_bytes());
        }
        Value::F32s(numbers, columns) => {
            varint((numbers.len() / columns) as u64, into);
            for column in 0..columns {
                put_f32s(numbers, column, columns, into);
            }
        }
        Value::F64s(numbers, columns) => {
            varint((numbers.len() / columns) as u64, into);
            for column in 0..columns {
                let entries = || numbers.iter().skip(column).step_by(columns);
                let is_one = is_one(entries().map(|number| number.to_bits()));
                into.push(u8::from(is_one));
                let meant = if is_one { 1 } else { usize::MAX };
                entries()
                    .take(meant)
                    .for_each(|number| into.extend_from_slice(&number.to_le_bytes()));
            }
        }
        Value::Hidden(hidden, count) => {
            varint(count as u64, into);
            let is_hidden = |i: usize| i < count && fields::is_hidden(hidden, i);
            let any = (0..count).any(is_hidden);
            into.push(u8::from(any));
            if any {
                let byte = |at: usize| {
                    (0..8).fold(0, |byte, bit| {
                        byte | u8::from(is_hidden(8 * at + bit)) << bit
                    })
                };
                into.extend((0..count.div_ceil(8)).map(byte));
            }
        }
        Value::Message(inner) => put(inner, last, into),
        Value::Messages(messages) => {
            varint(messages.count() as u64, into);
            messages.iter().for_each(|message| put(message, last, into));
        }
    });
}

/// Writes a column unchanged, as one number, or in steps of its extent.
fn put_f32s(numbers: &[f32], column: usize, columns: usize, into: &mut Vec<u8>) {
    let entries = || numbers.iter().skip(column).step_by(columns).copied();
    let first = entries().next().map(f32::to_bits);
    let (mut is_one, mut is_finite) = (first.is_some(), true);
    let [mut least, mut largest] = [f32::INFINITY, f32::NEG_INFINITY];
    for number in entries() {
        is_one &= Some(number.to_bits()) == first;
        is_finite &= number.is_finite();
        (least, largest) = (least.min(number), largest.max(number));
    }
    let step = step(least, largest);
    if is_one {
        into.push(1);
        into.extend_from_slice(&first.unwrap_or_default().to_le_bytes());
    } else if step.is_normal() && is_finite {
        into.push(2);
        into.extend_from_slice(&least.to_le_bytes());
        into.extend_from_slice(&largest.to_le_bytes());
        into.reserve(2 * numbers.len() / columns);
        for number in entries() {
            // Rounds to the nearest step. The difference is never negative.
            let steps = ((f64::from(number) - f64::from(least)) / step + 0.5) as u16;
            into.extend_from_slice(&steps.to_le_bytes());
        }
    } else {
        into.push(0);
        entries().for_each(|number| into.extend_from_slice(&number.to_le_bytes()));
    }
}

/// Returns the distance between adjacent numbers of 16 bits.
fn step(least: f32, largest: f32) -> f64 {
    (f64::from(largest) - f64::from(least)) / f64::from(u16::MAX)
}

/// Returns whether there is at least one number, and all are equal.
fn is_one(mut bits: impl Iterator<Item = u64>) -> bool {
    let Some(first) = bits.next() else {
        return false;
    };
    bits.all(|other| other == first)
}

fn varint(mut number: u64, into: &mut Vec<u8>) {
    while number >= 0x80 {
        into.push(number as u8 | 0x80);
        number >>= 7;
    }
    into.push(number as u8);
}

/// The bytes that are left to read.
struct Bytes<'a> {
    bytes: &'a [u8],
    last: u64,
}

impl Bytes<'_> {
    fn message(&mut self, message: &mut dyn Message) -> Result<(), PackError> {
        let (mut lengths, mut lists, mut result) = ([0; MOST_LISTS], 0, Ok(()));
        message.visit_mut(&mut |_, place| {
            if result.is_ok() {
                let is_list = !matches!(
                    place,
                    Place::U32(_)
                        | Place::U64(_)
                        | Place::F32(_)
                        | Place::F64(_)
                        | Place::Point(_)
                        | Place::Message(_)
                );
                let read = self.place(place);
                if let (true, Ok(length)) = (is_list, read) {
                    lengths[lists] = length;
                    lists += 1;
                }
                result = read.map(drop);
            }
        });
        result?;
        // Each list must have as many rows as its count says. Otherwise stale rows would become
        // part of it.
        let (mut meant, mut is_even) = (lengths[..lists].iter(), true);
        message.visit(&mut |_, value| {
            let count = match value {
                Value::F32s(numbers, columns) => numbers.len() / columns,
                Value::F64s(numbers, columns) => numbers.len() / columns,
                Value::Messages(messages) => messages.count(),
                Value::Hidden(_, count) => count,
                _ => return,
            };
            is_even &= meant.next() == Some(&count);
        });
        is_even.then_some(()).ok_or(PackError::Nonsense)
    }

    /// Reads a field. Returns the number of rows if it is a list, otherwise 0.
    fn place(&mut self, place: Place) -> Result<usize, PackError> {
        match place {
            Place::U32(word) => {
                *word = u32::try_from(self.varint()?).map_err(|_| PackError::Nonsense)?
            }
            Place::U64(count) => {
                let zigzag = self.varint()?;
                let step = (zigzag >> 1) ^ (zigzag & 1).wrapping_neg();
                self.last = self.last.wrapping_add(step);
                *count = self.last;
            }
            Place::F32(number) => *number = f32::from_le_bytes(self.take()?),
            Place::F64(number) => *number = f64::from_le_bytes(self.take()?),
            Place::Point(at) => {
                for number in at {
                    *number = f32::from_le_bytes(self.take()?);
                }
            }
            Place::F32s(room, columns) => {
                let rows = self.count(room.len() / columns)?;
                for column in 0..columns {
                    self.f32s(
                        room[..rows * columns]
                            .iter_mut()
                            .skip(column)
                            .step_by(columns),
                    )?;
                }
                return Ok(rows);
            }
            Place::F64s(room, columns) => {
                let rows = self.count(room.len() / columns)?;
                for column in 0..columns {
                    let entries = room[..rows * columns]
                        .iter_mut()
                        .skip(column)
                        .step_by(columns);
                    let one = match self.take()? {
                        [0] => None,
                        [1] => Some(f64::from_le_bytes(self.take()?)),
                        _ => return Err(PackError::Nonsense),
                    };
                    for number in entries {
                        *number = one.map_or_else(|| self.take().map(f64::from_le_bytes), Ok)?;
                    }
                }
                return Ok(rows);
            }
            Place::Hidden(hidden) => {
                let count = self.count(MAX_POINTS)?;
                let mut bits = [0_u8; MAX_POINTS / 8];
                if self.take()? != [0] {
                    for byte in &mut bits[..count.div_ceil(8)] {
                        [*byte] = self.take()?;
                    }
                }
                *hidden = fields::hidden((0..count).map(|i| bits[i / 8] >> (i % 8) & 1 == 1));
                return Ok(count);
            }
            Place::Message(inner) => self.message(inner)?,
            Place::Messages(room) => {
                let count = self.count(room.size())?;
                for i in 0..count {
                    self.message(room.at_mut(i))?;
                }
                return Ok(count);
            }
        }
        Ok(0)
    }

    fn f32s<'a>(
        &mut self,
        mut entries: impl Iterator<Item = &'a mut f32>,
    ) -> Result<(), PackError> {
        let [kind] = self.take()?;
        match kind {
            0 => entries.try_for_each(|number| {
                *number = f32::from_le_bytes(self.take()?);
                Ok(())
            }),
            1 => {
                let one = f32::from_le_bytes(self.take()?);
                entries.for_each(|number| *number = one);
                Ok(())
            }
            2 => {
                let [least, largest] = [
                    f32::from_le_bytes(self.take()?),
                    f32::from_le_bytes(self.take()?),
                ];
                let step = step(least, largest);
                entries.try_for_each(|number| {
                    let steps = u16::from_le_bytes(self.take()?);
                    *number = (f64::from(least) + f64::from(steps) * step) as f32;
                    Ok(())
                })
            }
            _ => Err(PackError::Nonsense),
        }
    }

    fn take<const N: usize>(&mut self) -> Result<[u8; N], PackError> {
        let (taken, rest) = self.bytes.split_first_chunk().ok_or(PackError::Short)?;
        self.bytes = rest;
        Ok(*taken)
    }

    fn varint(&mut self) -> Result<u64, PackError> {
        let mut number = 0;
        for shift in (0..64).step_by(7) {
            let [byte] = self.take()?;
            let bits = u64::from(byte & 0x7f);
            if bits << shift >> shift != bits {
                return Err(PackError::Nonsense);
            }
            number |= bits << shift;
            if byte < 0x80 {
                return Ok(number);
            }
        }
        Err(PackError::Nonsense)
    }

    fn count(&mut self, most: usize) -> Result<usize, PackError> {
        let count = self.varint()?;
        match usize::try_from(count) {
            Ok(count) if count <= most => Ok(count),
            _ => Err(PackError::TooMany),
        }
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use lariat_wire::{Axes, Basis, Centerlines, Command, Descriptors, Descriptors3, Status};

    /// An endless sequence of different numbers.
    pub(crate) struct Numbers(pub(crate) u64);

    impl Numbers {
        pub(crate) fn next(&mut self) -> u64 {
            self.0 = self
                .0
                .wrapping_mul(6364136223846793005)
                .wrapping_add(1442695040888963407);
            self.0 >> 24
        }

        fn coordinate(&mut self) -> f64 {
            self.next() as f64 / (1_u64 << 40) as f64 * 1000.0
        }
    }

    /// Returns what a chain sends: ropes with nine control points and 120 points each.
    pub(crate) fn descriptors(ropes: u32, seed: u64) -> Box<Descriptors> {
        let of = &mut Numbers(seed);
        let mut message = Box::new(Descriptors::EMPTY);
        let count = 100_000 + of.next() % 100;
        message.trace.sequence = count;
        (
            message.trace.captured,
            message.trace.extracted,
            message.trace.fitted,
        ) = (count - 3, count - 3, count - 5);
        message.trace.exposed_ns = 1_000_000_000_000 + of.next();
        message.trace.captured_ns = message.trace.exposed_ns + 200_000;
        message.trace.extract_started_ns = message.trace.exposed_ns + 280_000;
        message.trace.extracted_ns = message.trace.exposed_ns + 400_000;
        message.trace.fit_started_ns = message.trace.exposed_ns + 480_000;
        message.trace.fitted_ns = message.trace.exposed_ns + 530_000;
        (message.width, message.height, message.count) = (1280, 1024, ropes);
        for (curve, points) in message
            .curves
            .iter_mut()
            .zip(&mut message.centerlines)
            .take(ropes as usize)
        {
            (curve.track, curve.basis, curve.degree, curve.count) =
                (of.next() as u32 % 9, Basis::BSpline as u32, 3, 9);
            (curve.samples, curve.status, curve.fit) = (120, Status::Partial as u32, 1);
            (curve.rms, curve.max, curve.length, curve.width) = (0.27, 0.74, of.coordinate(), 12.3);
            (curve.confidence, curve.condition, curve.residual_variance) = (0.95, 5.06, 0.04);
            for i in 0..9 {
                curve.control_points[i] = [of.coordinate(), of.coordinate()];
                curve.covariances[i] = [of.coordinate(), 0.0, of.coordinate()];
            }
            for (i, knot) in curve.knots[..5].iter_mut().enumerate() {
                *knot = (i + 1) as f64 / 6.0;
            }
            points.count = 120;
            points.set_hidden((0..120).map(|i| (40..47).contains(&i)));
            for i in 0..120 {
                points.points[i] = [of.coordinate() as f32, of.coordinate() as f32];
                points.widths[i] = 12.0 + of.coordinate() as f32 / 1000.0;
            }
        }
        message
    }

    #[test]
    fn a_rope_goes_into_one_datagram_of_an_ethernet() {
        let mut bytes = Vec::new();
        pack(&*descriptors(1, 1), &mut bytes);
        // 1500 bytes without the heads of IPv6, UDP and the bridge.
        assert!(
            bytes.len() <= 1500 - 48 - crate::datagram::OVERHEAD,
            "{}",
            bytes.len()
        );
    }

    #[test]
    fn all_but_the_centerline_s_points_come_back_to_the_bit_and_those_to_a_fraction_of_their_extent()
     {
        for (ropes, seed) in [(0, 1), (1, 2), (1, 3), (3, 4), (24, 5)] {
            let sent = descriptors(ropes, seed);
            let (mut bytes, mut read) = (Vec::new(), Box::new(Descriptors::EMPTY));
            pack(&*sent, &mut bytes);
            unpack(&mut *read, &bytes).expect("a message");
            for (read, sent) in read.centerlines.iter_mut().zip(&sent.centerlines) {
                for (read, sent) in read.points.iter_mut().zip(&sent.points) {
                    assert!(
                        read.iter()
                            .zip(sent)
                            .all(|(a, b)| (a - b).abs() <= 1000.0 / 131_070.0 + 1e-4)
                    );
                    *read = *sent;
                }
                for (read, sent) in read.widths.iter_mut().zip(&sent.widths) {
                    assert!((*read - *sent).abs() <= 1.0 / 131_070.0 + 1e-6);
                    *read = *sent;
                }
            }
            assert_eq!(read, sent);
        }
    }

    #[test]
    fn points_that_have_no_extent_come_as_they_are() {
        let mut sent = descriptors(3, 9);
        sent.centerlines[0].points[3][0] = f32::NAN;
        sent.centerlines[1].points[3][1] = f32::INFINITY;
        sent.centerlines[2].points[..120].fill([7.0, 8.0]);
        let (mut bytes, mut read) = (Vec::new(), Box::new(Descriptors::EMPTY));
        pack(&*sent, &mut bytes);
        unpack(&mut *read, &bytes).expect("a message");
        let bits = |message: &Descriptors, i: usize, c: usize| {
            message.centerlines[i].points.map(|p| p[c].to_bits())
        };
        assert_eq!(bits(&read, 0, 0), bits(&sent, 0, 0));
        assert_eq!(bits(&read, 1, 1), bits(&sent, 1, 1));
        assert_eq!(read.centerlines[2].points, sent.centerlines[2].points);
    }

    #[test]
    fn other_messages_come_back_likewise() {
        let sent = Command {
            count: 7,
            sent_ns: u64::MAX,
            exposed_ns: 0,
            grippers: 2,
            velocities: [
                [1.0, -2.0, 0.5, 0.0, 0.1, 0.2],
                [f64::MIN, 0.0, f64::MAX, 0.0, 0.0, -0.5],
            ],
            ..Command::default()
        };
        let (mut bytes, mut read) = (Vec::new(), Command::default());
        pack(&sent, &mut bytes);
        assert_eq!(unpack(&mut read, &bytes), Ok(()));
        assert_eq!(read, sent);
        let mut sent = Box::new(Centerlines::EMPTY);
        (sent.count, sent.crossing_count) = (1, 2);
        sent.curves[0].count = 3;
        sent.curves[0].points[..3].copy_from_slice(&[[0.0, 10.0], [1.0, 20.0], [2.0, 30.0]]);
        sent.crossings[1].at = [4.0, 5.0];
        let (mut bytes, mut read) = (Vec::new(), Box::new(Centerlines::EMPTY));
        pack(&*sent, &mut bytes);
        assert_eq!(unpack(&mut *read, &bytes), Ok(()));
        assert_eq!((read.count, read.crossings), (1, sent.crossings));
        assert_eq!(read.curves[0].points()[2], [2.0, 30.0]);
        let mut sent = Box::new(Descriptors3::EMPTY);
        (sent.count, sent.axes) = (1, Axes::Robot as u32);
        let curve = &mut sent.curves[0];
        (curve.count, curve.samples) = (2, 3);
        curve.control_points[..2].copy_from_slice(&[[1.0, -2.0, 500.0], [3.0, 4.0, 510.0]]);
        curve.covariances[1] = [1.0, 0.1, 0.2, 2.0, 0.3, 9.0];
        curve.points[..3].copy_from_slice(&[
            [0.0, 1.0, 500.0],
            [1.0, 1.0, 501.0],
            [2.0, 1.0, 510.0],
        ]);
        curve.sigmas[..3].copy_from_slice(&[0.9, 0.9, 0.9]);
        let (mut bytes, mut read) = (Vec::new(), Box::new(Descriptors3::EMPTY));
        pack(&*sent, &mut bytes);
        assert_eq!(unpack(&mut *read, &bytes), Ok(()));
        let (came, sent) = (&read.curves()[0], &sent.curves()[0]);
        assert_eq!((read.count, read.axes()), (1, Some(Axes::Robot)));
        assert_eq!(came.control_points(), sent.control_points());
        assert_eq!(came.covariances(), sent.covariances());
        assert_eq!(
            (came.points()[2], came.sigmas()),
            (sent.points()[2], sent.sigmas())
        );
    }

    #[test]
    fn what_is_cut_off_or_goes_on_is_an_error() {
        let mut bytes = Vec::new();
        pack(&*descriptors(2, 5), &mut bytes);
        let mut read = Box::new(Descriptors::EMPTY);
        for length in 0..bytes.len() {
            assert!(unpack(&mut *read, &bytes[..length]).is_err(), "{length}");
        }
        bytes.push(0);
        assert_eq!(unpack(&mut *read, &bytes), Err(PackError::Long));
    }

    #[test]
    fn a_count_that_says_more_than_came_is_an_error() {
        let sent = descriptors(1, 5);
        let mut bytes = Vec::new();
        pack(&*sent, &mut bytes);
        // The number of ropes comes after the trace and the size.
        let mut before = Vec::new();
        pack(&sent.trace, &mut before);
        let at = before.len() + 4;
        assert_eq!(bytes[at], 1);
        bytes[at] = 2;
        let mut read = descriptors(2, 6);
        assert_eq!(unpack(&mut *read, &bytes), Err(PackError::Nonsense));
    }

    #[test]
    fn any_bytes_are_a_message_or_an_error() {
        let of = &mut Numbers(3);
        let mut good = Vec::new();
        pack(&*descriptors(2, 5), &mut good);
        let mut read = Box::new(Descriptors::EMPTY);
        for _ in 0..3_000 {
            let mut bytes = good.clone();
            for _ in 0..1 + of.next() % 4 {
                let at = of.next() as usize % bytes.len();
                bytes[at] = of.next() as u8;
            }
            if unpack(&mut *read, &bytes).is_ok() {
                // Its counts do not exceed the lists, or are clamped to them.
                assert!(read.curves().len() <= read.curves.len());
            }
            let random: Vec<u8> = (0..of.next() % 300).map(|_| of.next() as u8).collect();
            let _ = unpack(&mut *read, &random);
        }
    }
}
