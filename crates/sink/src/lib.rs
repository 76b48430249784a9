//! What the chain did: latency histograms, losses, errors against the truth, reports.
