//! Selection of the registers in which work runs.

use std::fmt;
use std::sync::atomic::{AtomicU8, Ordering};

use pulp::NullaryFnOnce;

use crate::plain::Plain;
use crate::simd::Simd;
#[cfg(target_arch = "x86_64")]
use crate::x86::Two;
#[cfg(target_arch = "x86_64")]
use pulp::x86::{V3, V4};

/// Work that is compiled for every kind of registers.
pub trait WithSimd {
    /// Result of the work.
    type Output;

    /// Does the work. Mark it and everything it calls `#[inline(always)]`; only then is it compiled
    /// for these registers.
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output;
}

impl<F: NullaryFnOnce> WithSimd for F {
    type Output = F::Output;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> F::Output {
        self.call()
    }
}

/// The registers of a machine. Results do not depend on them.
#[derive(Clone, Copy, Debug)]
pub enum Arch {
    /// The baseline registers of every machine of the architecture.
    Plain,
    /// AVX2, and everything else in x86-64-v3.
    #[cfg(target_arch = "x86_64")]
    V3(V3),
    /// AVX-512.
    #[cfg(target_arch = "x86_64")]
    V4(V4),
}

/// The registers forced by a test; 0 is the widest.
static KEPT_TO: AtomicU8 = AtomicU8::new(0);
#[cfg(target_arch = "x86_64")]
const V3_ONLY: u8 = 2;
const PLAIN_ONLY: u8 = 1;

impl Arch {
    /// The widest registers of this machine.
    #[inline]
    pub fn new() -> Self {
        let kept_to = KEPT_TO.load(Ordering::Relaxed);
        #[cfg(target_arch = "x86_64")]
        if kept_to != PLAIN_ONLY {
            if kept_to != V3_ONLY
                && let Some(v4) = V4::try_new()
            {
                return Self::V4(v4);
            }
            if let Some(v3) = V3::try_new() {
                return Self::V3(v3);
            }
        }
        let _ = kept_to;
        Self::Plain
    }

    /// Makes [`new`](Self::new) return these registers from now on, in the whole process. Results
    /// do not change; this is for the tests that prove it.
    pub fn keep_to(self) {
        let kept_to = match self {
            Self::Plain => PLAIN_ONLY,
            #[cfg(target_arch = "x86_64")]
            Self::V3(_) => V3_ONLY,
            #[cfg(target_arch = "x86_64")]
            Self::V4(_) => 0,
        };
        KEPT_TO.store(kept_to, Ordering::Relaxed);
    }

    /// All registers of this machine, plain ones first, for tests that compare them.
    pub fn all() -> Vec<Self> {
        #[cfg(target_arch = "x86_64")]
        let wide = [V3::try_new().map(Self::V3), V4::try_new().map(Self::V4)];
        #[cfg(not(target_arch = "x86_64"))]
        let wide: [Option<Self>; 0] = [];
        std::iter::once(Self::Plain)
            .chain(wide.into_iter().flatten())
            .collect()
    }

    /// Does the work in these registers.
    #[inline(always)]
    pub fn dispatch<W: WithSimd>(self, work: W) -> W::Output {
        match self {
            Self::Plain => work.with_simd(Plain),
            #[cfg(target_arch = "x86_64")]
            Self::V3(v3) => pulp::Simd::vectorize(v3, In(Two(v3), work)),
            #[cfg(target_arch = "x86_64")]
            Self::V4(v4) => pulp::Simd::vectorize(v4, In(v4, work)),
        }
    }
}

/// The name of the instruction set.
impl fmt::Display for Arch {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            #[cfg(target_arch = "x86_64")]
            Self::V4(_) => "AVX-512",
            #[cfg(target_arch = "x86_64")]
            Self::V3(_) => "AVX2",
            Self::Plain if cfg!(target_arch = "x86_64") => "SSE2",
            Self::Plain if cfg!(target_arch = "aarch64") => "NEON",
            Self::Plain => "none",
        })
    }
}

impl Default for Arch {
    fn default() -> Self {
        Self::new()
    }
}

/// Work and its registers, in the form that pulp expects.
#[cfg(target_arch = "x86_64")]
struct In<S, W>(S, W);

#[cfg(target_arch = "x86_64")]
impl<S: Simd, W: WithSimd> NullaryFnOnce for In<S, W> {
    type Output = W::Output;

    #[inline(always)]
    fn call(self) -> W::Output {
        self.1.with_simd(self.0)
    }
}
