//! Accessors: typed values out of a document's buffers, with every offset checked.

use std::cell::Cell;

use gltf::json::{
    accessor::{ComponentType, Type},
    validation::Checked,
};

use super::{
    SceneError,
    document::{Document, slice},
};

/// More elements than any test scene has, yet few enough that a hostile count cannot exhaust the memory.
const MAX_ELEMENTS: usize = 1 << 26;

/// Reads accessors of one document, and keeps count of what was read.
pub(super) struct Reader<'a> {
    document: &'a Document,
    left: Cell<usize>,
}

/// Where the elements of an accessor lie, before bounds are known to hold.
#[derive(Clone, Copy)]
struct Layout {
    view: usize,
    offset: u64,
    count: usize,
    component: ComponentType,
    normalized: bool,
}

impl<'a> Reader<'a> {
    pub fn new(document: &'a Document) -> Self {
        Self { document, left: Cell::new(MAX_ELEMENTS) }
    }

    /// All elements of accessor `index`, which must be of type `kind` with `N` components; `what` names it in errors.
    ///
    /// Normalised integers are mapped to 0..=1 or -1..=1, other integers keep their value; `f64` holds all exactly.
    pub fn read<const N: usize>(&self, index: usize, kind: Type, what: &str) -> Result<Vec<[f64; N]>, SceneError> {
        let accessor =
            self.document.item(&self.document.root.accessors, index, || format!("the accessor of {what}"))?;
        if accessor.type_ != Checked::Valid(kind) {
            return Err(self.invalid(index, what, format_args!("is not of type {kind:?}")));
        }
        let Checked::Valid(component) = &accessor.component_type else {
            return Err(self.invalid(index, what, "has an unknown component type"));
        };
        let count = self.charge(accessor.count.0)?;
        let layout = |view: usize, offset| Layout {
            view,
            offset,
            count,
            component: component.0,
            normalized: accessor.normalized,
        };
        let mut values = match accessor.buffer_view {
            Some(view) => {
                let offset = accessor.byte_offset.map_or(0, |offset| offset.0);
                self.elements(index, what, layout(view.value(), offset))?
            }
            None => vec![[0.0; N]; count],
        };
        if let Some(sparse) = &accessor.sparse {
            let Checked::Valid(type_of_index) = &sparse.indices.component_type else {
                return Err(self.invalid(index, what, "has sparse indices of an unknown type"));
            };
            let changed = Layout { count: self.charge(sparse.count.0)?, ..layout(0, 0) };
            let at = Layout {
                view: sparse.indices.buffer_view.value(),
                offset: sparse.indices.byte_offset.0,
                component: type_of_index.0,
                normalized: false,
                ..changed
            };
            let new =
                Layout { view: sparse.values.buffer_view.value(), offset: sparse.values.byte_offset.0, ..changed };
            let (at, new) = (self.elements::<1>(index, what, at)?, self.elements(index, what, new)?);
            for ([at], new) in at.into_iter().zip(new) {
                let slot = values.get_mut(at as usize);
                *slot.ok_or_else(|| self.invalid(index, what, format_args!("has the sparse index {at}")))? = new;
            }
        }
        Ok(values)
    }

    fn elements<const N: usize>(&self, index: usize, what: &str, layout: Layout) -> Result<Vec<[f64; N]>, SceneError> {
        let (bytes, stride) = self.document.view(layout.view)?;
        let component_size = layout.component.size();
        let size = component_size * N;
        let stride = stride.filter(|&stride| stride > 0).unwrap_or(size);
        if stride < size {
            return Err(self.invalid(
                index,
                what,
                format_args!("has a stride of {stride} for elements of {size} bytes"),
            ));
        }
        let Some(last) = layout.count.checked_sub(1) else {
            return Ok(Vec::new());
        };
        let length = (last as u64).saturating_mul(stride as u64).saturating_add(size as u64);
        let data = slice(bytes, layout.offset, length)
            .ok_or_else(|| self.invalid(index, what, format_args!("takes more bytes than its buffer view has")))?;
        let element = |bytes: &[u8]| {
            std::array::from_fn(|k| component(layout.component, layout.normalized, &bytes[k * component_size..]))
        };
        Ok(data.chunks(stride).map(element).collect())
    }

    /// Takes `count` elements from the allowance, before memory is taken for them.
    fn charge(&self, count: u64) -> Result<usize, SceneError> {
        let taken = usize::try_from(count).ok().filter(|&count| count <= self.left.get());
        let taken = taken.ok_or_else(|| SceneError::TooLarge {
            path: self.document.path.clone(),
            what: "accessor elements",
            limit: MAX_ELEMENTS,
        })?;
        self.left.set(self.left.get() - taken);
        Ok(taken)
    }

    fn invalid(&self, index: usize, what: &str, problem: impl std::fmt::Display) -> SceneError {
        self.document.invalid(format!("accessor {index}, used for {what}, {problem}"))
    }
}

/// The component that `bytes` starts with; the normalisation is that of the glTF specification, section 3.6.2.2.
fn component(kind: ComponentType, normalized: bool, bytes: &[u8]) -> f64 {
    let (value, one) = match kind {
        ComponentType::I8 => (f64::from(i8::from_le_bytes([bytes[0]])), 127.0),
        ComponentType::U8 => (f64::from(bytes[0]), 255.0),
        ComponentType::I16 => (f64::from(i16::from_le_bytes([bytes[0], bytes[1]])), 32767.0),
        ComponentType::U16 => (f64::from(u16::from_le_bytes([bytes[0], bytes[1]])), 65535.0),
        ComponentType::U32 => (f64::from(u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]])), 4294967295.0),
        ComponentType::F32 => {
            return f64::from(f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]));
        }
    };
    if normalized { (value / one).max(-1.0) } else { value }
}
