//! The report as a table for a terminal.

use super::numbers::{bytes, milliseconds, scientific};
use super::skipped::skipped;
use super::{ErrorSource, Outcome, Report};

impl Report {
    /// The report as a table for a terminal.
    pub fn to_table(&self) -> String {
        let mut rows = vec![
            [
                "scene",
                "model",
                "algorithm",
                "setting",
                "RMSE",
                "max",
                "PSNR dB",
                "prepare ms",
                "frame ms",
                "clock",
                "resident",
            ]
            .map(String::from),
        ];
        let mut breaks = Vec::new();
        for scene in &self.scenes {
            breaks.push(rows.len());
            for model in &scene.models {
                for row in &model.rows {
                    let setting = if row.setting.is_empty() {
                        "–"
                    } else {
                        &row.setting
                    };
                    let name = [
                        scene.name.clone(),
                        model.model.clone(),
                        row.algorithm.clone(),
                        setting.into(),
                    ];
                    let drawn = match &row.outcome {
                        Outcome::Drawn(drawn) => drawn,
                        Outcome::Skipped(_) => continue,
                    };
                    let [rmse, max, psnr] = match drawn.error.as_ref().map(|e| e.image) {
                        Some(e) => [
                            scientific(e.rmse),
                            scientific(e.max),
                            e.psnr.map_or("∞".into(), |p| format!("{p:.1}")),
                        ],
                        None => [
                            "truth".into(),
                            format!("±{}", scientific(model.truth_bound.unwrap_or(0.0))),
                            "–".into(),
                        ],
                    };
                    let [a, b, c, d] = name;
                    rows.push([
                        a,
                        b,
                        c,
                        d,
                        rmse,
                        max,
                        psnr,
                        milliseconds(drawn.prepare_ms),
                        milliseconds(drawn.frame_ms),
                        drawn.clock.clone(),
                        bytes(drawn.stats.bytes_resident),
                    ]);
                }
            }
        }
        let width = |column: usize| {
            rows.iter()
                .map(|r| r[column].chars().count())
                .max()
                .unwrap_or(0)
        };
        let widths: Vec<usize> = (0..rows[0].len()).map(width).collect();
        let mut table = String::new();
        for (i, row) in rows.iter().enumerate() {
            if breaks.contains(&i) {
                table.push_str(&"─".repeat(widths.iter().sum::<usize>() + 2 * (widths.len() - 1)));
                table.push('\n');
            }
            let cells = row
                .iter()
                .zip(&widths)
                .enumerate()
                .map(|(column, (cell, &width))| {
                    // Words to the left, numbers to the right.
                    if column < 4 {
                        format!("{cell:<width$}")
                    } else {
                        format!("{cell:>width$}")
                    }
                });
            table.push_str(cells.collect::<Vec<_>>().join("  ").trim_end());
            table.push('\n');
        }
        for scene in &self.scenes {
            for model in &scene.models {
                for part in &model.sources {
                    let ErrorSource { source, with, .. } = part;
                    table.push_str(&format!(
                        "{} {}: {source}: RMSE {}, max {}: {with} against {}\n",
                        scene.name,
                        model.model,
                        scientific(part.error.rmse),
                        scientific(part.error.max),
                        part.against
                    ));
                }
            }
        }
        for scene in &self.scenes {
            for one in skipped(scene.models.iter()) {
                let [not_drawn, all] = one.settings;
                let share = match not_drawn == all {
                    true => String::new(),
                    false => format!("{not_drawn} of {all} settings "),
                };
                table.push_str(&format!(
                    "{} {}: {share}skipped: {}\n",
                    scene.name, one.algorithm, one.reasons
                ));
            }
        }
        table
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{report, with_settings_that_draw_nothing};

    #[test]
    fn the_table_has_a_line_a_row_and_says_what_was_skipped() {
        let table = report("sphere").to_table();
        let lines: Vec<_> = table.lines().collect();
        assert_eq!(lines.len(), 6, "{table}");
        assert!(
            lines[3].contains("1.50e-4") && lines[3].contains("gpu"),
            "{table}"
        );
        assert!(lines[4].contains("order alone: RMSE 1.50e-4"), "{table}");
        assert!(lines[5].contains("skipped: no <adapter>"), "{table}");
    }

    #[test]
    fn what_is_not_drawn_takes_a_line_for_each_algorithm() {
        let table = with_settings_that_draw_nothing().to_table();
        let lines: Vec<&str> = table.lines().filter(|l| l.contains("skipped")).collect();
        assert_eq!(
            lines,
            [
                "sphere projection: 1 of 2 settings skipped: no <adapter>",
                "sphere slicing: skipped: no grid; too large"
            ]
        );
    }
}
