//! Needs as people write them.

use std::time::Duration;

use super::Need;

impl Need {
    /// Reads an RMSE, "1e-3".
    ///
    /// # Errors
    /// How to write it.
    pub fn parse_error(text: &str) -> Result<f64, String> {
        let error = text
            .trim()
            .parse()
            .ok()
            .filter(|e: &f64| *e > 0.0 && e.is_finite());
        error.ok_or_else(|| "give an RMSE of more than 0, such as 1e-3".into())
    }

    /// Reads a time with its unit, "16ms" or "0.5s".
    ///
    /// # Errors
    /// How to write it.
    pub fn parse_budget(text: &str) -> Result<Duration, String> {
        const UNITS: [(&str, f64); 5] = [
            ("ms", 1e-3),
            ("us", 1e-6),
            ("µs", 1e-6),
            ("min", 60.0),
            ("s", 1.0),
        ];
        let seconds = quantity(text, &UNITS);
        let duration = seconds.and_then(|s| Duration::try_from_secs_f64(s).ok());
        let duration = duration.filter(|duration| !duration.is_zero());
        duration.ok_or_else(|| "write it like 16ms or 0.5s".into())
    }

    /// Reads a size with its unit, "2GB" or "512MiB".
    ///
    /// # Errors
    /// How to write it.
    pub fn parse_memory(text: &str) -> Result<u64, String> {
        const UNITS: [(&str, f64); 9] = [
            ("kB", 1e3),
            ("KB", 1e3),
            ("MB", 1e6),
            ("GB", 1e9),
            ("TB", 1e12),
            ("KiB", 1024.0),
            ("MiB", 1048576.0),
            ("GiB", 1073741824.0),
            ("B", 1.0),
        ];
        let bytes = quantity(text, &UNITS);
        let bytes = bytes.filter(|b| *b >= 1.0 && *b < u64::MAX as f64);
        let bytes = bytes.map(|bytes| bytes as u64);
        bytes.ok_or_else(|| "write it like 2GB or 512MB".into())
    }
}

/// A number with the first unit that its text ends with; units that end others come last.
fn quantity(text: &str, units: &[(&str, f64)]) -> Option<f64> {
    let text = text.trim();
    let (number, unit) = units
        .iter()
        .find_map(|(unit, size)| Some((text.strip_suffix(unit)?, size)))?;
    let number: f64 = number.trim().parse().ok()?;
    Some(number * unit).filter(|n| *n > 0.0 && n.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantities_have_units() {
        assert_eq!(Need::parse_budget("16ms"), Ok(Duration::from_millis(16)));
        assert_eq!(Need::parse_budget("0.5s"), Ok(Duration::from_millis(500)));
        assert_eq!(Need::parse_budget("250 µs"), Ok(Duration::from_micros(250)));
        assert_eq!(Need::parse_budget("2min"), Ok(Duration::from_secs(120)));
        for wrong in [
            "", "16", "ms", "-1ms", "0s", "infs", "nans", "1e400s", "1e30s", "16 m", "1e-12s",
        ] {
            assert_eq!(
                Need::parse_budget(wrong),
                Err("write it like 16ms or 0.5s".into()),
                "{wrong}"
            );
        }
        assert_eq!(Need::parse_memory("2GB"), Ok(2_000_000_000));
        assert_eq!(Need::parse_memory("512 MB"), Ok(512_000_000));
        assert_eq!(Need::parse_memory("1.5GiB"), Ok(3 << 29));
        assert_eq!(Need::parse_memory("100B"), Ok(100));
        for wrong in ["", "2", "GB", "-2GB", "0B", "2gb", "1e30TB", "0.5B"] {
            assert_eq!(
                Need::parse_memory(wrong),
                Err("write it like 2GB or 512MB".into()),
                "{wrong}"
            );
        }
        assert_eq!(Need::parse_error("1e-3"), Ok(1e-3));
        for wrong in ["", "0", "-1", "nan", "inf", "1e-3s"] {
            assert!(Need::parse_error(wrong).is_err(), "{wrong}");
        }
    }
}
