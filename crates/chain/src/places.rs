//! Where in the picture points are that were sent in millimetres, or in pixels without distortion: back through plane and lens.

use crate::calibrated::Calibrated;
use crate::settings::{settings_of, version_of};
use anyhow::Result;
use lariat_camera::Mapping;
use lariat_wire::{Descriptors, Member, Unit};

/// The way that was asked for last, by what it comes from, and by the pictures' size.
#[derive(Debug)]
pub struct Places<K>(Option<(K, [u32; 2], Option<Mapping>)>);

impl<K> Default for Places<K> {
    fn default() -> Self {
        Self(None)
    }
}

impl<K: PartialEq> Places<K> {
    /// From the picture to where descriptors have their points; `None` if that is the picture, or not known. `load`: reads lens and
    /// plane that `key` stands for.
    pub fn of(
        &mut self,
        shapes: &Descriptors,
        key: K,
        load: impl FnOnce(&K) -> Result<Option<Calibrated>>,
    ) -> Option<Mapping> {
        if shapes.unit() == Some(Unit::Pixel) {
            return None;
        }
        let size = [shapes.width, shapes.height];
        if let Some((known, of, mapping)) = &self.0
            && (known, *of) == (&key, size)
        {
            return *mapping;
        }
        let calibrated = load(&key).ok().flatten();
        let calibrated = calibrated.filter(|known| Some(known.unit()) == shapes.unit());
        let mapping = calibrated.and_then(|calibrated| calibrated.mapping(size).ok());
        self.0 = Some((key, size, mapping));
        mapping
    }
}

impl Places<Member> {
    /// By what a rig's fit says of itself, if that is what it went by when it made these.
    pub fn of_rig(&mut self, shapes: &Descriptors, fit: Option<&Member>) -> Option<Mapping> {
        let fit = fit.filter(|fit| version_of(&fit.settings) == shapes.trace.settings)?;
        self.of(shapes, fit.clone(), |fit| {
            Calibrated::load(&settings_of(fit)?.camera)
        })
    }
}

/// Where a point of descriptors is seen; `None` if it is not, or not known. `places`: the way there from the picture, if that is
/// not where the points are.
pub fn pixel(shapes: &Descriptors, places: Option<&Mapping>, point: [f64; 2]) -> Option<[f64; 2]> {
    let is_number = point.iter().all(|x| x.is_finite());
    match places {
        Some(places) => places.pixel(point).filter(|_| is_number),
        None => (is_number && shapes.unit() == Some(Unit::Pixel)).then_some(point),
    }
}
