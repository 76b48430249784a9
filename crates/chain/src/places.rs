//! Maps points in millimeters or undistorted pixels back to the picture, through plane and lens.

use crate::calibrated::Calibrated;
use crate::settings::{settings_of, version_of};
use anyhow::Result;
use lariat_camera::Mapping;
use lariat_wire::{Descriptors, Member, Unit};

/// The last mapping with its key and its picture size.
#[derive(Debug)]
pub struct Places<K>(Option<(K, [u32; 2], Option<Mapping>)>);

impl<K> Default for Places<K> {
    fn default() -> Self {
        Self(None)
    }
}

impl<K: PartialEq> Places<K> {
    /// Returns the mapping from the picture to the unit of the descriptors. Returns `None` if that
    /// unit is image pixels, or if the mapping is unknown. `load` reads the lens and the plane that
    /// belong to `key`.
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
    /// Returns the mapping that the settings announced by a rig's fit stage describe, if they are
    /// the settings that produced these shapes.
    pub fn of_rig(&mut self, shapes: &Descriptors, fit: Option<&Member>) -> Option<Mapping> {
        let fit = fit.filter(|fit| version_of(&fit.settings) == shapes.trace.settings)?;
        self.of(shapes, fit.clone(), |fit| {
            Calibrated::load(&settings_of(fit)?.camera)
        })
    }
}

/// Returns the pixel of a descriptor's point. Returns `None` if it is not visible or unknown.
/// `places` is the mapping from the picture, if the points are not in image pixels.
pub fn pixel(shapes: &Descriptors, places: Option<&Mapping>, point: [f64; 2]) -> Option<[f64; 2]> {
    let is_number = point.iter().all(|x| x.is_finite());
    match places {
        Some(places) => places.pixel(point).filter(|_| is_number),
        None => (is_number && shapes.unit() == Some(Unit::Pixel)).then_some(point),
    }
}
