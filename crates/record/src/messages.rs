//! The messages of the channels as they stand in a recording: only what is meant of each list, nothing stale.

use lariat_message::{
    CenterlinePoints, Centerlines, Crossing, Curve, Descriptor, Descriptors, FrameHeader,
    MAX_POINTS, Trace,
};

use crate::cdr::{Cdr, CdrError, Decoder, Encoder, fields};
use crate::schema::{Schema, schema};

/// A message that can be recorded.
pub trait Record {
    /// Its definition.
    const SCHEMA: Schema;

    /// Writes it into a buffer, which is emptied first.
    fn encode(&self, into: &mut Vec<u8>);

    /// Reads it. What is not meant (behind a `count`) stays as it was; after an error, anything may stand in it.
    ///
    /// # Errors
    /// The bytes are no such message.
    fn decode(&mut self, cdr: &[u8]) -> Result<(), CdrError>;
}

macro_rules! record {
    ($type:ty, $schema:expr) => {
        impl Record for $type {
            const SCHEMA: Schema = $schema;

            fn encode(&self, into: &mut Vec<u8>) {
                self.put(&mut Encoder::new(into));
            }

            fn decode(&mut self, cdr: &[u8]) -> Result<(), CdrError> {
                self.get(&mut Decoder::new(cdr)?)
            }
        }
    };
}
pub(crate) use record;

record!(
    FrameHeader,
    schema!(
        "lariat_msgs/msg/FrameHeader",
        "FrameHeader.msg",
        "lariat_msgs/Trace" = "Trace.msg"
    )
);
record!(
    Centerlines,
    schema!(
        "lariat_msgs/msg/Centerlines",
        "Centerlines.msg",
        "lariat_msgs/Trace" = "Trace.msg",
        "lariat_msgs/Curve" = "Curve.msg",
        "lariat_msgs/Crossing" = "Crossing.msg",
        "lariat_msgs/PointF32" = "PointF32.msg"
    )
);
record!(
    Descriptors,
    schema!(
        "lariat_msgs/msg/Descriptors",
        "Descriptors.msg",
        "lariat_msgs/Trace" = "Trace.msg",
        "lariat_msgs/Descriptor" = "Descriptor.msg",
        "lariat_msgs/CenterlinePoints" = "CenterlinePoints.msg",
        "lariat_msgs/PointF32" = "PointF32.msg",
        "lariat_msgs/PointF64" = "PointF64.msg",
        "lariat_msgs/Covariance" = "Covariance.msg"
    )
);

fields!(Trace {
    sequence,
    captured,
    extracted,
    fitted,
    exposed_ns,
    captured_ns,
    extract_started_ns,
    extracted_ns,
    fit_started_ns,
    fitted_ns,
});
fields!(FrameHeader {
    trace,
    width,
    height,
    stride,
    pixel_format,
    source,
});
fields!(Crossing {
    at,
    over,
    under,
    over_rho,
    under_rho,
    confidence,
});

fn put_hidden(to: &mut Encoder, count: usize, is_hidden: impl Fn(usize) -> bool) {
    (count as u32).put(to);
    for i in 0..count {
        u8::from(is_hidden(i)).put(to);
    }
}

/// Reads which of so many points are hidden.
fn get_hidden(from: &mut Decoder, points: u32) -> Result<impl Iterator<Item = bool>, CdrError> {
    let mut hidden = [0_u8; MAX_POINTS];
    let count = from.sequence(&mut hidden)?;
    if count != points {
        return Err(CdrError::Uneven);
    }
    Ok(hidden
        .into_iter()
        .take(count as usize)
        .map(|byte| byte != 0))
}

impl Cdr for Curve {
    fn put(&self, to: &mut Encoder) {
        let count = self.points().len();
        for word in [self.track, self.status, self.closed, self.border] {
            word.put(to);
        }
        self.width_px.put(to);
        self.length_px.put(to);
        self.age_ns.put(to);
        to.sequence(self.points());
        to.sequence(self.widths_px());
        put_hidden(to, count, |i| self.is_hidden(i));
    }

    fn get(&mut self, from: &mut Decoder) -> Result<(), CdrError> {
        let words = [
            &mut self.track,
            &mut self.status,
            &mut self.closed,
            &mut self.border,
        ];
        for word in words {
            word.get(from)?;
        }
        self.width_px.get(from)?;
        self.length_px.get(from)?;
        self.age_ns.get(from)?;
        self.reserved = 0;
        self.count = from.sequence(&mut self.points)?;
        if from.sequence(&mut self.widths_px)? != self.count {
            return Err(CdrError::Uneven);
        }
        self.set_hidden(get_hidden(from, self.count)?);
        Ok(())
    }
}

impl Cdr for Centerlines {
    fn put(&self, to: &mut Encoder) {
        self.trace.put(to);
        self.width.put(to);
        self.height.put(to);
        to.sequence(self.curves());
        to.sequence(self.crossings());
    }

    fn get(&mut self, from: &mut Decoder) -> Result<(), CdrError> {
        self.trace.get(from)?;
        self.width.get(from)?;
        self.height.get(from)?;
        self.count = from.sequence(&mut self.curves)?;
        self.crossing_count = from.sequence(&mut self.crossings)?;
        Ok(())
    }
}

impl Cdr for Descriptor {
    fn put(&self, to: &mut Encoder) {
        for word in [
            self.track,
            self.status,
            self.basis,
            self.order,
            self.samples,
            self.closed,
            self.border,
            self.hidden,
            self.filtered,
            self.fit,
        ] {
            word.put(to);
        }
        for number in [
            self.rms,
            self.max,
            self.residual_variance,
            self.condition,
            self.length,
            self.width,
        ] {
            number.put(to);
        }
        self.age_ns.put(to);
        to.sequence(self.control_points());
        to.sequence(self.weights());
        to.sequence(self.covariances());
        to.sequence(self.velocities());
        to.sequence(self.inner_knots());
    }

    fn get(&mut self, from: &mut Decoder) -> Result<(), CdrError> {
        let words = [
            &mut self.track,
            &mut self.status,
            &mut self.basis,
            &mut self.order,
            &mut self.samples,
            &mut self.closed,
            &mut self.border,
            &mut self.hidden,
            &mut self.filtered,
            &mut self.fit,
        ];
        for word in words {
            word.get(from)?;
        }
        let numbers = [
            &mut self.rms,
            &mut self.max,
            &mut self.residual_variance,
            &mut self.condition,
            &mut self.length,
            &mut self.width,
        ];
        for number in numbers {
            number.get(from)?;
        }
        self.age_ns.get(from)?;
        self.reserved = 0;
        self.count = from.sequence(&mut self.control_points)?;
        let others = [
            from.sequence(&mut self.weights)?,
            from.sequence(&mut self.covariances)?,
            from.sequence(&mut self.velocities)?,
        ];
        let knots = from.sequence(&mut self.knots)?;
        if others != [self.count; 3] || knots as usize != self.inner_knots().len() {
            return Err(CdrError::Uneven);
        }
        Ok(())
    }
}

impl Cdr for CenterlinePoints {
    fn put(&self, to: &mut Encoder) {
        self.closed.put(to);
        to.sequence(self.points());
        to.sequence(self.widths());
        put_hidden(to, self.points().len(), |i| self.is_hidden(i));
    }

    fn get(&mut self, from: &mut Decoder) -> Result<(), CdrError> {
        self.closed.get(from)?;
        self.count = from.sequence(&mut self.points)?;
        if from.sequence(&mut self.widths)? != self.count {
            return Err(CdrError::Uneven);
        }
        self.set_hidden(get_hidden(from, self.count)?);
        Ok(())
    }
}

impl Cdr for Descriptors {
    fn put(&self, to: &mut Encoder) {
        self.trace.put(to);
        self.width.put(to);
        self.height.put(to);
        self.unit.put(to);
        to.sequence(self.curves());
        to.sequence(self.centerlines());
    }

    fn get(&mut self, from: &mut Decoder) -> Result<(), CdrError> {
        self.trace.get(from)?;
        self.width.get(from)?;
        self.height.get(from)?;
        self.unit.get(from)?;
        self.count = from.sequence(&mut self.curves)?;
        if from.sequence(&mut self.centerlines)? != self.count {
            return Err(CdrError::Uneven);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
