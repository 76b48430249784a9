//! temporary
use anyhow::Result;
use clap::Args;
use std::path::PathBuf;
#[derive(Args, Default, Debug, Clone)]
pub struct ChainArgs {
    #[arg(long)]
    pub source: Vec<String>,
    #[arg(long)]
    pub fps: Option<String>,
    #[arg(long)]
    pub duration: Option<f64>,
    #[arg(long)]
    pub frames: Option<u64>,
    #[arg(long)]
    pub order: Option<usize>,
    #[arg(long)]
    pub rig: Option<String>,
    #[arg(long)]
    pub lossless: bool,
    #[arg(long)]
    pub out: Option<PathBuf>,
}
pub struct Settings {
    pub run: Run,
    pub capture: Capture,
    pub extract: Extract,
    pub fit: Fit,
}
pub struct Run {
    pub rig: String,
    pub lossless: bool,
    pub frames: Option<u64>,
    pub duration: Option<f64>,
    pub out: Option<PathBuf>,
}
impl Run {
    pub fn duration_ns(&self) -> Option<u64> {
        self.duration.map(|d| (d * 1e9) as u64)
    }
}
pub struct Capture {
    source: Vec<String>,
    fps: String,
}
impl Capture {
    pub fn source(&self) -> lariat_capture::Source {
        let names = if self.source.is_empty() { vec!["rendered".to_string()] } else { self.source.clone() };
        lariat_capture::Source::named(&names, false, Default::default())
    }
    pub fn pace(&self, _native: Option<f64>) -> lariat_capture::Pace {
        self.fps.parse().unwrap()
    }
}
pub struct Extract {
    pub points: usize,
}
impl Extract {
    pub fn options(&self) -> lariat_extract::Options {
        lariat_extract::Options {
            points: self.points,
            ..Default::default()
        }
    }
}
pub struct Fit {
    order: usize,
}
impl Fit {
    pub fn options(&self, points: usize) -> lariat_fit::Options {
        lariat_fit::Options {
            points,
            order: self.order,
            ..Default::default()
        }
    }
}
impl Settings {
    pub fn resolve(a: &ChainArgs) -> Result<Self> {
        Ok(Self {
            run: Run {
                rig: a.rig.clone().unwrap_or("default".into()),
                lossless: a.lossless,
                frames: a.frames,
                duration: a.duration,
                out: a.out.clone(),
            },
            capture: Capture {
                source: a.source.clone(),
                fps: a.fps.clone().unwrap_or("30".into()),
            },
            extract: Extract { points: 120 },
            fit: Fit {
                order: a.order.unwrap_or(8),
            },
        })
    }
    pub fn sink_options(&self, from_start: bool) -> lariat_sink::Options {
        lariat_sink::Options {
            from_start,
            ..Default::default()
        }
    }
}
