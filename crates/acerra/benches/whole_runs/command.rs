//! A run of the command, as its `run.json` and the system account for it.

use std::path::Path;
use std::process::Command;
use std::time::Instant;

use serde_json::Value;

/// The stages, in their order.
const STAGES: [&str; 7] = [
    "read", "position", "align", "clean", "focus", "measure", "deliver",
];

/// What a run took (s).
#[derive(Clone, Copy, Debug, Default)]
pub struct Cost {
    stages_s: [f64; STAGES.len()],
    /// From start to end, and by the processors together.
    whole_s: f64,
    processor_s: f64,
    /// Largest memory of any stage (MB).
    memory_mb: f64,
}

/// Runs `program focus` on a campaign.
pub fn run(program: &str, campaign: &Path) -> Cost {
    let products = campaign.with_file_name("products");
    let _ = std::fs::remove_dir_all(&products);
    let before_s = children_s();
    let start = Instant::now();
    let done = Command::new(program)
        .arg("focus")
        .arg(campaign)
        .arg("-o")
        .arg(&products)
        .output()
        .unwrap();
    let whole_s = start.elapsed().as_secs_f64();
    assert!(
        done.status.success(),
        "{}",
        String::from_utf8_lossy(&done.stderr)
    );
    let text = std::fs::read(products.join("run.json")).unwrap();
    let record: Value = serde_json::from_slice(&text).unwrap();
    let stages = record["stages"].as_array().unwrap();
    let seconds = |name: &str| {
        let own = stages.iter().filter(|stage| stage["name"] == name);
        own.filter_map(|stage| stage["seconds"].as_f64()).sum()
    };
    let memory = stages
        .iter()
        .filter_map(|s| s["peak_memory_bytes"].as_f64());
    Cost {
        stages_s: STAGES.map(seconds),
        whole_s,
        processor_s: children_s() - before_s,
        memory_mb: 1e-6 * memory.fold(0.0, f64::max),
    }
}

impl Cost {
    /// Head of the table.
    pub const HEAD: &str = "\
| run | read | position | align | clean | focus | measure | deliver | whole | processor | memory (MB) |\n\
| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |";

    /// The median of each figure.
    pub fn median(runs: &[Self]) -> Self {
        let of = |figure: &dyn Fn(&Self) -> f64| {
            let mut values: Vec<f64> = runs.iter().map(figure).collect();
            values.sort_by(f64::total_cmp);
            values[values.len() / 2]
        };
        Self {
            stages_s: std::array::from_fn(|k| of(&|cost| cost.stages_s[k])),
            whole_s: of(&|cost| cost.whole_s),
            processor_s: of(&|cost| cost.processor_s),
            memory_mb: of(&|cost| cost.memory_mb),
        }
    }

    /// A row of the table.
    pub fn row(&self, name: &str) -> String {
        let mut row = format!("| {name} |");
        for seconds in self
            .stages_s
            .iter()
            .chain([&self.whole_s, &self.processor_s])
        {
            row += &format!(" {seconds:.2} |");
        }
        row + &format!(" {:.0} |", self.memory_mb)
    }

    /// By how much the whole run is faster than another, by the clock and by the processors' time.
    pub fn ratios(&self, other: &Self) -> String {
        format!(
            "{:.2} times by the clock, {:.2} by processor time",
            other.whole_s / self.whole_s,
            other.processor_s / self.processor_s
        )
    }

    /// The whole run over reading, positioning and focusing.
    pub fn over_needed(&self) -> f64 {
        let of = |name: &str| {
            let at = STAGES.iter().position(|stage| *stage == name);
            at.map_or(0.0, |k| self.stages_s[k])
        };
        self.whole_s / (of("read") + of("position") + of("focus")).max(1e-3)
    }
}

/// Processor time of the processes that have ended (s; Linux, zero elsewhere).
fn children_s() -> f64 {
    let Ok(text) = std::fs::read_to_string("/proc/self/stat") else {
        return 0.0;
    };
    // After the name, which may hold anything but ends with the last parenthesis; in hundredths of a second.
    let fields = text.rsplit(')').next().unwrap_or_default();
    let ticks = fields.split_whitespace().skip(13).take(2);
    ticks.filter_map(|t| t.parse::<f64>().ok()).sum::<f64>() / 100.0
}
