//! What the library is held against: the feature `compare`.
//!
//! [`reference`](mod@reference) is the truth by ray casting, [`ideal`] the map and the lookup as they would be if the
//! resolution were the only source of error, [`error_figures`] says how far from both an answer is.

pub mod error_figures;
pub mod ideal;
pub mod reference;
#[cfg(test)]
mod test_shapes;
