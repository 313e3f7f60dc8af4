//! `acerra plan` as a user runs it.

use assert_cmd::Command;

const AREA: &str = "[area]\ncorners_deg = [[40.9, 14.2], [40.9, 14.2005], [40.9002, 14.2005]]\n\
                    [want]\nalong_m = 0.06\nacross_m = 0.5\nrcs_dbsm = 10\n";

fn plan(text: &str, arguments: &[&str]) -> (std::process::Output, tempfile::TempDir) {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("plan.toml"), text).expect("written");
    let mut command = Command::cargo_bin("acerra").expect("the binary");
    let output = command
        .current_dir(folder.path())
        .args(["plan", "plan.toml"])
        .args(arguments)
        .output()
        .expect("runs");
    (output, folder)
}

#[test]
fn a_plan_writes_its_files_and_answers() {
    let (output, folder) = plan(AREA, &["-o", "out", "--json"]);
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let answer: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert!(answer["step_m"].as_f64() < answer["longest_step_m"].as_f64());
    for name in [
        "plan.json",
        "plan.geojson",
        "plan.kml",
        "plan.plan",
        "plan.waypoints",
        "plan-dji.kmz",
        "plan-ugcs.csv",
        "across.png",
    ] {
        assert!(folder.path().join("out").join(name).is_file(), "{name}");
    }
}

/// As fast as the paper's campaign and the demonstration are flown: the band spreads the aliases.
#[test]
fn a_speed_that_aliases_faintly_is_flown_and_said() {
    let (output, _folder) = plan(&format!("{AREA}[drone]\nspeed_m_s = 2.0\n"), &["--json"]);
    let answer: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert!(answer["step_m"].as_f64() > answer["longest_step_m"].as_f64());
    let alias_db = answer["alias_db"].as_f64().expect("a level");
    assert!((-40.0..-13.3).contains(&alias_db), "{alias_db}");
    let warnings = answer["warnings"].to_string();
    assert!(warnings.contains("alias within the view"), "{warnings}");
    assert!(!warnings.contains("limit the aperture"), "{warnings}");
}

/// A narrow band leaves aliases nearly as strong as their targets.
#[test]
fn a_speed_that_aliases_strongly_is_refused() {
    let text = AREA.replace("across_m = 0.5", "across_m = 1.5")
        + "[radar]\nband_ghz = [3.7, 4.2]\nbeam_deg = 45\n[drone]\nspeed_m_s = 5.0\n";
    let (output, _folder) = plan(&text, &[]);
    let error = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{error}");
    assert!(
        error.contains("aliases beyond 0.056 m") && error.contains("fly at 0.81 m/s"),
        "{error}"
    );
}

#[test]
fn what_cannot_be_flown_is_refused_with_the_reason_and_writes_nothing() {
    for (more, reason) in [
        (
            "[drone]\nmin_height_m = -1\n",
            "expected 0.5 to 10000 m, found -1",
        ),
        ("[radar]\nband_ghz = [3.1, 3.1]\n", "a band of some width"),
        (
            "[radar]\nbeam_deg = 20\n",
            "cannot be had: the beam of 20° resolves 0.109 m at best",
        ),
        (
            "[radar]\npower_dbm = -60\n",
            "no height from 3 to 30 m will do",
        ),
    ] {
        let (output, folder) = plan(&format!("{AREA}{more}"), &["-o", "out"]);
        let error = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{error}");
        assert!(
            error.starts_with("acerra: plan.toml: ") && error.contains(reason),
            "{error}"
        );
        assert!(!folder.path().join("out").exists() && output.stdout.is_empty());
    }
}
