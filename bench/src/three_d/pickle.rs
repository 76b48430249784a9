//! Safe reading of pickles of number lists. A pickle is a program that may import and call
//! anything. Only the opcodes that make lists and numbers are supported, and nothing is executed.

use anyhow::{Context, Result, bail};

/// Maximum nesting depth of lists.
const DEEPEST: usize = 3;

/// Content of a pickle.
#[derive(Debug, PartialEq)]
pub(super) enum Value {
    Number(f64),
    List(Vec<Value>),
}

impl Value {
    /// Returns the items of a list.
    ///
    /// # Errors
    /// The value is a number.
    pub(super) fn list(&self) -> Result<&[Self]> {
        match self {
            Self::List(list) => Ok(list),
            Self::Number(number) => bail!("a list is expected instead of the number {number}"),
        }
    }

    /// Returns a number.
    ///
    /// # Errors
    /// The value is a list, or not finite.
    pub(super) fn number(&self) -> Result<f64> {
        match self {
            Self::Number(number) if number.is_finite() => Ok(*number),
            Self::Number(number) => bail!("{number} is not a finite number"),
            Self::List(_) => bail!("a number is expected instead of a list"),
        }
    }
}

/// Reads a pickle.
///
/// # Errors
/// It contains anything but numbers and up to three nested lists, or ends too early.
pub(super) fn read(bytes: &[u8]) -> Result<Value> {
    let mut rest = bytes;
    let (mut stack, mut marks) = (Vec::new(), Vec::new());
    loop {
        let at = bytes.len() - rest.len();
        let [opcode] = take(&mut rest)?;
        match opcode {
            // Protocol version and frame length.
            0x80 => drop(take::<1>(&mut rest)?),
            0x95 => drop(take::<8>(&mut rest)?),
            // Stores the last value in the memo, which is never read here.
            0x94 => {}
            b']' => stack.push(Value::List(Vec::new())),
            b'G' => stack.push(Value::Number(f64::from_be_bytes(take(&mut rest)?))),
            b'(' if marks.len() < DEEPEST => marks.push(stack.len()),
            b'(' => bail!("at byte {at} lists are deeper within each other than {DEEPEST}"),
            b'e' => {
                let mark = marks
                    .pop()
                    .with_context(|| format!("no mark before byte {at}"))?;
                let items = stack.split_off(mark);
                match stack.last_mut() {
                    Some(Value::List(list)) => list.extend(items),
                    _ => bail!("at byte {at} there is no list to append to"),
                }
            }
            b'.' => {
                return match (stack.pop(), stack.is_empty()) {
                    (Some(value), true) => Ok(value),
                    _ => bail!("it ends at byte {at} with more or less than one value"),
                };
            }
            other => bail!(
                "opcode {other:#04x} at byte {at} makes neither a list nor a number: such a pickle is not read, as it could run anything"
            ),
        }
    }
}

fn take<const N: usize>(rest: &mut &[u8]) -> Result<[u8; N]> {
    let (first, after) = (rest.split_first_chunk()).context("it ends in the middle")?;
    *rest = after;
    Ok(*first)
}

#[cfg(test)]
mod tests {
    use super::{Value, read};

    /// `pickle.dumps([[1.0, 2.5], [-3.0, 4.0]], protocol=4)`.
    const TWO_LISTS: &[u8] =
        b"\x80\x04\x95\x30\0\0\0\0\0\0\0]\x94(]\x94(G\x3f\xf0\0\0\0\0\0\0G\x40\x04\0\0\0\0\0\0e\
        ]\x94(G\xc0\x08\0\0\0\0\0\0G\x40\x10\0\0\0\0\0\0ee.";

    #[test]
    fn lists_of_numbers_are_read() {
        let row = |numbers: [f64; 2]| Value::List(numbers.map(Value::Number).into());
        let wanted = Value::List(vec![row([1.0, 2.5]), row([-3.0, 4.0])]);
        assert_eq!(read(TWO_LISTS).expect("two lists"), wanted);
    }

    #[test]
    fn whatever_could_run_something_is_refused() {
        // `os.system` on the stack, by name and in the form of protocol 4, and a call.
        for (pickle, opcode) in [
            (&b"cos\nsystem\n."[..], "0x63"),
            (b"\x80\x04\x8c\x02os\x94\x8c\x06system\x94\x93.", "0x8c"),
            (b"\x80\x04](]]eR.", "0x52"),
        ] {
            let error = read(pickle).expect_err("it is no list").to_string();
            assert!(error.contains(opcode), "{error}");
        }
    }

    #[test]
    fn what_is_cut_off_or_out_of_order_is_refused() {
        for length in 0..TWO_LISTS.len() {
            assert!(read(&TWO_LISTS[..length]).is_err(), "{length} bytes");
        }
        for wrong in [&b"."[..], b"]].", b"e.", b"(e.", b"G\0\0\0\0\0\0\0\0(]e."] {
            assert!(read(wrong).is_err(), "{wrong:?}");
        }
        let deep = b"](".repeat(100_000);
        assert!(read(&deep).is_err());
    }
}
