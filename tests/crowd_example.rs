//! The example `crowd` as it is run: figures, a table and a picture.

use std::path::Path;
use std::process::Command;

#[test]
fn a_few_lights_and_figures() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("crowd_example");
    let _ = std::fs::remove_dir_all(&folder);
    let json = folder.join("crowd.json");
    let profile: &[&str] = if cfg!(debug_assertions) { &[] } else { &["--release"] };
    let mut command = Command::new(env!("CARGO"));
    command.current_dir(env!("CARGO_MANIFEST_DIR")).args(["run", "--quiet"]).args(profile);
    command.args(["--example", "crowd", "--", "--lights", "2", "--instances", "5", "--walking", "3", "--frames", "1"]);
    command.args(["--resolution", "48", "-o"]).arg(&folder).arg("--json").arg(&json);
    let output = command.output().expect("cargo doesn't start");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let printed = String::from_utf8_lossy(&output.stdout);
    assert!(["| frame", "| median", "this / cube"].iter().all(|part| printed.contains(part)), "{printed}");

    let figures: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(&json).unwrap()).unwrap();
    assert_eq!((&figures["lights"], &figures["instances"]), (&2.into(), &5.into()));
    // Five figures, two lamps' posts of 44 triangles, two trees with seven leaf cards each, the banner with two posts
    // of its own, and the ground.
    assert_eq!(figures["triangles"], 5 * 990 + 2 * 44 + 2 * (44 + 14) + (3200 + 2 * 44) + 12);
    assert!(!figures["adapter"].as_str().unwrap().is_empty());
    for key in ["frame_ms_median", "record_cpu_us_median", "cube_frame_ms_median", "cube_record_cpu_us_median"] {
        assert!(figures[key].as_f64().unwrap() > 0.0, "{key}: {figures}");
    }
    let picture = image::open(folder.join("frame-000.png")).unwrap().to_rgb8();
    let lit = picture.pixels().filter(|pixel| pixel.0.iter().any(|channel| *channel > 100)).count();
    assert!(lit > 10_000, "{lit} bright pixels");
}
