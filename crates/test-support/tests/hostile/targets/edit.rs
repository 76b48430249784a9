//! Changes fields of a message by name. A valid message becomes one that no writer of lariat would
//! send.

use super::input::Input;
use lariat_wire::fields::{Message, Place};

/// Changes fields until the input ends.
pub(crate) fn edit_all(message: &mut dyn Message, input: &mut Input) {
    while !input.is_empty() {
        edit(message, input);
    }
}

/// Changes one field.
pub(crate) fn edit(message: &mut dyn Message, input: &mut Input) {
    let mut fields = 0;
    message.visit_mut(&mut |_, _| fields += 1);
    let wanted = usize::from(input.byte()) % fields;
    let mut index = 0;
    message.visit_mut(&mut |_, place| {
        if index == wanted {
            change(place, input);
        }
        index += 1;
    });
}

fn change(place: Place, input: &mut Input) {
    match place {
        Place::U32(number) => *number = number32(input),
        Place::U64(number) => *number = number64(input),
        Place::F32(number) => *number = real(input) as f32,
        Place::F64(number) => *number = real(input),
        Place::Point(point) => *point = [real(input) as f32, real(input) as f32],
        Place::F32s(numbers, _) => {
            let number = real(input) as f32;
            list(numbers, number, input);
        }
        Place::F64s(numbers, _) => {
            let number = real(input);
            list(numbers, number, input);
        }
        Place::Hidden(words) => {
            let index = input.index(words.len());
            words[index] = number32(input);
        }
        Place::Message(message) => edit(message, input),
        Place::Messages(room) => {
            let index = input.index(room.size());
            edit(room.at_mut(index), input);
        }
    }
}

/// Changes one number of a list, or occasionally all of them.
fn list<T: Copy>(numbers: &mut [T], number: T, input: &mut Input) {
    match input.byte() {
        0..32 => numbers.fill(number),
        _ => {
            let index = input.index(numbers.len());
            numbers[index] = number;
        }
    }
}

/// Counts, codes and sizes at their limits.
fn number32(input: &mut Input) -> u32 {
    const KNOWN: [u32; 24] = [
        0,
        1,
        2,
        3,
        4,
        5,
        7,
        8,
        23,
        24,
        25,
        31,
        32,
        33,
        120,
        255,
        256,
        257,
        65_536,
        1 << 28,
        i32::MAX as u32,
        1 << 31,
        u32::MAX - 1,
        u32::MAX,
    ];
    let choice = usize::from(input.byte());
    KNOWN
        .get(choice)
        .copied()
        .unwrap_or_else(|| u32::from_le_bytes(input.bytes()))
}

fn number64(input: &mut Input) -> u64 {
    match input.byte() {
        0..8 => u64::MAX,
        8..16 => 1 << 63,
        16..24 => lariat_wire::now_ns(),
        24..128 => number32(input).into(),
        _ => u64::from_le_bytes(input.bytes()),
    }
}

fn real(input: &mut Input) -> f64 {
    const KNOWN: [f64; 24] = [
        0.0,
        -0.0,
        0.5,
        1.0,
        -1.0,
        1.0 + f64::EPSILON,
        100.0,
        -100.0,
        1e-9,
        1e9,
        -1e9,
        1e18,
        1e38,
        1e150,
        -1e200,
        1e-200,
        1e300,
        f64::MAX,
        f64::MIN,
        f64::MIN_POSITIVE,
        5e-324,
        f64::NAN,
        f64::INFINITY,
        f64::NEG_INFINITY,
    ];
    let choice = usize::from(input.byte());
    match (KNOWN.get(choice), choice) {
        (Some(&number), _) => number,
        (None, ..128) => f64::from(input.byte()),
        (None, _) => f64::from_le_bytes(input.bytes()),
    }
}
