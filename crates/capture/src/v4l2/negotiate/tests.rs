//! Tests the rule on the lists of real cameras.

use super::*;
use crate::v4l2::offers::{Rates, SizeOffer, SizeRange};
use proptest::prelude::*;

fn code(name: &str) -> FourCc {
    name.parse().expect("a code in a test")
}

/// A format with these sizes and the rates at each.
fn format(name: &str, sizes: &[([u32; 2], &[f64])]) -> FormatOffer {
    let size = |(size, rates): &([u32; 2], &[f64])| SizeOffer {
        range: SizeRange::One(*size),
        rates: Rates::Listed(rates.iter().copied().map(Interval::of_fps).collect()),
    };
    FormatOffer {
        code: code(name),
        description: String::new(),
        compressed: matches!(name, "MJPG" | "H264"),
        sizes: sizes.iter().map(size).collect(),
    }
}

const TO_30: &[f64] = &[30.0, 24.0, 20.0, 15.0, 10.0, 7.5, 5.0];

fn logitech_c920() -> Vec<FormatOffer> {
    let small = [
        [640, 480],
        [160, 90],
        [160, 120],
        [176, 144],
        [320, 180],
        [320, 240],
        [352, 288],
        [432, 240],
        [640, 360],
        [800, 448],
    ];
    let slow: [([u32; 2], &[f64]); 5] = [
        ([800, 600], &TO_30[1..]),
        ([864, 480], &TO_30[1..]),
        ([1280, 720], &TO_30[4..]),
        ([1920, 1080], &TO_30[6..]),
        ([2304, 1536], &[2.0]),
    ];
    let large = [[800, 600], [864, 480], [1280, 720], [1920, 1080]];
    let at_30 = |sizes: &[[u32; 2]]| sizes.iter().map(|&size| (size, TO_30)).collect::<Vec<_>>();
    vec![
        format("YUYV", &[&at_30(&small)[..], &slow].concat()),
        format("H264", &at_30(&[&small[..], &large].concat())),
        format("MJPG", &at_30(&[&small[..], &large].concat())),
    ]
}

fn logitech_c270() -> Vec<FormatOffer> {
    vec![
        format(
            "YUYV",
            &[
                ([640, 480], &[30.0, 25.0, 20.0, 15.0, 10.0, 5.0]),
                ([320, 240], TO_30),
                ([1280, 720], &[10.0, 5.0]),
                ([1280, 960], &[7.5, 5.0]),
            ],
        ),
        format(
            "MJPG",
            &[
                ([640, 480], TO_30),
                ([320, 240], TO_30),
                ([1280, 720], TO_30),
                ([1280, 960], TO_30),
            ],
        ),
    ]
}

fn playstation_eye() -> Vec<FormatOffer> {
    vec![format(
        "YUYV",
        &[
            (
                [320, 240],
                &[187.0, 150.0, 125.0, 100.0, 75.0, 60.0, 50.0, 30.0],
            ),
            ([640, 480], &[60.0, 50.0, 40.0, 30.0, 15.0]),
        ],
    )]
}

fn mono_ov9281() -> Vec<FormatOffer> {
    vec![
        format(
            "GREY",
            &[
                ([1280, 800], &[120.0, 60.0]),
                ([1280, 720], &[133.0, 60.0]),
                ([640, 400], &[240.0, 120.0, 60.0]),
            ],
        ),
        format("Y10", &[([1280, 800], &[60.0])]),
    ]
}

fn usb_hdmi_grabber() -> Vec<FormatOffer> {
    vec![
        format(
            "MJPG",
            &[
                ([1920, 1080], &[60.0, 30.0, 25.0]),
                ([1280, 720], &[60.0, 50.0, 30.0]),
                ([640, 480], &[60.0, 50.0, 30.0]),
            ],
        ),
        format(
            "YUYV",
            &[
                ([1920, 1080], &[5.0]),
                ([1280, 720], &[10.0]),
                ([640, 480], &[30.0, 20.0]),
            ],
        ),
    ]
}

/// Stepwise sizes and one rate, as the kernel's virtual HDMI input has them.
fn stepwise_hdmi() -> Vec<FormatOffer> {
    let rate = Interval {
        numerator: 12375,
        denominator: 742_500,
    };
    let offer = |name| FormatOffer {
        sizes: vec![SizeOffer {
            range: SizeRange::Steps {
                least: [16, 16],
                most: [4096, 2160],
                step: [2, 2],
            },
            rates: Rates::Listed(vec![rate]),
        }],
        ..format(name, &[])
    };
    ["RGB3", "UYVY", "GREY"].map(offer).to_vec()
}

const ANYTHING: Request = Request {
    size: None,
    fps: None,
    format: None,
    wanted: Wanted::Pictures,
};

/// The chosen format, size and rate as text.
fn chosen(offers: &[FormatOffer], request: Request) -> String {
    match negotiate(offers, &request) {
        Ok(Choice {
            code,
            size: [width, height],
            interval,
        }) => {
            let fps = interval.map_or("?".to_owned(), |interval| interval.fps().to_string());
            format!("{code} {width}x{height} {fps}")
        }
        Err(why) => why.to_string(),
    }
}

#[test]
fn without_a_wish_a_camera_is_read_at_about_640x480_as_fast_as_it_can() {
    for (offers, best) in [
        (logitech_c920(), "YUYV 640x480 30"),
        (logitech_c270(), "YUYV 640x480 30"),
        (playstation_eye(), "YUYV 640x480 60"),
        (mono_ov9281(), "GREY 640x400 240"),
        (usb_hdmi_grabber(), "MJPG 640x480 60"),
        (stepwise_hdmi(), "UYVY 640x480 60"),
    ] {
        assert_eq!(chosen(&offers, ANYTHING), best);
    }
}

#[test]
fn the_size_asked_for_is_kept_and_compressed_where_the_cable_is_too_slow() {
    let at = |size, fps| Request {
        size: Some(size),
        fps,
        ..ANYTHING
    };
    let c920 = logitech_c920();
    assert_eq!(chosen(&c920, at([1280, 720], None)), "MJPG 1280x720 30");
    assert_eq!(
        chosen(&c920, at([1280, 720], Some(10.0))),
        "YUYV 1280x720 10"
    );
    assert_eq!(chosen(&c920, at([2304, 1536], None)), "YUYV 2304x1536 2");
    assert_eq!(
        chosen(&playstation_eye(), at([320, 240], None)),
        "YUYV 320x240 187"
    );
    assert_eq!(
        chosen(&stepwise_hdmi(), at([1280, 720], None)),
        "UYVY 1280x720 60"
    );
}

#[test]
fn the_rate_asked_for_is_met_or_the_nearest_taken() {
    let at = |fps| Request {
        fps: Some(fps),
        ..ANYTHING
    };
    assert_eq!(chosen(&logitech_c920(), at(15.0)), "YUYV 640x480 15");
    assert_eq!(chosen(&logitech_c920(), at(29.97)), "YUYV 640x480 30");
    assert_eq!(chosen(&logitech_c920(), at(120.0)), "YUYV 640x480 30");
    assert_eq!(chosen(&usb_hdmi_grabber(), at(60.0)), "MJPG 640x480 60");
    assert_eq!(chosen(&usb_hdmi_grabber(), at(30.0)), "YUYV 640x480 30");
}

#[test]
fn the_format_asked_for_is_taken() {
    let in_format = |name| Request {
        format: Some(code(name)),
        ..ANYTHING
    };
    assert_eq!(
        chosen(&logitech_c920(), in_format("mjpg")),
        "MJPG 640x480 30"
    );
    assert_eq!(
        chosen(&stepwise_hdmi(), in_format("grey")),
        "GREY 640x480 60"
    );
    assert_eq!(
        chosen(&usb_hdmi_grabber(), in_format("yuyv")),
        "YUYV 640x480 30"
    );
}

#[test]
fn what_there_is_not_is_answered_with_what_there_is() {
    let request = |size, format: Option<&str>| Request {
        size,
        format: format.map(code),
        ..ANYTHING
    };
    let c270 = logitech_c270();
    assert_eq!(
        chosen(&c270, request(None, Some("nv12"))),
        "it has no pixel format NV12; it has YUYV and MJPG"
    );
    assert_eq!(
        chosen(&logitech_c920(), request(None, Some("h264"))),
        "lariat does not read the pixel format H264; of this camera's formats it reads YUYV and MJPG"
    );
    assert_eq!(
        chosen(&c270, request(Some([1024, 768]), None)),
        "it has no size 1024x768; the nearest are 1280x720, 1280x960, 640x480, 320x240"
    );
    assert_eq!(
        chosen(&stepwise_hdmi(), request(Some([641, 480]), Some("uyvy"))),
        "it has no size 641x480 in UYVY; the nearest are 640x480"
    );
    assert_eq!(
        chosen(&mono_ov9281()[1..], ANYTHING),
        "it offers Y10, and lariat reads none of these but YUYV, UYVY, NV12, BGR3, RGB3, AR24, XR24, BGR4, RGGB, BA81, GRBG, \
         GBRG, MJPG, JPEG, GREY and Y16"
    );
    assert!(chosen(&[], ANYTHING).starts_with("it offers no format at all"));
}

/// The list of a D435's first node from `v4l2-ctl --list-formats-ext`.
fn realsense_depth() -> Vec<FormatOffer> {
    const TO_90: &[f64] = &[90.0, 60.0, 30.0, 15.0, 6.0];
    let sizes: [([u32; 2], &[f64]); 6] = [
        ([256, 144], &[90.0]),
        ([424, 240], TO_90),
        ([480, 270], TO_90),
        ([640, 480], TO_90),
        ([848, 480], TO_90),
        ([1280, 720], &TO_90[2..]),
    ];
    vec![format("Z16", &sizes)]
}

#[test]
fn of_a_depth_camera_depth_is_taken_and_of_none_it_is_not() {
    let depth = Request {
        size: Some([848, 480]),
        fps: Some(30.0),
        wanted: Wanted::Depth,
        ..ANYTHING
    };
    assert_eq!(chosen(&realsense_depth(), depth), "Z16 848x480 30");
    let size = |size| Request {
        size: Some(size),
        ..depth
    };
    assert_eq!(
        chosen(&realsense_depth(), size([1280, 960])),
        "it has no size 1280x960; the nearest are 1280x720, 848x480, 640x480, 480x270"
    );
    let both = [&mono_ov9281()[..], &realsense_depth()].concat();
    let any = Request {
        size: None,
        ..depth
    };
    assert_eq!(chosen(&both, any), "Z16 640x480 30");
    assert_eq!(
        chosen(&logitech_c270(), any),
        "it offers YUYV and MJPG, and depth is read of Z16 and Y16"
    );
    assert_eq!(
        chosen(&realsense_depth(), ANYTHING),
        "it offers Z16, which is depth: name it as the --depth-source, and the colour camera as the source"
    );
}

#[test]
fn a_driver_that_lists_no_sizes_is_asked_for_what_the_user_wants() {
    let offers = [format("YUYV", &[])];
    assert_eq!(chosen(&offers, ANYTHING), "YUYV 640x480 ?");
    let request = Request {
        size: Some([720, 576]),
        ..ANYTHING
    };
    assert_eq!(chosen(&offers, request), "YUYV 720x576 ?");
}

fn any_offers() -> impl Strategy<Value = Vec<FormatOffer>> {
    let name =
        proptest::sample::select(vec!["YUYV", "MJPG", "GREY", "NV12", "H264", "RGB3", "Y10"]);
    let side = || proptest::sample::select(vec![16_u32, 120, 320, 480, 640, 720, 1280, 1920, 9000]);
    let rates = proptest::collection::vec(1.0..240.0_f64, 0..4);
    let size = ([side(), side()], rates, any::<bool>()).prop_map(|(size, rates, steps)| {
        let range = match steps {
            false => SizeRange::One(size),
            true => SizeRange::Steps {
                least: [16, 16],
                most: size,
                step: [8, 2],
            },
        };
        let rates = match rates.is_empty() {
            true => Rates::Untold,
            false => Rates::Listed(rates.into_iter().map(Interval::of_fps).collect()),
        };
        SizeOffer { range, rates }
    });
    let offer =
        (name, proptest::collection::vec(size, 0..5)).prop_map(|(name, sizes)| FormatOffer {
            sizes,
            ..format(name, &[])
        });
    proptest::collection::vec(offer, 0..5)
}

proptest! {
    #[test]
    fn what_is_chosen_was_offered_and_is_what_was_asked_for(
        offers in any_offers(),
        size in proptest::option::of(proptest::sample::select(vec![[640, 480], [320, 240], [1280, 720]])),
        fps in proptest::option::of(1.0..240.0_f64),
        name in proptest::option::of(proptest::sample::select(vec!["YUYV", "MJPG", "GREY"])),
    ) {
        let request = Request { size, fps, format: name.map(code), ..ANYTHING };
        let Ok(choice) = negotiate(&offers, &request) else { return Ok(()) };
        prop_assert!(size.is_none_or(|size| size == choice.size));
        prop_assert!(request.format.is_none_or(|format| format == choice.code));
        prop_assert!(READABLE.contains(&choice.code.0));
        let is_offered = |offer: &FormatOffer| {
            offer.code == choice.code
                && (offer.sizes.is_empty()
                    || offer.sizes.iter().any(|size| {
                        size.range.nearest(choice.size) == choice.size
                            && match &size.rates {
                                Rates::Listed(all) => choice.interval.is_some_and(|one| all.contains(&one)),
                                _ => choice.interval.is_none(),
                            }
                    }))
        };
        prop_assert!(offers.iter().any(is_offered), "{choice:?}");
    }

    #[test]
    fn nothing_faster_was_passed_over_at_the_size_that_was_asked_for(offers in any_offers()) {
        let size = [640, 480];
        let request = Request { size: Some(size), ..ANYTHING };
        let Ok(choice) = negotiate(&offers, &request) else { return Ok(()) };
        let fastest = offers
            .iter()
            .filter(|offer| READABLE.contains(&offer.code.0))
            .flat_map(|offer| &offer.sizes)
            .filter(|offer| offer.range.nearest(size) == size)
            .filter_map(|offer| offer.rates.nearest(None))
            .map(Interval::fps)
            .fold(0.0, f64::max);
        let fps = choice.interval.map_or(0.0, Interval::fps);
        prop_assert!(fps >= fastest * 0.98 - 1e-9, "{fps} of {fastest}");
    }
}
