//! The example `render` as it is run: pictures that are pictures, errors that are one line.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// Where a test writes; under the build's own folder.
fn path(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("render_example");
    std::fs::create_dir_all(&folder).unwrap();
    folder.join(name)
}

fn render(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO"));
    let profile: &[&str] = if cfg!(debug_assertions) { &[] } else { &["--release"] };
    command.current_dir(env!("CARGO_MANIFEST_DIR")).args(["run", "--quiet"]).args(profile);
    command.args(["--example", "render", "--"]).args(arguments);
    command
}

fn run(arguments: &[&str]) -> Output {
    render(arguments).output().expect("cargo doesn't start")
}

fn utf8(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// Lines that the example itself printed, without what a driver has to say.
fn complaints(output: &Output) -> Vec<String> {
    utf8(&output.stderr).lines().filter(|line| line.starts_with("render: ")).map(str::to_owned).collect()
}

/// Runs it, and returns the picture and what was printed.
fn picture(name: &str, arguments: &[&str]) -> (image::RgbImage, String) {
    let file = path(name);
    let _ = std::fs::remove_file(&file);
    let output = run(&[&["--size", "96x54", "--resolution", "128", "-o", file.to_str().unwrap()], arguments].concat());
    assert!(output.status.success(), "{}", utf8(&output.stderr));
    (image::open(&file).unwrap().to_rgb8(), utf8(&output.stdout))
}

fn share(picture: &image::RgbImage, of: impl Fn([u8; 3]) -> bool) -> f32 {
    let count = picture.pixels().filter(|pixel| of(pixel.0)).count();
    count as f32 / (picture.width() * picture.height()) as f32
}

fn assert_fails(arguments: &[&str], with: &str) {
    let output = run(arguments);
    assert_eq!(output.status.code(), Some(1), "{arguments:?}: {}", utf8(&output.stderr));
    let lines = complaints(&output);
    assert_eq!(lines.len(), 1, "{arguments:?}: {}", utf8(&output.stderr));
    assert!(lines[0].contains(with), "{arguments:?}: {lines:?}");
    assert!(!utf8(&output.stderr).contains("panicked"), "{arguments:?}: {}", utf8(&output.stderr));
}

/// A file of its own with a binary glTF container around `json`.
fn glb(name: &str, json: &str) -> PathBuf {
    let mut chunk = json.as_bytes().to_vec();
    chunk.resize(chunk.len().next_multiple_of(4), b' ');
    let mut file = b"glTF".to_vec();
    for word in [2, chunk.len() as u32 + 20, chunk.len() as u32] {
        file.extend(word.to_le_bytes());
    }
    file.extend(b"JSON");
    file.extend(chunk);
    let path = path(name);
    std::fs::write(&path, file).unwrap();
    path
}

#[test]
fn the_hall_has_light_and_shadow() {
    let (picture, printed) = picture("new folder/hall.png", &[]);
    assert_eq!(picture.dimensions(), (96, 54));
    let (bright, dark) = (share(&picture, |p| p[1] > 150), share(&picture, |p| p[1] < 50));
    assert!(bright > 0.1 && dark > 0.1, "bright {bright}, dark {dark}");
    for word in ["adapter", "142,464 triangles in", "light", "maps made", "large", "total", "hall.png"] {
        assert!(printed.contains(word), "{word} is missing in:\n{printed}");
    }
}

#[test]
fn views_and_the_map_show_what_they_say() {
    let (shadow, _) = picture("shadow.png", &["--view", "shadow"]);
    let grey = share(&shadow, |p| p[0] == p[1] && p[1] == p[2]);
    let (lit, dark) = (share(&shadow, |p| p[1] == 255), share(&shadow, |p| p[1] == 0));
    assert!(grey == 1.0 && lit > 0.2 && dark > 0.1, "grey {grey}, lit {lit}, dark {dark}");

    let (hemispheres, _) = picture("hemisphere.png", &["--view", "hemisphere"]);
    let (front, back) = (share(&hemispheres, |p| p[0] > p[2]), share(&hemispheres, |p| p[2] > p[0]));
    assert!(front > 0.2 && back > 0.1, "front {front}, back {back}");

    let map = path("map.png");
    let (texels, _) = picture("texels.png", &["--view", "texels", "--map", map.to_str().unwrap()]);
    assert_ne!(texels, picture("lit.png", &[]).0);
    let map = image::open(map).unwrap().to_rgb8();
    assert_eq!(map.dimensions(), (256, 128));
    let (corner, middle) = (map.get_pixel(0, 0).0, map.get_pixel(64, 64).0);
    assert!(corner[2] > corner[0] && middle[0] == middle[2] && middle[0] > 0, "{corner:?} {middle:?}");
}

#[test]
fn soft_lights_have_penumbras_and_little_error() {
    let orange = |p: [u8; 3]| p[0] > p[2].saturating_add(60);
    let soft = ["--filter", "soft", "--light-radius", "0.05"];
    let view = |name: &str, view: &str, filter: &[&str]| picture(name, &[&["--view", view], filter].concat()).0;
    let wide = share(&view("soft.png", "penumbra", &soft), orange);
    let narrow = share(&view("hard.png", "penumbra", &["--filter", "hard"]), orange);
    assert!(wide > 0.2 && narrow < 0.2 * wide, "{wide} {narrow}");
    let bias = view("bias.png", "bias", &[]);
    assert!(share(&bias, |p| p[0] == p[1] && p[1] == p[2] && p[0] > 0) > 0.9);
    let wrong = |filter: &[&str]| share(&view("error.png", "error", filter), |p| p[0].abs_diff(p[2]) > 60);
    let (soft, point) = (wrong(&soft), wrong(&["--filter", "hard"]));
    assert!(soft < 0.1 && point > 0.0 && point < 0.1, "soft {soft}, point {point}");
}

/// On the left is what ray casting has on the right; a cube of as many bytes is farther from that.
#[test]
fn shadows_are_set_side_by_side() {
    let arguments = ["--view", "versus", "--camera", "1.5,2.6,6.5", "--look-at=-2.6,0.7,0"];
    let (picture, _) = picture("versus.png", &arguments);
    let (across, height) = picture.dimensions();
    let width = (across - 8) / 3;
    let differing = |panel: u32| {
        let level = |panel: u32, x: u32, y: u32| picture.get_pixel(panel * (width + 4) + x, y).0[0];
        let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        places.filter(|&(x, y)| level(panel, x, y).abs_diff(level(2, x, y)) > 24).count()
    };
    let [own, cube] = [0, 1].map(differing);
    assert!(cube > 50 && own < cube / 2, "{own} pixels differ, {cube} of the cube's");
}

#[test]
fn lights_and_camera_are_where_they_are_put() {
    let arguments = ["--light", "-2,1,3", "--light", "4,-0.5,-6", "--range", "9"];
    let view = ["--camera", "-1,2,-3", "--look-at", "0,1,-9", "--fov", "50"];
    let (_, printed) = picture("placed.png", &[&arguments[..], &view[..]].concat());
    for line in [
        "at -2.000,1.000,3.000, range 9.0000 (given)",
        "at 4.000,-0.500,-6.000, range 9.0000 (given)",
        "at -1.000,2.000,-3.000, looking at 0.000,1.000,-9.000, 50 degrees",
    ] {
        assert!(printed.contains(line), "{line} is missing in:\n{printed}");
    }
}

#[test]
fn files_that_cannot_be_rendered_are_one_line() {
    assert_fails(&["no such file.glb"], "no such file.glb");
    let garbage = path("garbage.glb");
    std::fs::write(&garbage, [7u8; 999]).unwrap();
    assert_fails(&[garbage.to_str().unwrap()], "garbage.glb");
    let empty = r#"{"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": []}]}"#;
    let empty = glb("empty.glb", empty);
    assert_fails(&[empty.to_str().unwrap()], "no triangle");
}

#[test]
fn values_out_of_range_are_one_line() {
    assert_fails(&["--range", "-3"], "-3");
    assert_fails(&["--filter", "soft", "--light-radius", "nan"], "light radius is NaN");
    assert_fails(&["--resolution", "0"], "resolution");
    assert_fails(&["--camera", "1,2,3", "--look-at", "1,2,3"], "--look-at");
    assert_fails(&["--size", "99999x10"], "99999x10");
    let file = path("a file");
    std::fs::write(&file, "").unwrap();
    let below = file.join("picture.png");
    assert_fails(&["--size", "96x54", "--resolution", "64", "-o", below.to_str().unwrap()], "a file");
}

#[test]
fn arguments_that_make_no_sense_are_usage_errors() {
    for wrong in [["--light", "1,2"], ["--light", "1,x,3"], ["--camera", "nan,0,0"], ["--size", "0x9"], ["--view", "x"]]
    {
        assert_eq!(run(&wrong).status.code(), Some(2), "{wrong:?}");
    }
}

#[test]
#[cfg(target_os = "linux")]
fn without_an_adapter_the_remedy_is_named() {
    let output =
        render(&[]).env("VK_DRIVER_FILES", "/none.json").env("VK_ICD_FILENAMES", "/none.json").output().unwrap();
    assert_eq!(output.status.code(), Some(1), "{}", utf8(&output.stderr));
    let lines = complaints(&output);
    assert!(lines.len() == 1 && lines[0].contains("mesa-vulkan-drivers"), "{}", utf8(&output.stderr));
}
