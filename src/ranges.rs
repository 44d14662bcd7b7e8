//! Which stretches of a growing array are in use: first fit, neighbours joined.

use std::collections::BTreeMap;

/// Allocator of stretches of one array whose length grows and shrinks with them.
#[derive(Debug, Default)]
pub(crate) struct Ranges {
    /// Start to length of each unused stretch below `end`; never two that touch, never one that touches `end`.
    free: BTreeMap<u32, u32>,
    end: u32,
}

impl Ranges {
    /// Elements from the array's start to the end of the last stretch in use.
    pub(crate) fn end(&self) -> u32 {
        self.end
    }

    /// Where `length` elements would go; nothing is taken yet.
    fn find(&self, length: u32) -> Option<u32> {
        self.free.iter().find(|(_, free)| **free >= length).map(|(start, _)| *start)
    }

    /// `end` as it would be after [`Self::allocate`].
    pub(crate) fn end_after(&self, length: u32) -> u64 {
        match self.find(length) {
            Some(_) => u64::from(self.end),
            None => u64::from(self.end) + u64::from(length),
        }
    }

    /// Takes `length` elements and returns the first.
    pub(crate) fn allocate(&mut self, length: u32) -> u32 {
        let Some(start) = self.find(length) else {
            let start = self.end;
            self.end += length;
            return start;
        };
        if let Some(free) = self.free.remove(&start)
            && free > length
        {
            self.free.insert(start + length, free - length);
        }
        start
    }

    /// Gives back what [`Self::allocate`] gave.
    pub(crate) fn release(&mut self, mut start: u32, mut length: u32) {
        if let Some(next) = self.free.remove(&(start + length)) {
            length += next;
        }
        if let Some((&before, &free)) = self.free.range(..start).next_back()
            && before + free == start
        {
            self.free.remove(&before);
            start = before;
            length += free;
        }
        if start + length == self.end {
            self.end = start;
        } else if length > 0 {
            self.free.insert(start, length);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Ranges;

    #[test]
    fn reuses_and_joins_what_is_released() {
        let mut ranges = Ranges::default();
        let starts: Vec<u32> = (0..4).map(|_| ranges.allocate(10)).collect();
        assert_eq!(starts, [0, 10, 20, 30]);
        ranges.release(10, 10);
        ranges.release(20, 10);
        assert_eq!(ranges.end_after(20), 40);
        assert_eq!(ranges.end_after(21), 61);
        assert_eq!(ranges.allocate(15), 10);
        assert_eq!(ranges.allocate(5), 25);
        ranges.release(30, 10);
        assert_eq!(ranges.end(), 30);
        ranges.release(0, 10);
        ranges.release(25, 5);
        ranges.release(10, 15);
        assert_eq!(ranges.end(), 0);
        assert!(ranges.free.is_empty());
    }
}
