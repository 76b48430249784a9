//! Every message is read back bit for bit, and hostile bytes are errors.

use lariat_message::fields::Type;
use lariat_message::{
    CenterlinePoints, Crossing, Curve, Descriptor, Descriptor3, MAX_CURVES, Trace, Unit,
};
use proptest::prelude::*;

use super::*;
use crate::{CdrError, encode_control_points};

/// An endless sequence of distinct numbers.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> u64 {
        self.0 = self
            .0
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        self.0 >> 11
    }

    fn u32(&mut self) -> u32 {
        self.next() as u32
    }

    fn f32(&mut self) -> f32 {
        self.next() as f32 / 7.0
    }

    fn f64(&mut self) -> f64 {
        self.next() as f64 / 7.0
    }
}

fn trace(of: &mut Numbers) -> Trace {
    Trace {
        sequence: of.next(),
        captured: of.next(),
        extracted: of.next(),
        fitted: of.next(),
        bridged: of.next(),
        exposed_ns: of.next(),
        captured_ns: of.next(),
        extract_started_ns: of.next(),
        extracted_ns: of.next(),
        fit_started_ns: of.next(),
        fitted_ns: of.next(),
        settings: of.next() as u32,
        restarts: of.next() as u32,
    }
}

fn centerlines(curves: u32, points: u32, crossings: u32, seed: u64) -> Box<Centerlines> {
    let of = &mut Numbers(seed);
    let mut message = Box::new(Centerlines::EMPTY);
    message.trace = trace(of);
    (message.width, message.height) = (of.u32(), of.u32());
    (message.count, message.crossing_count) = (curves, crossings);
    for curve in &mut message.curves[..curves as usize] {
        (curve.track, curve.status, curve.closed, curve.border) =
            (of.u32(), of.u32() % 4, of.u32() % 2, of.u32() % 4);
        (curve.count, curve.width_px, curve.length_px) = (points, of.f32(), of.f32());
        curve.age_ns = of.next();
        let hidden: Vec<bool> = (0..points).map(|_| of.next() % 2 == 1).collect();
        curve.set_hidden(hidden);
        for i in 0..points as usize {
            curve.points[i] = [of.f32(), of.f32()];
            curve.widths_px[i] = of.f32();
        }
    }
    for crossing in &mut message.crossings[..crossings as usize] {
        *crossing = Crossing {
            at: [of.f32(), of.f32()],
            over: of.u32(),
            under: of.u32(),
            over_rho: of.f32(),
            under_rho: of.f32(),
            confidence: of.f32(),
            reserved: 0,
        };
    }
    message
}

fn descriptors(curves: u32, count: u32, seed: u64) -> Box<Descriptors> {
    let of = &mut Numbers(seed);
    let mut message = Box::new(Descriptors::EMPTY);
    message.trace = trace(of);
    (message.width, message.height) = (of.u32(), of.u32());
    (message.count, message.unit) = (curves, Unit::Pixel as u32);
    for (k, curve) in message.curves[..curves as usize].iter_mut().enumerate() {
        curve.track = of.u32();
        curve.basis = 1 + k as u32 % 6;
        curve.degree = if k % 2 == 0 { 3 } else { 2 };
        (curve.status, curve.count, curve.samples) = (of.u32() % 4, count, of.u32());
        (curve.closed, curve.border) = (of.u32() % 2, of.u32() % 4);
        (curve.rms, curve.max, curve.residual_variance) = (of.f64(), of.f64(), of.f64());
        (curve.condition, curve.length, curve.width) = (of.f64(), of.f64(), of.f64());
        (curve.age_ns, curve.hidden, curve.filtered) = (of.next(), of.u32(), of.u32() % 2);
        curve.fit = of.u32() % 3;
        for i in 0..count as usize {
            curve.control_points[i] = [of.f64(), of.f64()];
            curve.weights[i] = of.f64();
            curve.covariances[i] = [of.f64(), of.f64(), of.f64()];
            curve.velocities[i] = [of.f64(), of.f64()];
        }
        for i in 0..curve.inner_knots().len() {
            curve.knots[i] = of.f64();
        }
    }
    for centerline in &mut message.centerlines[..curves as usize] {
        (centerline.count, centerline.closed) = (8 * count, of.u32() % 2);
        for i in 0..8 * count as usize {
            centerline.points[i] = [of.f32(), of.f32()];
            centerline.widths[i] = of.f32();
        }
        centerline.set_hidden((0..8 * count).map(|_| of.next() % 2 == 1));
    }
    message
}

proptest! {
    #[test]
    fn what_was_seen_comes_back_to_the_bit(
        curves in 0_u32..=8, points in 0_u32..=256, crossings in 0_u32..=32, seed: u64,
    ) {
        let sent = centerlines(curves, points, crossings, seed);
        let mut cdr = Vec::new();
        sent.encode(&mut cdr);
        let mut read = Box::new(Centerlines::EMPTY);
        read.decode(&cdr).unwrap();
        prop_assert_eq!(read, sent);
    }

    #[test]
    fn descriptors_come_back_to_the_bit(curves in 0_u32..=8, count in 0_u32..=32, seed: u64) {
        let sent = descriptors(curves, count, seed);
        let mut cdr = Vec::new();
        sent.encode(&mut cdr);
        let mut read = Box::new(Descriptors::EMPTY);
        read.decode(&cdr).unwrap();
        prop_assert_eq!(read, sent);
    }

    #[test]
    fn any_bytes_are_a_message_or_an_error(mut bytes: Vec<u8>) {
        bytes.splice(..0, [0, 1, 0, 0]);
        let (mut seen, mut shapes) = (Centerlines::EMPTY, Descriptors::EMPTY);
        let _ = shapes.decode(&bytes);
        let _ = seen.decode(&bytes);
        let _ = FrameHeader::default().decode(&bytes);
        let _ = crate::ImageRecord::decode(&bytes);
        let _ = crate::CompressedImageRecord::decode(&bytes);
    }

    #[test]
    fn a_message_cut_off_anywhere_is_an_error(at in 0.0..1.0, seed: u64) {
        let mut cdr = Vec::new();
        descriptors(3, 9, seed).encode(&mut cdr);
        let at = (at * cdr.len() as f64) as usize;
        let mut read = Descriptors::EMPTY;
        let decoded = read.decode(&cdr[..at]);
        prop_assert!(decoded.is_err());
    }
}

#[test]
fn what_is_not_meant_is_not_written() {
    let mut sent = descriptors(1, 4, 5);
    let (mut before, mut after) = (Vec::new(), Vec::new());
    sent.encode(&mut before);
    sent.curves[3].rms = 7.0;
    sent.curves[0].control_points[4] = [7.0; 2];
    sent.centerlines[0].points[32] = [7.0; 2];
    sent.centerlines[0].hidden[1..].fill(u32::MAX);
    sent.centerlines[1].count = 5;
    sent.encode(&mut after);
    assert_eq!(before, after);
}

#[test]
fn counts_beyond_the_arrays_are_read_as_full() {
    // A writer of another release may write any count.
    let mut sent = descriptors(1, 4, 5);
    (sent.count, sent.curves[0].count) = (99, 1000);
    let mut cdr = Vec::new();
    sent.encode(&mut cdr);
    let mut read = Box::new(Descriptors::EMPTY);
    read.decode(&cdr).unwrap();
    assert_eq!(read.curves().len(), MAX_CURVES);
}

#[test]
fn lists_that_belong_together_have_one_length() {
    let mut cdr = Vec::new();
    centerlines(1, 1, 0, 3).encode(&mut cdr);
    // Head, trace, size, count, and the curve's words, sizes and age. The number of points follows.
    let at = 4 + 96 + 8 + 4 + 16 + 8 + 4 + 8;
    assert_eq!(cdr[at..at + 4], [1, 0, 0, 0]);
    cdr[at] = 0;
    let mut read = Centerlines::EMPTY;
    let decoded = read.decode(&cdr);
    assert!(matches!(
        decoded,
        Err(CdrError::Uneven | CdrError::TooMany { .. } | CdrError::Short)
    ));
}

#[test]
fn every_schema_names_the_definitions_it_needs() {
    let schemas = [
        FrameHeader::SCHEMA,
        Centerlines::SCHEMA,
        Descriptors::SCHEMA,
        Descriptors3::SCHEMA,
        crate::Losses::SCHEMA,
        crate::IMAGE,
        crate::COMPRESSED_IMAGE,
        crate::ANNOTATIONS,
    ];
    for schema in schemas {
        for line in schema.text.lines() {
            let kind = line.split([' ', '[']).next().unwrap_or("");
            if kind.contains('/') {
                let defined = format!("\nMSG: {kind}\n");
                assert!(schema.text.contains(&defined), "{}: {kind}", schema.name);
            }
        }
    }
}

/// Name of a field's type in a schema.
fn type_name(field: &Field) -> String {
    let (element, shape) = field.of.element();
    let name = match (element, &shape[..]) {
        (Type::F64, [.., 3]) if field.name != "covariances" => "lariat_msgs/Point3F64".to_owned(),
        (Type::F32, [.., 3]) => "lariat_msgs/Point3F32".to_owned(),
        (Type::F64, [.., 6]) => "lariat_msgs/Covariance3".to_owned(),
        (Type::F32, [.., 2]) => "lariat_msgs/PointF32".to_owned(),
        (Type::F64, [.., 2]) => "lariat_msgs/PointF64".to_owned(),
        (Type::F64, [.., 3]) => "lariat_msgs/Covariance".to_owned(),
        (Type::Message(layout), _) => format!("lariat_msgs/{}", layout.name),
        (Type::U32, _) => "uint32".to_owned(),
        (Type::U64, _) => "uint64".to_owned(),
        (Type::F32, _) => "float32".to_owned(),
        (Type::F64, _) => "float64".to_owned(),
        (Type::Array(..), _) => unreachable!("an element is no array"),
    };
    match (element, &shape[..]) {
        (Type::F32, [_]) if name.ends_with("PointF32") => name,
        (_, [most, ..]) => format!("{name}[<={most}]"),
        _ => name,
    }
}

/// Expected schema of a message: its codes, then its fields in the order in which they are written.
fn definition(message: &dyn Message) -> Vec<String> {
    let mut said = Vec::new();
    for (field, _) in message.fields() {
        if let Meaning::Code(codes) = field.meaning {
            said.extend(codes.all.iter().map(|code| {
                let mut name = String::new();
                for (i, letter) in code.variant.char_indices() {
                    name.extend((i > 0 && letter.is_uppercase()).then_some('_'));
                    name.extend(letter.to_uppercase());
                }
                format!("uint32 {name}={}", code.number)
            }));
        }
    }
    said.sort();
    let mut bytes = Vec::new();
    for part in 0..PARTS {
        for (field, value) in message.fields() {
            let mut to = Encoder::new(&mut bytes);
            put_field(part, field, value, &mut to);
            if bytes.len() > 4 {
                let of = match field.meaning {
                    Meaning::Hidden => format!("bool[<={MAX_POINTS}]"),
                    _ => type_name(field),
                };
                said.push(format!("{of} {}", field.name));
            }
        }
    }
    said
}

#[test]
fn every_schema_says_the_fields_that_are_written() {
    macro_rules! check {
        ($($message:ident),+) => {$({
            let text = include_str!(concat!("../../schemas/", stringify!($message), ".msg"));
            let said = text.lines().map(|line| line.split('#').next().unwrap_or_default());
            let said = said.map(|line| line.split_whitespace().collect::<Vec<_>>().join(" "));
            let mut said: Vec<_> = said.filter(|line| !line.is_empty()).collect();
            // The order of codes does not matter.
            let codes = said.iter().filter(|line| line.contains('=') && !line.contains("<=")).count();
            said[..codes].sort();
            let expected = definition(&$message::EMPTY);
            assert_eq!(said, expected, "{}", stringify!($message));
        })+};
    }
    check!(
        Trace,
        FrameHeader,
        Curve,
        Crossing,
        Centerlines,
        Descriptor,
        CenterlinePoints,
        Descriptors,
        Descriptor3,
        Descriptors3
    );
}

#[test]
fn annotations_hold_the_control_points_from_the_pixel_s_corner() {
    let mut sent = descriptors(3, 4, 1);
    // Points are shifted by a pixel to the right; one of the second rope is not visible.
    sent.curves[1].control_points[2] = [f64::NAN; 2];
    let pixel = |[x, y]: [f64; 2]| x.is_finite().then_some([x + 1.0, y]);
    let mut cdr = Vec::new();
    encode_control_points(&sent, pixel, 3_000_000_007, &mut cdr);
    let mut from = Decoder::new(&cdr).unwrap();
    assert_eq!(from.value::<u32>(), Ok(0), "circles");
    assert_eq!(
        from.value::<u32>(),
        Ok(4),
        "a line and its points for each rope that is seen whole"
    );
    for shape in [0, 0, 2, 2].map(|i| &sent.curves[i]) {
        assert_eq!(from.value::<i32>(), Ok(3));
        assert_eq!(from.value::<u32>(), Ok(7));
        assert!(matches!(from.value::<u8>(), Ok(1 | 3)));
        let mut points = [[0.0; 2]; 8];
        assert_eq!(from.rows(&mut points, 1), Ok(4));
        let expected = shape
            .control_points()
            .iter()
            .map(|[x, y]| [x + 1.5, y + 0.5]);
        assert!(expected.eq(points[..4].iter().copied()));
        from.value::<[f64; 4]>().unwrap();
        assert_eq!(from.value::<u32>(), Ok(0), "colors of segments");
        from.value::<[f64; 5]>().unwrap();
    }
    assert_eq!(from.value::<u32>(), Ok(0), "texts");
    assert_eq!(from.value::<u8>(), Err(CdrError::Short), "the end");
}
