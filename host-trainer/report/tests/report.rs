//! The page as text. What it does in a browser is tested in `tests/tests/report_page.rs`.

use covey_report::report::{
    Better, Cell, Chart, Column, Content, Episode, Estimate, Figure, Frame, Group, Reference, Report, ReportError, Row,
    Run, Section, Series, Table, chart_svg, comparison, episode_svg,
};
use proptest::prelude::*;

fn section(content: Content) -> Report {
    let section = Section { title: "Part".into(), lead: String::new(), content };
    Report { title: "Run".into(), subtitle: String::new(), sections: vec![section] }
}

fn episode() -> Episode {
    let frame = |x: f32, covered: [bool; 5], coverage| Frame {
        uavs: vec![[x, 20.0], [30.0, 40.0], [35.0, 41.0]],
        edges: vec![[1, 2]],
        covered: covered.to_vec(),
        coverage,
        actions: vec![0, 16, 8],
    };
    Episode {
        title: "World <1>".into(),
        side_u: 100.0,
        coverage_range_u: 10.0,
        observation_range_u: 13.0,
        communication_range_u: 18.0,
        pois: vec![[1.0, 2.0], [3.0, 4.0], [30.0, 44.0], [99.996, 0.0], [12.345, 20.0]],
        action_names: vec!["east".into()],
        frames: vec![
            frame(10.0, [false, false, true, false, false], 0.2),
            frame(14.0, [false, false, true, false, true], 0.4),
            frame(18.0, [false, true, true, false, true], 0.6),
        ],
    }
}

fn series(name: &str, points: &[(f64, f64)]) -> Series {
    Series { name: name.into(), points: points.to_vec(), band: None }
}

#[test]
fn every_text_is_escaped_wherever_it_stands() {
    let evil = r#"</script><img src=x onerror="a('&')">"#.to_string();
    let sections = [
        Content::Figures(vec![Figure {
            label: evil.clone(),
            value: Estimate::exact(1.0, 0),
            unit: evil.clone(),
            note: evil.clone(),
        }]),
        Content::Table(Table {
            corner: evil.clone(),
            columns: vec![Column { name: evil.clone(), unit: evil.clone(), better: Better::Higher }],
            rows: vec![Row { name: evil.clone(), emphasis: true, cells: vec![Cell::Text(evil.clone())] }],
            caption: evil.clone(),
        }),
        Content::Configuration(vec![Group { name: evil.clone(), entries: vec![(evil.clone(), evil.clone())] }]),
        Content::Charts(vec![Chart {
            title: evil.clone(),
            x_label: evil.clone(),
            y_label: evil.clone(),
            series: vec![series(&evil, &[(0.0, 1.0), (1.0, 2.0)]), series("b", &[])],
            references: vec![Reference { name: evil.clone(), y: 1.5 }],
            y_range: None,
        }]),
        Content::Episodes(vec![Episode { title: evil.clone(), action_names: vec![evil.clone()], ..episode() }; 2]),
        Content::Text,
    ];
    let report = Report {
        title: evil.clone(),
        subtitle: evil.clone(),
        sections: sections.map(|content| Section { title: evil.clone(), lead: evil.clone(), content }).into(),
    };
    let html = report.html().unwrap();
    assert!(!html.contains("<img") && !html.contains("onerror=\""), "unescaped text");
    assert_eq!(html.matches("<script").count(), html.matches("</script>").count());
    assert!(
        !chart_svg(&match &report.sections[3].content {
            Content::Charts(charts) => charts[0].clone(),
            _ => unreachable!("the fourth section holds charts"),
        })
        .unwrap()
        .contains("<img")
    );
}

#[test]
fn the_page_asks_nothing_of_the_network_and_is_the_same_each_time() {
    let report = section(Content::Episodes(vec![episode()]));
    let html = report.html().unwrap();
    for reference in ["http://", "https://", "src=", "@import", "url("] {
        let allowed = if reference == "http://" { html.matches("http://www.w3.org/2000/svg").count() } else { 0 };
        assert_eq!(html.matches(reference).count(), allowed, "{reference}");
    }
    assert!(html.contains("default-src 'none'"));
    assert_eq!(html, report.html().unwrap());
}

#[test]
fn an_episode_is_carried_in_short_form() {
    let html = section(Content::Episodes(vec![episode()])).html().unwrap();
    let json = html.split("<script type=\"application/json\">").nth(1).unwrap().split("</script>").next().unwrap();
    let data: serde_json::Value = serde_json::from_str(json).unwrap();
    assert_eq!(data[0]["title"], "World <1>");
    assert_eq!(data[0]["pois"], serde_json::json!([100, 200, 300, 400, 3000, 4400, 10000, 0, 1235, 2000]));
    assert_eq!(
        data[0]["frames"][2],
        serde_json::json!({"p": [1800, 2000, 3000, 4000, 3500, 4100], "l": [1, 2], "c": "61", "v": 0.6, "a": [0, 16, 8]})
    );
}

#[test]
fn the_spawn_state_is_not_scored() {
    let episode = episode();
    assert_eq!(episode.steps(), 2);
    assert_eq!([0, 1, 2, 9].map(|n| episode.coverage_so_far(n)), [0.0, 0.4, 0.5, 0.5]);
    assert_eq!(Episode::default().coverage_so_far(3), 0.0);
}

/// One way to spoil an episode, and what the error must say.
type Spoilt = (fn(&mut Episode), &'static str);

#[test]
fn lists_that_do_not_fit_are_named() {
    let spoilt: [Spoilt; 8] = [
        (|e| e.frames.clear(), "no frames"),
        (|e| e.frames[1].uavs.truncate(2), "step 1: 2 UAVs where there should be 3"),
        (|e| e.frames[2].covered.push(true), "step 2: 6 PoI states where there should be 5"),
        (|e| e.frames[0].actions.truncate(1), "step 0: 1 actions where there should be 3"),
        (|e| e.frames[1].edges.push([0, 3]), "edge [0, 3] names a UAV beyond the 3"),
        (|e| e.side_u = 0.0, "side of the map must be a finite number above 0"),
        (|e| e.pois[0][1] = f32::NAN, "position of every PoI must be a finite number"),
        (|e| e.frames[1].coverage = f32::INFINITY, "coverage of every step"),
    ];
    for (spoil, message) in spoilt {
        let mut episode = episode();
        spoil(&mut episode);
        let error = section(Content::Episodes(vec![episode.clone()])).html().unwrap_err().to_string();
        assert!(error.contains(message), "{error}");
        assert_eq!(episode_svg(&episode, 0).unwrap_err().to_string(), error);
    }
}

#[test]
fn a_uav_that_is_not_there_is_left_out() {
    let mut gone = episode();
    gone.frames[1].uavs[2] = [f32::NAN, 0.0];
    let html = section(Content::Episodes(vec![gone.clone()])).html().unwrap();
    assert!(html.contains("[1400,2000,3000,4000,null,0]"));
    let svg = episode_svg(&gone, 1).unwrap();
    assert!(!svg.contains("NaN"));
    assert_eq!(svg.matches("class=\"uav\"").count(), 2);
}

#[test]
fn one_moment_as_a_picture() {
    let svg = episode_svg(&episode(), 2).unwrap();
    assert!(svg.contains("World &lt;1&gt;: step 2 of 2, 60 % of the PoIs covered"));
    assert_eq!(svg.matches("class=\"covered\"").count(), 3);
    assert_eq!(svg.matches("class=\"open\"").count(), 2);
    // The first UAV flew east; the others stood.
    assert!(svg.contains("rotate(-0)") || svg.contains("rotate(0)"));
    assert_eq!(svg.matches("class=\"uav\"").count(), 3);
    let error = episode_svg(&episode(), 3).unwrap_err();
    assert!(matches!(error, ReportError::Step { step: 3, last: 2, .. }), "{error}");
}

#[test]
fn the_best_figure_of_a_column_is_marked_as_the_reader_sees_it() {
    let value = |mean| Cell::Value(Estimate { mean, standard_error: Some(0.0004), decimals: 2 });
    let row = |name: &str, a, b| Row { name: name.into(), emphasis: false, cells: vec![value(a), value(b)] };
    let column = |better| Column { name: "c".into(), unit: String::new(), better };
    let table = Table {
        columns: vec![column(Better::Higher), column(Better::Lower)],
        rows: vec![row("a", 0.501, 0.9), row("b", 0.499, f64::NAN), row("c", 0.2, 0.3)],
        ..Table::default()
    };
    let html = section(Content::Table(table)).html().unwrap();
    assert_eq!(html.matches("class=\"best\"").count(), 3);
    assert!(html.contains("0.50 <small>± 0.0004</small>"), "an error is never shown as 0");
}

#[test]
fn samples_give_mean_and_standard_error() {
    let estimate = Estimate::of(&[1.0, 2.0, 3.0, 4.0], 2);
    assert_eq!(estimate.mean, 2.5);
    assert!((estimate.standard_error.unwrap() - (5.0f64 / 3.0 / 4.0).sqrt()).abs() < 1e-12);
    assert_eq!(Estimate::of(&[7.0], 0).standard_error, None);
    assert!(Estimate::of(&[], 0).mean.is_nan());
}

#[test]
fn a_noisy_curve_becomes_means_with_a_band() {
    let points: Vec<_> = (0..10).map(|i| (f64::from(i), f64::from(i % 2))).chain([(10.0, f64::NAN)]).collect();
    let binned = Series::binned("a", &points, 5);
    assert_eq!(binned.points, [(0.5, 0.5), (2.5, 0.5), (4.5, 0.5), (6.5, 0.5), (8.5, 0.5)]);
    assert_eq!(binned.band.unwrap()[0], (0.0, 1.0));
    assert_eq!(Series::binned("a", &points[..3], 5), series("a", &points[..3]));
}

#[test]
fn a_band_of_another_length_is_refused() {
    let s = Series { band: Some(vec![(0.0, 1.0)]), ..series("a", &[(0.0, 0.0), (1.0, 1.0)]) };
    let chart = Chart { title: "Loss".into(), series: vec![s], ..Chart::default() };
    assert!(matches!(chart_svg(&chart), Err(ReportError::Band { points: 2, band: 1, .. })));
    assert!(section(Content::Charts(vec![chart])).html().is_err());
}

#[test]
fn a_comparison_lays_curves_over_each_other_and_shows_what_differs() {
    let run = |name: &str, rate: &str, coverage| Run {
        name: name.into(),
        figures: vec![(
            Figure {
                label: "coverage".into(),
                value: Estimate::exact(coverage, 3),
                unit: String::new(),
                note: String::new(),
            },
            Better::Higher,
        )],
        configuration: vec![Group {
            name: "Training".into(),
            entries: vec![("rate".into(), rate.into()), ("seed".into(), "10".into())],
        }],
        charts: vec![Chart {
            title: "Coverage".into(),
            series: vec![series("this run", &[(0.0, 0.2), (1.0, coverage)])],
            ..Chart::default()
        }],
    };
    let report = comparison("Two runs", "", &[run("GCN", "5e-4", 0.6), run("GAT", "3e-4", 0.61)]);
    let [results, curves, settings] = report.sections.as_slice() else { panic!("three sections") };
    assert!(matches!(&results.content, Content::Table(t) if t.rows.len() == 2 && t.columns.len() == 1));
    let Content::Charts(charts) = &curves.content else { panic!("charts") };
    assert_eq!(charts[0].series.iter().map(|s| s.name.as_str()).collect::<Vec<_>>(), ["GCN", "GAT"]);
    let Content::Table(differences) = &settings.content else { panic!("a table") };
    assert_eq!(differences.rows.len(), 1);
    assert_eq!(differences.rows[0].name, "Training: rate");
    assert!(report.html().is_ok());

    let same = comparison("Same", "", &[run("a", "1", 0.5), run("b", "1", 0.5)]);
    assert_eq!(same.sections[2].content, Content::Text);
    assert!(comparison("None", "", &[]).html().is_ok());
}

#[test]
fn the_page_is_written_into_a_folder_that_is_made() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a/b/report.html");
    let report = section(Content::Text);
    report.write(&path).unwrap();
    assert_eq!(std::fs::read_to_string(&path).unwrap(), report.html().unwrap());
    let error = report.write(path.join("below/report.html")).unwrap_err();
    assert!(matches!(error, ReportError::Folder { .. }), "{error}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn any_numbers_make_a_chart_with_finite_places(
        points in prop::collection::vec((any::<f64>(), any::<f64>()), 0..40),
        level in any::<f64>(),
    ) {
        let band = Some(points.iter().map(|&(x, y)| (y, x)).collect());
        let chart = Chart {
            series: vec![Series { name: "a".into(), points, band }],
            references: vec![Reference { name: "level".into(), y: level }],
            ..Chart::default()
        };
        let svg = chart_svg(&chart).unwrap();
        prop_assert!(!svg.contains("NaN") && !svg.contains("inf"));
        let html = section(Content::Charts(vec![chart])).html().unwrap();
        prop_assert!(!html.contains("NaN ") && !html.contains("MNaN") && !html.contains("inf%"));
    }

    #[test]
    fn a_report_survives_json(coverage in 0.0f32..1.0) {
        let mut e = episode();
        e.frames[1].coverage = coverage;
        let report = section(Content::Episodes(vec![e]));
        let back: Report = serde_json::from_str(&serde_json::to_string(&report).unwrap()).unwrap();
        prop_assert_eq!(back, report);
    }
}
