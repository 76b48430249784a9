//! The user's choices: sizes, rates, and flags of `lariat run`.

use clap::Args;

use super::BenchArgs;
use super::plan::{FPS, SIZE};
use lariat_chain::settings::Flags;

/// Frames per second. `None`: as fast as possible.
pub(super) type Rate = Option<f64>;

/// Parses a size.
pub(super) fn size(text: &str) -> Result<[u32; 2], String> {
    let sides = text.split_once('x');
    let side = |text: &str| text.parse().ok().filter(|side| (32..=16384).contains(side));
    sides
        .and_then(|(width, height)| Some([side(width)?, side(height)?]))
        .ok_or_else(|| "a size is a width and a height in pixels, such as 640x480".to_owned())
}

/// Parses a rate.
pub(super) fn rate(text: &str) -> Result<Rate, String> {
    match text {
        "max" => Ok(None),
        _ => match text.parse() {
            Ok(fps) if fps > 0.0 && fps <= 100_000.0 => Ok(Some(fps)),
            _ => Err("a rate is frames per second, such as 120, or `max`".to_owned()),
        },
    }
}

/// Returns the sizes and rates of the chain.
pub(super) fn setups(args: &BenchArgs) -> Vec<([u32; 2], Rate)> {
    const SIZES: [[u32; 2]; 3] = [SIZE, [1280, 720], [1920, 1080]];
    const RATES: [Rate; 6] = [
        Some(FPS),
        Some(30.0),
        Some(60.0),
        Some(500.0),
        Some(1000.0),
        None,
    ];
    let all = |sizes: &[[u32; 2]], rates: &[Rate]| {
        let of = |&size: &[u32; 2]| {
            rates
                .iter()
                .map(move |&rate| (size, rate))
                .collect::<Vec<_>>()
        };
        sizes.iter().flat_map(of).collect::<Vec<_>>()
    };
    let (sizes, rates) = (&args.size[..], &args.fps[..]);
    match (sizes.is_empty(), rates.is_empty()) {
        (true, true) if args.full => all(&SIZES, &RATES),
        (true, true) if args.quick => all(&[SIZE], &[Some(FPS), Some(1000.0)]),
        (true, true) => {
            let mut usual = all(&[SIZE], &[Some(FPS), Some(30.0), Some(1000.0), None]);
            usual.extend(SIZES[1..].iter().map(|&size| (size, Some(30.0))));
            usual
        }
        (true, false) => all(&[SIZE], rates),
        (false, true) => all(sizes, &[Some(FPS)]),
        (false, false) => all(sizes, rates),
    }
}

/// Returns whether `lariat run` has this flag.
pub(super) fn knows(flag: &str) -> bool {
    let command = Flags::augment_args(clap::Command::new("run"));
    command
        .get_arguments()
        .any(|known| known.get_long() == Some(flag))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_and_rates_are_read() {
        assert_eq!(size("640x480"), Ok([640, 480]));
        assert!(size("640").is_err() && size("0x480").is_err());
        assert_eq!(rate("max"), Ok(None));
        assert_eq!(rate("59.94"), Ok(Some(59.94)));
        assert!(rate("-1").is_err() && rate("fast").is_err());
    }

    #[test]
    fn the_flags_of_run_are_known() {
        assert!(knows("lossless"));
        assert!(!knows("no-such-flag"));
    }
}
