//! Text for people: tables that read well on a terminal and are Markdown at the same time, numbers, errors.

use std::fmt;

/// A table in Markdown, its columns padded to one width. The first column is text, the others are figures.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Table {
    head: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl Table {
    /// An empty table with these columns.
    #[must_use]
    pub fn new(head: &[&str]) -> Self {
        Self { head: head.iter().map(|&title| title.to_owned()).collect(), rows: Vec::new() }
    }

    /// Adds a row; cells that are missing stay empty.
    pub fn row(&mut self, cells: impl IntoIterator<Item = String>) {
        let mut cells: Vec<String> = cells.into_iter().collect();
        cells.resize(self.head.len(), String::new());
        self.rows.push(cells);
    }

    /// Whether it has no rows.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    fn widths(&self) -> Vec<usize> {
        let all = || self.rows.iter().chain([&self.head]);
        (0..self.head.len()).map(|column| all().map(|row| row[column].chars().count()).max().unwrap_or(0)).collect()
    }
}

impl fmt::Display for Table {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let widths: Vec<usize> = self.widths().into_iter().map(|width| width.max(3)).collect();
        let ruler = widths.iter().enumerate().map(|(column, width)| match column {
            0 => "-".repeat(*width),
            _ => "-".repeat(width - 1) + ":",
        });
        let ruler: Vec<String> = ruler.collect();
        for row in [&self.head, &ruler].into_iter().chain(&self.rows) {
            for (column, (cell, &width)) in row.iter().zip(&widths).enumerate() {
                if column == 0 { write!(f, "| {cell:width$} |")? } else { write!(f, " {cell:>width$} |")? }
            }
            writeln!(f)?;
        }
        Ok(())
    }
}

/// A number with commas between its thousands.
#[must_use]
pub fn grouped(number: usize) -> String {
    let digits = number.to_string();
    let from_the_end = digits.as_bytes().rchunks(3).rev();
    let groups: Vec<_> = from_the_end.map(String::from_utf8_lossy).collect();
    groups.join(",")
}

/// The pixels of a screen across and down, as in `1920x1080`.
///
/// # Errors
/// A message, for anything else and for sizes that aren't 1 to 8192 each way.
pub fn parse_size(text: &str) -> Result<(u32, u32), String> {
    let pixels = |text: &str| text.parse::<u32>().ok().filter(|pixels| (1..=8192).contains(pixels));
    let parsed = text.split_once('x').and_then(|(width, height)| pixels(width).zip(pixels(height)));
    parsed.ok_or_else(|| format!("{text:?} is not like 1920x1080, with 1 to 8192 pixels each way"))
}

/// A message in one line: those of some files and drivers have several.
#[must_use]
pub fn one_line(message: impl fmt::Display) -> String {
    message.to_string().split_whitespace().collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_as_wide_as_their_widest_cell() {
        let mut table = Table::new(&["scene", "ms"]);
        assert!(table.is_empty());
        table.row(["hall".to_owned(), "1.25".to_owned()]);
        table.row(["the long hall".to_owned()]);
        let lines = [
            "| scene         |   ms |",
            "| ------------- | ---: |",
            "| hall          | 1.25 |",
            "| the long hall |      |",
        ];
        assert_eq!(table.to_string().lines().collect::<Vec<_>>(), lines);
    }

    #[test]
    fn messages_of_several_lines() {
        assert_eq!(one_line("a\n    b  c\n"), "a b c");
    }

    #[test]
    fn sizes() {
        assert_eq!(parse_size("1920x1080"), Ok((1920, 1080)));
        for wrong in ["", "1920", "0x1080", "1920x8193", "-1x5", "1920x1080x1"] {
            assert!(parse_size(wrong).unwrap_err().contains("1920x1080"), "{wrong}");
        }
    }

    #[test]
    fn thousands() {
        assert_eq!([0, 999, 1000, 1_234_567].map(grouped), ["0", "999", "1,000", "1,234,567"]);
    }
}
