//! A glTF document with its buffers: what the file says, before any of it is believed.
//!
//! Only the JSON schema of the `gltf` crate is used. Its readers and its validation index without checking, and so
//! panic on a broken file.

use std::path::{Path, PathBuf};

use gltf::json;

use super::SceneError;

/// Required extensions that are honoured, or that only change how a surface is shaded.
const HONOURED: &[&str] = &[
    "KHR_lights_punctual",
    "EXT_mesh_gpu_instancing",
    "KHR_mesh_quantization",
    "KHR_materials_anisotropy",
    "KHR_materials_clearcoat",
    "KHR_materials_dispersion",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_iridescence",
    "KHR_materials_sheen",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_variants",
    "KHR_materials_volume",
];

pub(super) struct Document {
    pub path: PathBuf,
    pub root: json::Root,
    /// `None` where the file names no data for the buffer, which is an error only once the buffer is used.
    buffers: Vec<Option<Vec<u8>>>,
}

impl Document {
    pub fn read(path: &Path) -> Result<Self, SceneError> {
        let bytes = read_file(path)?;
        let (text, binary) = split(path, &bytes)?;
        let root: json::Root = json::deserialize::from_slice(text)
            .map_err(|error| format_error(path, format!("its JSON does not parse, {error}")))?;
        check_version(path, &root.asset.version)?;
        check_extensions(path, &root.extensions_required)?;
        let buffers = root.buffers.iter().enumerate();
        let buffers =
            buffers.map(|(index, buffer)| read_buffer(path, index, buffer, binary)).collect::<Result<_, _>>()?;
        Ok(Self { path: path.to_owned(), root, buffers })
    }

    /// The bytes of a buffer view, and its stride where it states one.
    pub fn view(&self, index: usize) -> Result<(&[u8], Option<usize>), SceneError> {
        let view = self.item(&self.root.buffer_views, index, || "a buffer view".to_owned())?;
        let buffer = view.buffer.value();
        let data = self.item(&self.buffers, buffer, || format!("the buffer of buffer view {index}"))?;
        let data = data.as_deref().ok_or_else(|| self.invalid(format!("buffer {buffer} has no data")))?;
        let start = view.byte_offset.map_or(0, |offset| offset.0);
        let bytes = slice(data, start, view.byte_length.0).ok_or_else(|| {
            let (length, held) = (view.byte_length.0, data.len());
            self.invalid(format!("buffer view {index} takes {length} bytes at {start} of a buffer of {held}"))
        })?;
        Ok((bytes, view.byte_stride.map(|stride| stride.0)))
    }

    /// The file's image, still encoded.
    pub fn image_bytes(&self, index: usize) -> Result<Vec<u8>, SceneError> {
        let image = self.item(&self.root.images, index, || "the image of a texture".to_owned())?;
        match (image.buffer_view, &image.uri) {
            (Some(view), _) => Ok(self.view(view.value())?.0.to_vec()),
            (None, Some(uri)) => read_uri(&self.path, uri).map_err(|error| self.image_error(index, error)),
            (None, None) => Err(self.image_error(index, "it has neither a buffer view nor a URI")),
        }
    }

    /// `list[index]`, or an error that says what the index was for.
    pub fn item<'a, T>(&self, list: &'a [T], index: usize, what: impl Fn() -> String) -> Result<&'a T, SceneError> {
        list.get(index).ok_or_else(|| SceneError::Index {
            path: self.path.clone(),
            what: what(),
            index: index as u64,
            count: list.len(),
        })
    }

    pub fn invalid(&self, what: impl Into<String>) -> SceneError {
        SceneError::Invalid { path: self.path.clone(), what: what.into() }
    }

    pub fn image_error(&self, image: usize, reason: impl ToString) -> SceneError {
        SceneError::Image { path: self.path.clone(), image, reason: reason.to_string() }
    }
}

/// `data[start..start + length]` unless that runs past the end.
pub(super) fn slice(data: &[u8], start: u64, length: u64) -> Option<&[u8]> {
    let end = usize::try_from(start.checked_add(length)?).ok()?;
    data.get(usize::try_from(start).ok()?..end)
}

fn read_file(path: &Path) -> Result<Vec<u8>, SceneError> {
    std::fs::read(path).map_err(|source| SceneError::Read { path: path.to_owned(), source })
}

fn format_error(path: &Path, reason: impl ToString) -> SceneError {
    SceneError::Format { path: path.to_owned(), reason: reason.to_string() }
}

/// The JSON and the binary chunk of a `.glb`, or a `.gltf` as it is.
fn split<'a>(path: &Path, bytes: &'a [u8]) -> Result<(&'a [u8], Option<&'a [u8]>), SceneError> {
    if !bytes.starts_with(b"glTF") {
        return Ok((bytes, None));
    }
    let word = |at: usize| bytes.get(at..at + 4).map(|word| u32::from_le_bytes([word[0], word[1], word[2], word[3]]));
    match word(4) {
        Some(2) => {}
        Some(version) => {
            return Err(format_error(path, format!("its container has version {version}")));
        }
        None => return Err(format_error(path, "it ends within its header")),
    }
    let chunk = |at: usize, kind: &[u8; 4]| {
        let name = String::from_utf8_lossy(kind).trim_end_matches('\0').to_owned();
        let cut = || format_error(path, format!("it ends within its {name} chunk, at byte {}", bytes.len()));
        let length = word(at).ok_or_else(cut)?;
        if bytes.get(at + 4..at + 8) != Some(kind) {
            return Err(format_error(path, format!("there is no {name} chunk at byte {at}")));
        }
        slice(bytes, at as u64 + 8, length.into()).ok_or_else(cut)
    };
    let text = chunk(12, b"JSON")?;
    let next = 20 + text.len();
    let binary = if bytes.len() > next { Some(chunk(next, b"BIN\0")?) } else { None };
    Ok((text, binary))
}

fn check_version(path: &Path, version: &str) -> Result<(), SceneError> {
    if version.split('.').next() == Some("2") {
        return Ok(());
    }
    Err(format_error(path, format!("its asset version is {version:?}")))
}

fn check_extensions(path: &Path, required: &[String]) -> Result<(), SceneError> {
    let Some(extension) = required.iter().find(|name| !HONOURED.contains(&name.as_str())) else {
        return Ok(());
    };
    let remedy = match extension.as_str() {
        "KHR_draco_mesh_compression" | "EXT_meshopt_compression" | "KHR_meshopt_compression" => {
            "decompress the file, for example with `gltf-transform copy`"
        }
        "KHR_texture_transform" => "bake the transforms into the texture coordinates",
        "KHR_texture_basisu" | "EXT_texture_webp" | "EXT_texture_avif" => "convert its images to PNG or JPEG",
        _ => "export it without that extension",
    };
    Err(SceneError::Extension { path: path.to_owned(), extension: extension.clone(), remedy })
}

fn read_buffer(
    path: &Path,
    index: usize,
    buffer: &json::Buffer,
    binary: Option<&[u8]>,
) -> Result<Option<Vec<u8>>, SceneError> {
    let data = match &buffer.uri {
        Some(uri) => Some(read_uri(path, uri)?),
        None if index == 0 => binary.map(<[u8]>::to_vec),
        None => None,
    };
    let declared = buffer.byte_length.0;
    if let Some(held) = data.as_ref().map(Vec::len).filter(|&held| (held as u64) < declared) {
        return Err(format_error(path, format!("buffer {index} has {held} bytes where {declared} are declared")));
    }
    Ok(data)
}

/// The bytes behind a `data:` URI, or of a file named relative to `path`.
fn read_uri(path: &Path, uri: &str) -> Result<Vec<u8>, SceneError> {
    if let Some(rest) = uri.strip_prefix("data:") {
        let (_, text) =
            rest.split_once(";base64,").ok_or_else(|| format_error(path, "it has a data URI that is not in base64"))?;
        return decode_base64(text).ok_or_else(|| format_error(path, "it has a data URI with broken base64"));
    }
    let named = percent_decode(uri).filter(|name| !name.contains("://"));
    let named = named.ok_or_else(|| format_error(path, format!("the URI {uri:?} does not name a local file")))?;
    read_file(&path.with_file_name("").join(named))
}

fn percent_decode(uri: &str) -> Option<String> {
    let mut out = Vec::with_capacity(uri.len());
    let mut rest = uri.as_bytes();
    while let Some((&byte, tail)) = rest.split_first() {
        let escaped = (byte == b'%').then(|| tail.get(..2)).flatten();
        let escaped = escaped.and_then(|hex| u8::from_str_radix(std::str::from_utf8(hex).ok()?, 16).ok());
        out.push(escaped.unwrap_or(byte));
        rest = if escaped.is_some() { &tail[2..] } else { tail };
    }
    String::from_utf8(out).ok()
}

fn decode_base64(text: &str) -> Option<Vec<u8>> {
    let digit = |byte: u8| match byte {
        b'A'..=b'Z' => Some(byte - b'A'),
        b'a'..=b'z' => Some(byte - b'a' + 26),
        b'0'..=b'9' => Some(byte - b'0' + 52),
        b'+' => Some(62),
        b'/' => Some(63),
        _ => None,
    };
    let text = text.trim_end_matches('=').as_bytes();
    let mut out = Vec::with_capacity(text.len() * 3 / 4);
    for group in text.chunks(4) {
        let bits = group.iter().try_fold(0_u32, |bits, &byte| Some(bits << 6 | u32::from(digit(byte)?)))?;
        let missing = 4 - group.len();
        let bytes = (bits << (6 * missing)).to_be_bytes();
        // A group of one digit holds no whole byte.
        out.extend_from_slice(bytes.get(1..4 - missing).filter(|bytes| !bytes.is_empty())?);
    }
    Some(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_matches_the_examples_of_rfc_4648() {
        let cases =
            [("", ""), ("Zg==", "f"), ("Zm8=", "fo"), ("Zm9v", "foo"), ("Zm9vYg==", "foob"), ("Zm9vYmFy", "foobar")];
        for (text, plain) in cases {
            assert_eq!(decode_base64(text).as_deref(), Some(plain.as_bytes()), "{text:?}");
        }
        assert_eq!(decode_base64("Z"), None);
        assert_eq!(decode_base64("Zg!="), None);
    }

    #[test]
    fn percent_escapes_are_decoded_and_stray_signs_kept() {
        assert_eq!(percent_decode("a%20b.bin").as_deref(), Some("a b.bin"));
        assert_eq!(percent_decode("100%.bin%2").as_deref(), Some("100%.bin%2"));
        assert_eq!(percent_decode("%ff"), None);
    }
}
