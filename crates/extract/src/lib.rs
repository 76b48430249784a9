//! From an image to the ordered centerlines of the ropes in it.
//!
//! A pure library: no input or output, no clock, no threads, and once warm no allocation per frame.
//! [`Extractor::extract`] takes an [`Image`] in the camera's own pixel format and returns a
//! [`Scene`]: for each rope N points at equal steps of arc length through the middle of the rope,
//! between pixels, with its width at each point; and the crossings, with which rope is on top.
//!
//! ```
//! use lariat_extract::{Extractor, Image, Options, PixelFormat};
//!
//! // A dark bar, 9 pixels wide, on a light table.
//! let (width, height) = (200, 100);
//! let mut bytes = vec![220u8; width * height];
//! for row in bytes.chunks_exact_mut(width).skip(40).take(9) {
//!     row[30..170].fill(40);
//! }
//! let image = Image::new(&bytes, width, height, width, PixelFormat::Gray8)?;
//! let mut extractor = Extractor::new(Options::default())?;
//! let scene = extractor.extract(&image);
//! let rope = &scene.curves[0];
//! assert_eq!(rope.points.len(), 120);
//! assert!((rope.width_px - 9.0).abs() < 0.2);
//! assert!((rope.points[60][1] - 44.0).abs() < 0.1);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! `examples/descriptor.rs` reads a picture and fits curves to its ropes, in 15 lines.
//!
//! # The steps
//!
//! | step | folder | from → to |
//! |---|---|---|
//! | mask | `mask`: `background`, `difference`, `threshold`, or `hsv`; then `hysteresis`, `cast`, `diagnosis` | image, or a mask made elsewhere (`level`) → one bit a pixel, and how unlike the table each pixel is |
//! | | `mask/neural`, `ribbons`: `picture`, `spans`, `chains`, `pieces`, `trace`, `groups`, `paint` | where there is no plain table: image → where the network sees ropes → how much of each pixel is a ribbon between two edges there |
//! | skeleton | `skeleton`: `wide`, `thin`, `pixels` | mask → lines one pixel wide |
//! | graph | `graph`: `edges`, `zones`, `overlaps`, `pairing`, `strands`, `walk` | lines → strands, each rope's edges in order through its crossings |
//! | points | `centerline`: `path`, `section`, `smooth`, `extender` | strands → samples along the middle of each rope |
//! | | `occlusion`: `occluder`, `pieces`, `bridge`, `way` | what hides a rope leaves the mask; lines → lines joined across it |
//! | | `tracking`: `strays`, `refit`, `part`, `tips`, `track`, `plausible` | lines → curves with numbers that last |
//! | | `crossings`: `meet`, `over` | curves → where they cross, and which is on top |
//!
//! [`Extractor`] takes the steps in this order (`extractor`), as the `options` say; `past` is what they know of the last
//! image. Out comes a `scene`, with a `notice` where it is unsure. All read pictures by `image` (formats, colors, loops
//! over all pixels) and bits by `bitmap` (strips, components, morphology); `statistics` and `vec2` are arithmetic. No two
//! folders use each other.
//!
//! With another [`Method`] than the skeleton, the centers of a `clustering` stand in its place (in order by its `nerve`),
//! and the points are theirs (`ordering`).
//!
//! Most frames of a moving rope need none of them: it is followed from the last one by reading a chord
//! at each of its points (`following/chords`), or on any other ground than a plain table its two edges (`contours`), as long as
//! nothing else happens; [`Scene::followed`] says so.
//!
//! What comes of the crossings: [`CrossingSequence`], a rope's passes over and under itself, and whether
//! it is knotted (`knot`). Color ranges for a picture's ropes are proposed by `pick`.
//!
//! # Bounds
//!
//! Any bytes are taken, without a panic, in bounded time: the mask step reads each pixel a fixed
//! number of times. A picture in which the network guesses no rope at a glance is left at that; where it does, at most 500 lines
//! of a picture made smaller are cut into at most 128 spans each. A mask that covers more than 60% of the image, that breaks into more than one
//! run for each 16 pixels, or, if it was made elsewhere or by color, has 128 holes more than pieces, is no picture of ropes and gives none; what is wider
//! than a quarter of the image's shorter side is left out before it is thinned, with all that hangs on it if its color is the ropes'; thinning makes at most 128 passes,
//! over the rows that still change; a skeleton of more than 131,072 pixels or 4096 strands is noise
//! and gives none; crossings of more than ten arms are resolved pair by pair; 64 rings are opened; all lines
//! together are laid with some 6,000 samples; at most [`Options::ropes`] curves and 32 crossings are reported.
//!
//! What strands and crossings cost is by their number, not by that of their pairs. The slowest pictures found without a rope, of an arm,
//! a disc or a block, take 5 to 27 times as long as one rope; eight real ropes, or one that crosses itself ten times, 4 to 5 times.
//! Ropes on a cluttered ground take more, as the network looks closely at them, and what it sees is traced by its edges.
//!
//! # How it works
//!
//! image → mask → skeleton → graph → points, each step timed by itself in `lariat trace`.
//!
//! | step | modules of `crates/extract/src` | method |
//! |---|---|---|
//! | mask | `mask/`: `background`, `difference`, `threshold`; or `hsv`; then `hysteresis` (`widths`, `shadow`); `diagnosis` (`pattern`, `faint`); `cast`. `bitmap/`: `pieces` (`components`), `morphology` (`octagon`, `tiles`) | `auto`: the table is a quadratic surface a channel, fitted robustly to a sparse grid; a pixel's difference is the largest over the channels, in the camera's own format (YUYV and NV12 are not converted; BGRA, gray of 16 bits and Bayer patterns are unpacked once a frame, into RGB and gray: `image/unpack`), and what is asked of every pixel is asked while its row is in reach: first, whether a block of 64 × 8 leaves the table's noise at all. Only such blocks and those within eight pixels are worked out, the others are 0 (in doubt they are filled in later); the cut is Ridler and Calvard's, above a floor from the table's noise. Specks dropped, pinholes filled by runs |
//! | the network | `mask/seeker`, `mask/neural`, over `crates/network` | where a notice says that what differs from the table may not be the ropes, where the table ends in the picture, where two curves or more may be no ropes, and with `mask = "network"`: red, green and blue of the image, of one larger than 640×640 pixels the means of blocks; what comes back is how likely each pixel is of a rope, less where it is a seam between ropes side by side, spread between the blocks' middles. It glances at half the size first: a picture in which it guesses no rope there, as of nets, keyboards and boards, is left, with the notice that it has. Where it sees less than three tenths of what it guesses it is not believed: all is as likely as not |
//! | their edges | `ribbons/` | scan lines (every fourth row, every fourth column of the smoothed picture) are cut, where a rope is likely, into spans of one color between two edges, which dynamic programming puts together from line to line; chains, the best first, take their ground; each is traced on from its ends; ends that face each other are linked; and a group is rope by what the network says, its contrast in its own spread, its color's distance from both sides and how rare that is elsewhere, its length, evenness, bend, and its width beside the surest ones'. Painted by the share of the rope's color between the ground's, and with what the network is sure of, it is a mask like one of probabilities |
//! | skeleton | `skeleton/`: `wide`, `thin`, `pixels`; `bitmap/edge_distance` | What is far too wide for a rope, as places of a grid show, is opened out of the mask; then Guo and Hall's thinning (1989), only where it still changes. All kernels on bits run over `bitmap/strips` (`neighbors`): 64 pixels wide, a word a row, rows one after the other, so that a rope fills the widest registers whichever way it runs, and only blocks of eight rows that hold something are visited |
//! | graph | `graph/`: `edges`, `zones` (`arm`), `overlaps`, `unroll`, `necks`, `pairing`, `strands`, `double_crossing`, `walk` | ends and junctions joined by edges; spurs pruned by the local width, but not the blunt tip of a strand that comes there from the other side of another. Two strands that cross at a flat angle make two junctions: the geometry of the inscribed circles says which belong to one crossing. The arms of a crossing are paired by least bending energy over all pairings, with width and colour; an arm may stay alone, as an end. Where strands lie along each other they change sides at the necks of their overlap, where the mask is one rope wide; without a neck they only touch. The two crossings at the ends of a narrow gap are judged at once, by what the strands bend over its whole length. A piece of the mask with two tips is one rope, on the way of the cheapest walk from tip to tip, where that costs less than what comes of all this; what is one rope already and not wound up is left |
//! | points | `centerline/`: `source`, `path`, `line`, `centerliner`, `section` (`edge`, `contrast`, `shading`), `extender` (`extrapolate`, `tip_contact`), `smooth`; `image/gray`, `image/ray` | the strand's pixels smoothed without shrinking (Whittaker 1923), each sample moved to the middle of its cross-section, between the places where the difference is half of what the rope shows at its rim: how a round rope darkens toward its edges is fitted to its middle, Lambert's law (half of the contrast in the middle drew ropes 0.4 px too narrow). At the image's border one edge and the width tell. Bridged through crossings by the curve of least bending; tips run on along a parabola to half difference, then measured as well; a tip against a strand ends at its cut or at the strand's near edge; N equal steps of arc length |
//! | clusterings, in the place of skeleton and points | `clustering/`: `clusterer`, `nerve`, `ordering`, over `crates/clustering` | with `method` other than `skeleton`, each piece of the mask gets its own N centers, from those of the last frame that lie on it. Their nerve (which cells touch, and which three meet: Martinetz and Schulten's induced Delaunay triangulation) is drawn and thinned, so that graph, zones and strands find the ropes through it as through the mask's skeleton; then the line of least bending is laid through the centers along each strand, each by its pixels. Only the tips are measured in the image, the widths in the mask. Nothing is followed from the last frame |
//! | time | `past`; `occlusion/`: `occluder`, `pieces`, `bridge` (`ends`, `way`); `tracking/`: `part`, `tips`, `refit`; `matching`, `track` (`complete`, `turn`) | The last frame's ropes are a map: where a crossing can be read two ways, the strands go where they went; an end that was known is no spur; ropes that touch by their ends are parted. What is far wider than the ropes, in a color of its own, is a gripper or a hand and is taken out; the pieces that it leaves are joined where the last frame had the rope run from the one to the other, the hidden points marked: first those between which the known way lies under it, each piece as a whole set where along the rope it lies. Last, of ends that are left two that alone run into the same thing, however the rope bends under it. A hidden way on which the table shows gives way to the nearest to an arc; one that is longer than its rope can have is drawn in. Where all this still contradicts the last frame, its centerlines are laid over the image, each sample looking across for the rope's middle, the moves smoothed along it, from where they were or, of ropes that have moved far, from where the pieces that are seen say; taken if the image bears it out. A rope that seems to have lost or gained a stretch at once is remembered as it was, for six frames. The curves that agree best give number and direction. A rope out of sight is `Lost` for `keep_lost_s` and comes back as itself |
//! | seams | `extractor/seams`, `mask/seams`, `occlusion/bridge/under` | Where strands meet and the lines leave out 0.3 squares of the rope's width or end within the mask, the mask is cut where the light bends upward between two strands (their sides are darker than their middles) and read once more. Pieces that pass under others are joined, the straightest and nearest first, their lines are laid again in the whole mask, and what lacks less is taken |
//! | crossings | `crossings/`: `meet`, `over`, `place` | where the finished curves meet, an odd number of meetings within one overlap being one crossing, an even one none; a few lines along each strand are predicted through the crossing from what is seen on them before and after it, and looked at for change in the middle of it; the strand that surprises less is the upper one: its surface goes on, the other's is cut by edges, shadow and shading. Dashes and twist change a strand along it, but not the shares of light across it, so those are compared too, along the lean that the texture has. How much less becomes the confidence, calibrated on drawn crossings |
//!
//! **Following** (`following/`: `chords`). Between two frames of a camera a rope moves by less than its width, and mostly nothing
//! else happens; then none of these steps is taken. Where a row or a column of pixels runs through the rope, the middle of
//! that chord lies on its centerline, at whatever angle: one chord at each of the N points, along the row or column that cuts
//! the rope more steeply, moves the point along its normal. How chords read there, how far beside the centerline and how
//! wide, is learnt in the image that the rope was last extracted from whole, and taken off afterwards, so that what is
//! followed agrees with what is extracted (in the drawn films the mean distance from the truth is the same to a hundredth of
//! a pixel). Where a strand crosses, nothing is read and the rope bends least; before a tip it runs on in an arc, and ends
//! where the difference falls to half, less what that said too much when it was learnt. Every 64th row of the rest of the
//! image is looked at, other rows in each frame. Anything unexpected leaves the image to a whole extraction: chords that are
//! missing, too wide or of another contrast, a tip that jumped or came against something, a crossing that is gone, something
//! new elsewhere, a change of size or format. So does a second without a whole look, two and four
//! where each look shows what was known (of frames whose times are not said, 30 are a second), and so do ropes that this cannot tell:
//! thinner than 1.8 px or wider than 36, those with points more than two widths apart, any that is
//! partly hidden, and a rope that, followed into the very image it was extracted from, does not stay where it is.
//! `Scene::followed` says which of the two a scene comes from. Sixteen chords are worked on side by side (`narrow`): only
//! their pixels are brought together one chord after the other, no farther than five pixels beyond where its edges are
//! expected, and by gathers into one register where the machine has AVX-512 (`profile`, beside the plain loops that define
//! it). What is not found so near is looked for as far as a rope may move, and where a part has moved farther, from the parts beside it
//! on, as they have (`chase`).
//!
//! **Following on any ground** (`following/`: `contours`). With any other mask than that of a plain table (colour ranges, the network's, one
//! made elsewhere), and for ropes that are closed or leave the image, there is no table to take a difference from. Then the rope's
//! own colour is learnt at each of its points from the image that it was extracted from, and how it varies (`looks`); what is far
//! from it is ground. Both edges are read at each point, in a row or column of sixteen pixels each, where the difference from the rope's colour passes
//! half of what it comes to beyond (`edge`). Where one edge has no contrast the other one and the width tell; what is unlike those
//! around is dropped (`motion`); points under a hand or in a crossing move as their neighbors do, for at most twelve frames in which something is hidden.
//! An edge that another strand lies against is not read, and a tip there is carried along at the rope's length, until it comes
//! off (`beside`). Strands that lay on each other where they were extracted may go on so, as long as that does not spread at once, nor their
//! middles come nearer than half a width (`station`). Ropes whose order is unsure are followed where they were followed for a second
//! before, and the whole look still shows them where they were (`known`). A sixteenth of the rows is kept, and what is in them that was not is something new, or a camera that moves: then only
//! colors that were not nearby are (`novelty`). Strands that come to cross, a rope that grows or shrinks by more than 2.5 %, parts
//! unread for too long, and all that ends the following by chords, are left to a whole extraction. Where images come faster than every 7 ms, ropes
//! that could not be followed for any of this are followed for those 7 ms, in which they are not far from where they were: one image in some is then
//! extracted whole instead of each, for which there is no time.
//!
//! **Knots** (`knot`, `knot/`). A rope's crossings with itself, in their order, are a signed Gauss code; together with the
//! signs it fixes the diagram's faces, and Euler's formula says whether it fits into a plane (if not, a crossing was missed
//! or misread, and nothing is said). The model of pulling: each end is lifted over everything and carried off (Turaev's
//! knotoids, closed over the rest). *Straight* is said when Reidemeister's moves, and ends that slip out from above, take
//! every crossing away; *knotted* when the Alexander polynomial at −1 (the determinant), 2, 3 or 5 is not ±tᵏ. The answer's
//! probability, over both ways of each crossing and with the curve's own confidence, must reach 0.9. A rope that is partly hidden, or has a
//! bump as wide as two strands, has no answer. Other ropes are left out.
//!
//! **Masks from elsewhere** (`mask/level`, `occlusion/ends`, `tracking/strays`). A soft mask is cut near the lower heap of its
//! histogram. Pieces that run on past each other side by side are cut back to where they face each
//! other. Two ends that face each other are joined over as many as 24 widths where three fifths of the way between have a trace in the
//! mask, lie on another rope, or show a band of the ropes' colour in the picture; on a bare table none of these holds. Then strays
//! (few squares of the ropes' width, each counted as the mask is sure of it) and slivers (thinner or shorter, all along beside a
//! longer line) are dropped; so they are from colour ranges' masks.
//!
//! **Picking colours** (`pick`, `pick/`). Without a point the automatic mask says what is rope, each of its pixels given to the nearest
//! curve and curves of one colour to one class. A box in hue, saturation and value is sought for each class, by coordinate ascent of the
//! intersection over union over the picture's colours, and each side put half-way between the rope and the first others. At points, regions
//! of like colour grow from them in smoothed chroma and light, over fifteen tolerances and two weights of light; each gives a box, or two where
//! it has two colours, and the mask of each is traced. The best is that of the largest area × purity⁴ × √confidence, where the purity is the share that lies along
//! curves of the clicked one's width. What lies along those in the best three is evidence for new boxes, twice, so that the answer is
//! the rope's and not the point's. It is then judged by the same tracing (`judge`).
//!
//! **Doubt** (`mask/`: `diagnosis`, `pattern`, `faint`; `notice`). The automatic mask is sure where a gap parts the table's levels from
//! the rope's, so that the cut lies above the floor that the table's noise sets. Where the cut lies on the floor, or nothing
//! was found, the cause is sought: deviations from the table's surface that covary over a few pixels are a pattern, noise is
//! not (and what covaries over an eighth of the image is light and shade); strips that stand out in the means over blocks,
//! where noise shrinks, are a rope too like the table. More than three tenths covered, or more holes than 32 crossings make, is
//! no picture of ropes. Where noise sets the floor and the rope seems too like the table, the mask is cut again from the picture smoothed by
//! 1.3 px (`smoothed`). A white rope on light gray is lighter than the table on one side and darker on the other: what lies between is filled
//! (`rims`). A sure mask of which no rope comes, or two things that may be none, is not sure: the network is asked, in vain at most once in sixteen
//! frames; where it is sure of as many ropes as are sure without it, those stay and what is hardly one and looks like none goes, in this image and the next thirty that are looked at whole; of what it finds, curves of a confidence below 0.02 are dropped (none with a `min_confidence` of 0). A sure picture costs a look at a grid of pixels and a count of the mask's holes; the rest is only
//! done in doubt.
//!
//! **False ropes** (`mask/cast`, `tracking/plausible`). A shadow has the table's colour in less light, as a gray rope has, and is a copy of its rope
//! moved by one step. So the mask is parted by colour (or by light, where dark ropes have the table's colour too), and the step is
//! sought that carries four fifths of the one part onto the other, and nine tenths of the other onto shade. If no step a width off
//! does nearly as well, which takes a rope that bends, that is shadow and leaves the mask; else its curve is `Doubtful`: a rope
//! parallel to another keeps its distance, not the step. Doubted too are a straight short thing, small things, a border-to-border
//! line and an ellipse beside a longer or known rope that they are unlike in colour or width; a straight line with another surface
//! on each side; a strip along the image's border. What was taken for a rope over ten frames outweighs a doubt. None of this
//! is asked of a mask that the user gave.
//!
//! **Confidence** (`confidence/`). Two dozen places along each finished curve are read across: edges on both sides, their contrast in
//! levels and beside how the ground varies, whether they lie where the width says, how alike colours and widths stay along it.
//! With length, bends, ends behind which the colour goes on, whether it is a piece of something longer (not if the rest is known, as what is
//! bridged is), what is hidden and doubted, a logistic function gives the probability that the
//! curve is a rope, whole and in order. Its weights, one table for masks of lariat's own and one for those from elsewhere, are fitted
//! to drawn pictures on grounds of all kinds, with masks right and wrong (`lariat-bench calibrate-confidence`); how
//! true they are on others stands beside them (`confidence/weights.rs`). Where a tangle was walked through, the curve is less sure by how near another
//! walk came, and if the crossings, one by one, say something else; a rope that goes on from image to image is as sure of its way as it ever was.
//! Where strands meet and a part of the mask hangs together with a curve that no line runs through, it is less sure by how large that is.
//!
//! What it takes is bounded whatever the bytes are: a mask of more than 60 % of the image is no picture of ropes, a
//! skeleton of more than 131 072 pixels is noise. Both give no rope. All lines together get some 6 000 samples, the longest
//! strands first. An HSV mask is looked up: the ranges are asked once for each of the 256³ colors of the camera's own color
//! space (2 MiB; when the stage starts, and again with the first frame if that is YUV; box by box, most of which lie in a range or
//! outside of it as a whole: some milliseconds), and before that table three small
//! ones that registers hold tell 64 pixels at a time which can be in a range at all (`mask/hsv/`). With an HSV mask there is no
//! difference to find edges in, so the sub-pixel place comes from the mask's own edge; with a mask from elsewhere its bytes
//! are the difference, so that probabilities are as good between pixels as an image. Memory is kept from frame to frame, and the stage has the
//! extractor work on a drawn picture full of crossings first (`extractor/rehearse`), so that the first crossing in a motion allocates
//! nothing. The thinning has a scalar twin in its tests, which is the definition: equal bit for bit on random input. Loops
//! over all pixels are compiled for the widest registers the machine turns out to have (`portable`), with no build flags, and give the same in all; the few
//! that a compiler does not make fast by itself (`image/kernels`: three interleaved bytes a pixel to one, bytes to bits) are
//! written for AVX-512 and AVX2 beside the plain loop that defines them, and held to it bit for bit by property tests.

#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod bitmap;
mod centerline;
mod clustering;
mod confidence;
mod crossings;
mod extractor;
mod following;
mod graph;
mod image;
mod knot;
mod mask;
mod notice;
mod occlusion;
mod options;
mod past;
mod pick;
mod ribbons;
mod scene;
mod skeleton;
mod statistics;
mod tracking;
mod vec2;

pub use confidence::{Evidence, Maker};
pub use extractor::{Extractor, Step};
pub use image::{Image, ImageError, PixelFormat, Region};
pub use knot::{CrossingSequence, Pass};
pub use lariat_network::{Network, NetworkError};
pub use mask::{MaskError, MaskLevels, mask_levels, mask_of};
pub use notice::Notice;
pub use options::{HsvRange, Mask, Method, Options, OptionsError, UnknownMethod};
pub use pick::{PickDoubt, PickError, PickJudgement, Picked, judge_pick, pick};
pub use scene::{Crossing, Curve, Scene, Status};

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
