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
        "across.png",
    ] {
        assert!(folder.path().join("out").join(name).is_file(), "{name}");
    }
}

#[test]
fn what_cannot_be_flown_is_refused_with_the_reason_and_writes_nothing() {
    for (more, reason) in [
        (
            "[drone]\nspeed_m_s = 2.0\n",
            "aliases beyond 0.049 m: fly at 0.71 m/s or slower",
        ),
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
