//! Doubts of the extraction about the picture that is shown, in words. The chain reports them on
//! its own terminal, which the user of the page may not see, and no message carries them. So the
//! page's own extractor checks a frame now and then, with the rig's settings.

use std::time::{Duration, Instant};

use lariat_chain::pipeline::{FrameExtractor, FrameView};
use lariat_chain::settings::settings_of;
use lariat_extract::{Mask, Notice};
use lariat_wire::{Centerlines, Member};

use crate::moment::Moment;

/// Interval between two checks.
const LOOK: Duration = Duration::from_secs(2);

/// The notice to show.
#[derive(Default)]
pub(crate) struct Notices {
    due: Option<Instant>,
    /// The settings, and the extractor for them; `None` if it cannot run, or masks are external.
    extractor: Option<(Member, Option<FrameExtractor>)>,
    last: Option<Notice>,
    told: Option<Notice>,
}

impl std::fmt::Debug for Notices {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Notices")
            .field("told", &self.told)
            .finish_non_exhaustive()
    }
}

impl Notices {
    /// Checks a moment, if a check is due. `extract` is the rig's stage, if it runs.
    pub(crate) fn look(&mut self, moment: &Moment, extract: Option<&Member>) {
        let now = Instant::now();
        if self.due.is_some_and(|due| now < due) {
            return;
        }
        self.due = Some(now + LOOK);
        let Some(extract) = extract else {
            return;
        };
        if self
            .extractor
            .as_ref()
            .is_none_or(|(known, _)| known != extract)
        {
            self.extractor = Some((extract.clone(), extractor(extract)));
        }
        let extractor = self
            .extractor
            .as_mut()
            .and_then(|(_, extractor)| extractor.as_mut());
        let notice = extractor.and_then(|extractor| notice(extractor, moment));
        // Only a notice seen twice in a row counts, so a passing hand causes none.
        if notice == self.last {
            self.told = notice;
        }
        self.last = notice;
    }

    /// Returns the notice, as a sentence that says what to do.
    pub(crate) fn said(&self) -> Option<String> {
        let (_, extractor) = self.extractor.as_ref()?;
        Some(extractor.as_ref()?.sentence(self.told?))
    }
}

fn extractor(extract: &Member) -> Option<FrameExtractor> {
    let settings = settings_of(extract).ok()?;
    if settings.extract.mask == Mask::External {
        return None;
    }
    FrameExtractor::new(&settings.extract).ok()
}

fn notice(extractor: &mut FrameExtractor, moment: &Moment) -> Option<Notice> {
    let image = moment.image.as_ref()?;
    let whole = FrameView::new(&image.header, &image.bytes).image().ok()?;
    let part = extractor.part(whole).ok()?;
    let mut seen = Box::new(Centerlines::EMPTY);
    extractor.forget();
    let scene = extractor.extract(
        &part,
        None,
        image.header.trace.exposed_ns,
        &mut |_| {},
        &mut seen,
    );
    scene.ok()?.notice
}
