//! Missions as users have them, one file a kind: what is read of each, or what is said, stands in `cases.txt`, word by
//! word. `COVEY_BLESS=1 cargo test -p sitl-bridge --test files cases` writes it anew.

use sitl_bridge::mission::Loaded;
use std::fs;
use std::path::Path;

#[test]
fn every_kind_of_file_is_read_or_refused_in_these_words() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/files");
    let mut names: Vec<_> =
        fs::read_dir(folder.join("cases")).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    names.sort();
    assert!(names.len() >= 46, "{} cases", names.len());
    let mut said = String::new();
    for name in names {
        let bytes = fs::read(folder.join("cases").join(&name)).unwrap();
        let words = match Loaded::from_bytes(&bytes, Path::new(&name)) {
            Ok(Loaded { mission, format, remarks }) => {
                let (pois, corners) = (mission.pois.len(), mission.fence.len());
                let remarks: String = remarks.iter().map(|remark| format!("\n{remark}")).collect();
                format!("read as {format}: PoIs {pois}, corners {corners}{remarks}")
            }
            Err(error) => format!("refused: {error}"),
        };
        said += &format!("== {}\n{words}\n", name.to_string_lossy());
    }
    let golden = folder.join("cases.txt");
    if std::env::var_os("COVEY_BLESS").is_some() {
        fs::write(&golden, &said).unwrap();
    }
    let expected = fs::read_to_string(&golden).unwrap();
    for (said, expected) in said.split("== ").zip(expected.split("== ")) {
        assert_eq!(said, expected);
    }
    assert_eq!(said, expected);
}
